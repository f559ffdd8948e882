//! Online studies: measured forces against predicted ones.

use std::{f64::consts::TAU, path::Path};

use kinetostat::{
    process::uncertainty::{Distribution, normal_cdf},
    questions::{
        Overrides, Study, StudyKind,
        online::{Band, BreakEven, LoopGain, OnlineResults, Residual, Sensor, Trial, run},
    },
    work::Work,
};
use nalgebra::Vector3;
use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;

use crate::support::{
    command::told,
    uncertain::{LEVER, force, study_text},
};

/// A circle on the Orthoglide; `online` and `process` are added to their tables.
fn study(online: &str, process: &str) -> Study {
    let text = format!(
        r#"
schema = 3
question = "q"
machine = "orthoglide"
[online]
circle = {{ centre_mm = [0.0, 0.0, 0.0], diameter_mm = 40.0, points = 37 }}
feed_mm_per_min = 600.0
{online}
[process]
placement.reference = "platform_point"
[process.force.path_frame]
radial_force_N = 215.0
tangential_force_N = -10.0
axial_force_N = -25.0
{process}
"#
    );
    Study::from_toml(&text, "study.toml", Path::new(""), &Overrides::default()).unwrap_or_else(|e| panic!("{e}"))
}

fn results(online: &str, process: &str) -> OnlineResults {
    let study = study(online, process);
    let StudyKind::Online(study, ()) = &study.kind else { panic!("an online study") };
    run(study, &Work::default()).unwrap()
}

const ERRORS: &str = "[[process.chain_error]]\nchain = \"x\"\nturn_about_drive_axis_deg = 1.0\n";

#[test]
fn a_right_model_with_a_right_force_leaves_nothing() {
    // A millionth of a second late.
    let results = results("cycle_ms = 1e-3\nseeds = 2\nforce_errors_percent = [0.0, 40.0]", ERRORS);
    assert!(results.plain.rms_mm.unwrap() > 0.3);
    for trial in &results.trials {
        assert!(trial.online.max_mm.unwrap() < 1e-5, "{trial:?}");
        assert_eq!(trial.offline.max_mm.unwrap() < 1e-9, trial.force_error == 0.0, "{trial:?}");
    }
}

#[test]
fn a_wrong_prediction_leaves_its_share_of_what_the_force_does() {
    let results = results("cycle_ms = 1e-2\nseeds = 3\nforce_errors_percent = [0.0, 20.0]", "");
    for trial in results.trials.iter().filter(|trial| trial.force_error > 0.0) {
        let share = (trial.force_factor - 1.0).abs();
        let expected = share * results.plain.rms_mm.unwrap();
        // The machine bends nearly in proportion to the force.
        assert!((trial.offline.rms_mm.unwrap() / expected - 1.0).abs() < 0.02, "{trial:?}, {expected}");
    }
}

#[test]
fn a_model_that_is_too_soft_by_a_share_leaves_that_share_both_ways() {
    let online = "cycle_ms = 1e-2\nseeds = 1\nforce_errors_percent = [0.0]\nmodel_compliance_error_percent = 10.0";
    let results = results(online, "");
    let expected = 0.1 * results.plain.rms_mm.unwrap();
    let trial = &results.trials[0];
    for left in [trial.offline, trial.online] {
        assert!((left.rms_mm.unwrap() / expected - 1.0).abs() < 0.03, "{left:?}, {expected}");
    }
}

#[test]
fn chain_errors_that_are_not_known_stay() {
    let left = |known: f64| {
        let online =
            format!("cycle_ms = 1e-2\nseeds = 1\nforce_errors_percent = [0.0]\nknown_chain_errors_percent = {known:?}");
        results(&online, ERRORS).trials[0].offline.rms_mm.unwrap()
    };
    let (none, half) = (left(0.0), left(50.0));
    assert!(left(100.0) < 1e-9 && (half / none - 0.5).abs() < 0.02, "{none} {half}");
}

#[test]
fn corrections_keep_the_limits_of_the_process() {
    let online = "cycle_ms = 1e-2\nseeds = 1\nforce_errors_percent = [0.0]";
    let free = results(online, "").trials[0].clone();
    let none = results(online, "[process.limits]\nmax_correction_mm = 1e-9\n");
    for left in [none.trials[0].offline, none.trials[0].online] {
        assert!((left.rms_mm.unwrap() / none.plain.rms_mm.unwrap() - 1.0).abs() < 1e-6, "{left:?}");
    }
    let some = results(online, "[process.limits]\nmax_correction_mm = 0.1\nmax_correction_change_mm = 0.05\n");
    let rms = some.trials[0].offline.rms_mm.unwrap();
    assert!(free.offline.rms_mm.unwrap() < 0.01 * rms && rms < 0.99 * some.plain.rms_mm.unwrap(), "{rms}");
}

#[test]
fn the_loop_says_up_to_which_stiffness_it_settles() {
    let online = "seeds = 1\nforce_errors_percent = [0.0]";
    let found = results(online, "").loop_gain.unwrap();
    assert!(found.largest_stiffness_N_per_mm > 1.0, "{found:?}");
    let at = |share: f64| {
        let given = format!("{online}\ncutting_stiffness_N_per_mm = {:?}", share * found.largest_stiffness_N_per_mm);
        results(&given, "").loop_gain.unwrap().gain.unwrap() < 1.0
    };
    assert!(at(0.98) && !at(1.02));
}

#[test]
fn what_makes_no_sense_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().display().to_string();
    let (code, _, errors) = told(&["new", "online", &format!("{place}/on")]);
    assert_eq!(code, Some(0), "{errors}");
    let file = folder.path().join("on/study.toml");
    let good = std::fs::read_to_string(&file).unwrap();
    for (from, to, expected) in [
        ("cycle_ms = 1.0", "cycle_ms = 0.0", "online.cycle_ms: must be greater than 0, got 0.0"),
        ("cycle_ms = 1.0", "cycle_ms = 1e-9", "online.cycle_ms: the path takes"),
        ("delay_ms = 4.0", "delay_ms = -1.0", "online.delay_ms: must be a number from 0 to 1e18, got -1.0"),
        ("seeds = 20", "seeds = 0", "online.seeds: must be from 1 to 14285, got 0"),
        ("[0.0, 2.0,", "[2.0, 2.0,", "online.force_errors_percent: must be at least one, ascending"),
        ("50.0]", "150.0]", "online.force_errors_percent: must be from 0 to 100, got 150.0"),
        ("_percent = 95.0", "_percent = -5.0", "online.known_chain_errors_percent: must be from 0 to 200, got -5.0"),
        ("feed_mm_per_min = 1000.0\n", "", "online: missing key `feed_mm_per_min`"),
    ] {
        std::fs::write(&file, good.replacen(from, to, 1)).unwrap();
        let (code, _, errors) = told(&["run", &format!("{place}/on"), "--out", &format!("{place}/out")]);
        let errors = errors.split_whitespace().collect::<Vec<_>>().join(" ");
        assert_eq!(code, Some(2), "{errors}");
        assert!(errors.contains(expected), "{errors}\nexpected {expected}");
        assert!(!folder.path().join("out").exists());
    }
}

#[test]
fn an_unsafe_loop_is_said_first() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().display().to_string();
    assert_eq!(told(&["new", "online", &format!("{place}/on")]).0, Some(0));
    let file = folder.path().join("on/study.toml");
    let text = std::fs::read_to_string(&file).unwrap();
    let few = text
        .replace("points = 121", "points = 13")
        .replace("seeds = 20", "seeds = 3")
        .replace("# cutting_stiffness_N_per_mm = 100.0", "cutting_stiffness_N_per_mm = 400.0");
    std::fs::write(&file, few).unwrap();
    let (code, said, errors) = told(&["run", &format!("{place}/on"), "--out", &format!("{place}/out")]);
    assert_eq!(code, Some(0), "{errors}");
    let said = said.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(said.contains("Not safe: at 400 N/mm"), "{said}");
    for file in ["report.html", "trials.csv", "bands.csv", "answer.svg"] {
        assert!(folder.path().join("out").join(file).exists(), "{file}");
    }
}

/// Whether the force settles, cycle after cycle, by the difference equation itself.
fn settles(compliance: f64, softness: f64, k: f64) -> bool {
    let mut size = [0.0f64; 2];
    for (size, sign) in size.iter_mut().zip([1.0, -1.0]) {
        let (mut force, mut measured) = (1.0, 0.0);
        for _ in 0..4000 {
            // F = F₀ − s k (C F − C_m F_before)
            force = (1.0 + sign * k * (1.0 + softness) * compliance * measured) / (1.0 + sign * k * compliance);
            measured = force;
        }
        *size = force;
    }
    size.iter().all(|size| size.abs() < 1e3)
}

#[test]
fn the_gain_says_whether_the_loop_settles() {
    for softness in [-0.5, -0.1, 0.0, 0.2, 1.0] {
        let compliance = 2e-3;
        let limit = LoopGain::new(compliance, softness, None).largest_stiffness_N_per_mm;
        for (share, safe) in [(0.1, true), (0.97, true), (1.03, false), (1.5, false)] {
            let gain = LoopGain::new(compliance, softness, Some(share * limit));
            assert_eq!(gain.gain.unwrap() < 1.0, safe, "{gain:?}");
            assert_eq!(settles(compliance, softness, share * limit), safe, "{softness} {share}");
        }
        assert_eq!(LoopGain::new(compliance, softness, Some(1.0 / compliance)).gain, Some(f64::INFINITY));
    }
}

const PERFECT: Sensor = Sensor { cycle_s: 1e-3, delay_s: 0.0, low_pass_Hz: None, noise_N: 0.0, bias_N: 0.0 };

fn read(sensor: Sensor, duration_s: f64, force: impl Fn(f64) -> f64) -> Vec<[f64; 2]> {
    let times: Vec<f64> = (0..=1000).map(|k| duration_s * f64::from(k) / 1000.0).collect();
    let forces: Vec<_> = times.iter().map(|t| Vector3::new(force(*t), 0.0, 0.0)).collect();
    let measured = sensor.measured(&times, &forces, &mut Xoshiro256PlusPlus::seed_from_u64(1));
    times.iter().zip(measured).map(|(t, value)| [*t, value.x]).collect()
}

#[test]
fn a_ramp_is_late_by_delay_and_cycles() {
    // Between one and two cycles: a command holds for a whole one.
    for [t, value] in read(Sensor { delay_s: 4e-3, ..PERFECT }, 1.0, |t| 100.0 * t) {
        if t > 0.1 {
            let late = t - value / 100.0 - 4e-3;
            assert!((0.999e-3..=2.001e-3).contains(&late), "{t}: {late}");
        }
    }
}

#[test]
fn a_low_pass_is_late_by_its_time_constant() {
    let sensor = Sensor { low_pass_Hz: Some(5.0), ..PERFECT };
    // Of a ramp, after a while, in discrete time: T a / (1 − a).
    let a = (-TAU * 5.0 * 1e-3_f64).exp();
    let lag = 1e-3 * a / (1.0 - a);
    for [t, value] in read(sensor, 1.0, |t| 100.0 * t) {
        if t > 0.5 {
            let late = t - value / 100.0 - lag;
            assert!((0.999e-3..=2.001e-3).contains(&late), "{t}: {late}");
        }
    }
    // And of a step what is missing falls by a each cycle.
    let step = read(sensor, 0.2, |t| if t > 0.0 { 1.0 } else { 0.0 });
    let [t, value] = step[500];
    let expected = 1.0 - (-TAU * 5.0 * t).exp();
    assert!((value - expected).abs() < 0.05, "{value} {expected}");
}

#[test]
fn noise_is_made_smaller_by_the_low_pass() {
    let spread = |sensor| {
        let values: Vec<f64> = read(sensor, 100.0, |_| 0.0).iter().skip(10).map(|[_, value]| *value).collect();
        (values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64).sqrt()
    };
    let plain = spread(Sensor { noise_N: 2.0, ..PERFECT });
    assert!((plain / 2.0 - 1.0).abs() < 0.1, "{plain}");
    // White noise of σ through the filter has σ √((1 − a) / (1 + a)).
    let a = (-TAU * 20.0 * 1e-3_f64).exp();
    let filtered = spread(Sensor { noise_N: 2.0, low_pass_Hz: Some(20.0), ..PERFECT });
    let expected = 2.0 * ((1.0 - a) / (1.0 + a)).sqrt();
    assert!((filtered / expected - 1.0).abs() < 0.1, "{filtered} {expected}");
}

fn bands(medians: [f64; 3]) -> Vec<Option<Band>> {
    let band =
        |(k, median_mm): (usize, f64)| Some(Band { force_error: 0.1 * k as f64, low_mm: 0.0, median_mm, high_mm: 9.0 });
    medians.into_iter().enumerate().map(band).collect()
}

#[test]
fn the_break_even_lies_between_the_errors_around_it() {
    let online = bands([0.2, 0.2, 0.2]);
    assert_eq!(BreakEven::of(&bands([0.3, 0.4, 0.5]), &online), Some(BreakEven::Always));
    assert_eq!(BreakEven::of(&bands([0.0, 0.1, 0.15]), &online), Some(BreakEven::Never(0.2)));
    let Some(BreakEven::From(found)) = BreakEven::of(&bands([0.0, 0.1, 0.3]), &online) else { panic!() };
    assert!((found - 0.15).abs() < 1e-12, "{found}");
    assert_eq!(BreakEven::of(&[None; 3], &online), None);
}

/// Of seeds that leave these residuals, and one that leaves none.
fn band(sizes: &[f64]) -> Option<Band> {
    let trial = |rms_mm: Option<f64>| {
        let residual = Residual { max_mm: None, rms_mm, solved: 1, points: 1 };
        Trial { force_error: 0.1, seed: 0, force_factor: 1.0, offline: residual, online: residual }
    };
    Band::of(&sizes.iter().copied().map(Some).chain([None]).map(trial).collect::<Vec<_>>(), |trial| trial.online)[0]
}

#[test]
fn quantiles_lie_between_values() {
    let quantiles = |sizes: &[f64]| band(sizes).map(|band| [band.low_mm, band.median_mm, band.high_mm]);
    for (sizes, expected) in
        [(&[1.0, 2.0, 4.0][..], [1.1, 2.0, 3.8]), (&[1.0, 2.0], [1.05, 1.5, 1.95]), (&[7.0], [7.0; 3])]
    {
        let found = quantiles(sizes).unwrap();
        assert!(found.iter().zip(expected).all(|(found, expected)| (found - expected).abs() < 1e-12), "{found:?}");
    }
    assert_eq!(quantiles(&[]), None);
}

/// A slide that the force pushes by F / k along it: what is left of a command for the nominal k, and of E F / k that the model leaves out, is known.
#[test]
fn what_is_left_on_drawn_machines_is_the_exact_distribution() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("lever.toml"), LEVER).unwrap();
    let sizes = |uncertainty: &str| {
        let process = "process.tolerance_mm = 0.05\nprocess.placement = { origin_mm = [0.0, 0.0, 50.0] }\n".to_string()
            + &force(0.0, 1000.0, 0.0);
        let online = "[online]\nfeed_mm_per_min = 600.0\ncycle_ms = 1e-2\nforce_errors_percent = [0.0]\n\
                      line = { start_mm = [-0.5, 0.0, 0.0], end_mm = [0.5, 0.0, 0.0] }";
        let text = study_text("lever.toml", &process, uncertainty, online);
        let study = Study::from_toml(&text, "study.toml", folder.path(), &Overrides::default()).unwrap();
        let StudyKind::Online(study, ()) = &study.kind else { panic!("an online study") };
        let trials = run(study, &Work::default()).unwrap().trials;
        assert_eq!(trials.len(), 256);
        let mut sizes: Vec<[f64; 2]> =
            trials.iter().map(|own| [own.offline.max_mm.unwrap(), own.online.max_mm.unwrap()]).collect();
        // The force is known, and so is what is measured: both ways command the same.
        assert!(sizes.iter().all(|[offline, online]| (offline - online).abs() < 1e-5));
        sizes.sort_by(|a, b| a[0].total_cmp(&b[0]));
        [127, 243].map(|rank| sizes[rank][0])
    };
    let near = |found: [f64; 2], expected: [f64; 2]| {
        for (found, expected) in found.iter().zip(expected) {
            assert!((found / expected - 1.0).abs() < 0.05, "{found}, not {expected}");
        }
    };
    let nominal = 0.1;
    let Distribution::Logarithm { above, .. } = Distribution::of_relative_std(0.3) else { unreachable!() };
    // Softer and stiffer machines are off to the two sides.
    let is_within = |size: f64| {
        normal_cdf((size / nominal).ln_1p() / above) - normal_cdf((-(size / nominal).min(1.0)).ln_1p() / above)
    };
    let quantile_of = |share: f64| (1..100_000).map(|own| 1e-5 * f64::from(own)).find(|size| is_within(*size) >= share);
    let stiffness = "[[uncertainty.parameter]]\nname = \"guide.slide.stiffness\"\nrelative_std = 0.3\n";
    near(sizes(stiffness), [0.5, 0.95].map(|share| quantile_of(share).unwrap()));
    // The slide moves along x alone, the tool wherever E says: square roots of quantiles of χ² with three degrees of freedom.
    near(
        sizes("[uncertainty.model]\nrelative_std = 0.2\n"),
        [2.365_974f64, 7.814_728].map(|own| nominal * 0.2 / 3f64.sqrt() * own.sqrt()),
    );
    // The error of the setup alone.
    let setup = "[uncertainty.process]\ntool_length_mm = { std = 0.02 }\n[uncertainty.model]\nrelative_std = 0.0\n";
    near(sizes(setup), [0.674_49, 1.959_964].map(|z| 0.02 * z));
}
