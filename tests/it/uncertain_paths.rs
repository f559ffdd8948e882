//! Paths with uncertain inputs: what is left of a compensation on other machines, against closed forms and brute force.

use crate::support::{
    command::told,
    uncertain::{Drawn, EXACT_MODEL, LEVER, TOLERANCES, draws, force, job, study_text, verified},
};
use kinetostat::page::headline::Headline;
use kinetostat::{
    Overrides, Study, Work,
    compensation::{Method, Session, compensate, simulate, simulate_drives},
    process::uncertainty::{P95, normal_cdf, normal_quantile, quantile},
    products::program::{CommandSource, CompensateOptions},
    questions::{
        StudyKind,
        path::{self, PathResults, PathStudy, Shown, report},
    },
    simulation::{Machines, Source, settings, spread::DeflectionSpread},
};
use nalgebra::{Rotation3, Vector3};

fn path_study(folder: impl Into<kinetostat::Folder>, text: &str) -> Box<PathStudy> {
    match Study::from_toml(text, "study.toml", folder.into(), &Overrides::default()).unwrap().kind {
        StudyKind::Path(path, _) => path,
        _ => panic!("not a path"),
    }
}

fn study_of(machine: &str, process: &str, uncertainty: &str, path: &str) -> String {
    study_text(machine, process, uncertainty, &format!("[path]\nmethods = [\"direct\"]\n{path}"))
}

/// Where the workpiece stands so that the lever's tip is moved along its prismatic joint, and a force along the feed: radial, tangential, axial, N.
const ALONG: (&str, [f64; 3]) = ("[0.0, 0.0, 50.0]", [0.0, 1000.0, 0.0]);

/// A machine like the lever, moved along x from -0.5 to 0.5 mm.
fn on_lever(machine: &str, (origin_mm, load): (&str, [f64; 3]), uncertainty: &str) -> PathResults {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("lever.toml"), machine).unwrap();
    let process = format!("process.placement = {{ origin_mm = {origin_mm} }}\n{}", force(load[0], load[1], load[2]));
    let path = "line = { start_mm = [-0.5, 0.0, 0.0], end_mm = [0.5, 0.0, 0.0] }";
    let text = study_of("lever.toml", &process, uncertainty, path);
    path::run(&path_study(folder.path().to_path_buf(), &text), &Work::default()).unwrap()
}

/// A slide that is moved along x under a force along y: force over stiffness is lognormal, and what the nominal correction leaves has known quantiles.
#[test]
fn what_a_compensation_leaves_on_a_lever_has_the_exact_quantiles() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("lever.toml"), LEVER).unwrap();
    let (stiffness, load): (f64, f64) = (0.3, 0.15);
    let uncertainty = format!(
        "[[uncertainty.parameter]]\nname = \"guide.slide.stiffness\"\nrelative_std = {stiffness}\n[uncertainty.process]\nforce_relative_std = {load}"
    );
    // Along +x the tangential force points against the feed.
    let process = "process.tolerance_mm = 0.05\nprocess.placement = { origin_mm = [0.0, 0.0, 50.0] }\n".to_string()
        + &force(0.0, 1000.0, 0.0);
    let path = "line = { start_mm = [-0.5, 0.0, 0.0], end_mm = [0.5, 0.0, 0.0] }";
    let study = path_study(folder.path().to_path_buf(), &study_of("lever.toml", &process, &uncertainty, path));
    let found = path::run(&study, &Work::default()).unwrap();
    let variance = |relative: f64| (0.5 * (1.0 + (1.0 + 4.0 * relative * relative).sqrt())).ln();
    let std = (variance(stiffness) + variance(load)).sqrt();
    // Of force over stiffness: 0.1 mm times a lognormal number of which the nominal correction takes 1 away.
    let below_with = |std: f64, size: f64| {
        let of = |number: f64| if number <= 0.0 { 0.0 } else { normal_cdf(number.ln() / std) };
        of(1.0 + size / 0.1) - of(1.0 - size / 0.1)
    };
    let residual_with = |std: f64, share: f64| {
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if below_with(std, middle) < share { low = middle } else { high = middle }
        }
        low
    };
    let (below, exact_residual) = (|size: f64| below_with(std, size), |share: f64| residual_with(std, share));
    let exact_plain = |share| 0.1 * (std * normal_quantile(share)).exp();
    let check = |spread: &DeflectionSpread, exact: &dyn Fn(f64) -> f64, within: f64| {
        for (value, share) in [(spread.p95_mm, 0.95), (spread.median_mm, 0.5)] {
            let value = value.unwrap();
            assert!((value / exact(share) - 1.0).abs() < 0.012, "{value} instead of {}: {spread:?}", exact(share));
        }
        assert!((spread.within_tolerance.unwrap() - within).abs() < 6e-3, "{spread:?} instead of {within}");
    };
    // Worse where force over stiffness is below half of the nominal one.
    let worse = normal_cdf(0.5f64.ln() / std);
    let plain_within = normal_cdf((0.05f64 / 0.1).ln() / std);
    for effect in &found.whole.sources[Source::All] {
        let spread = effect.spread.as_ref().unwrap();
        check(&spread.plain, &exact_plain, plain_within);
        check(spread.compensated.as_ref().unwrap(), &exact_residual, below(0.05));
        assert!((spread.worse.unwrap() - worse).abs() < 4e-3, "{spread:?} instead of {worse}");
        assert!((spread.without_force_mm.unwrap() - 0.1).abs() < 1e-6, "{spread:?}");
    }
    // The same force and machine at all points: the largest is that of each.
    let whole = found.spread.clone().unwrap();
    check(&whole.plain.spread, &exact_plain, plain_within);
    let compensated = whole.compensated.clone().unwrap();
    check(&compensated.spread, &exact_residual, below(0.05));
    assert!(compensated.is_confirmed && compensated.points == found.study.stations.len());
    assert!((whole.worse.unwrap() - worse).abs() < 4e-3);
    // With the stiffness known to ±5 % the logarithm scatters less.
    let measured = compensated.if_measured.unwrap();
    assert_eq!((&*measured.cause, &*measured.known), ("guide.slide.stiffness", "known to ±5 %"));
    let then = (1.05f64.ln() / normal_quantile(0.975)).hypot(variance(load).sqrt());
    for (found, std) in measured.p95_mm.into_iter().zip([std, then]) {
        let exact = residual_with(std, P95);
        assert!((found / exact - 1.0).abs() < 0.02, "{found} instead of {exact}");
    }
    assert!(whole.plain.if_measured.is_none());
    // Its only drive.
    let [alone] = whole.worse_by_drive[..] else { panic!("{whole:?}") };
    assert!((alone - worse).abs() < 0.02, "{alone} instead of {worse}");
}

/// What the model leaves out is what is left of a compensation: a length with three normal components.
#[test]
fn a_model_that_leaves_something_out_is_not_compensated() {
    let found = on_lever(LEVER, ALONG, "[uncertainty.model]\nrelative_std = 0.3");
    let whole = found.spread.unwrap().compensated.unwrap();
    // Quantiles of the length of three standard normal numbers.
    for (found, chi) in [(whole.spread.p95_mm, 2.795_483), (whole.spread.median_mm, 1.538_172)] {
        let (found, exact) = (found.unwrap(), 0.1 * 0.3 / 3.0f64.sqrt() * chi);
        assert!((found / exact - 1.0).abs() < 0.01, "{found} instead of {exact}");
    }
    assert!(whole.is_confirmed && whole.spread.check_difference.unwrap().abs() < 1e-5, "{whole:?}");
}

/// Errors of the setup are what is left where everything else is exact: a length with three normal components, and with one along the tool.
#[test]
fn a_setup_that_is_not_exact_is_not_compensated() {
    let chi = [2.795_483, 1.538_172];
    let normal = [normal_quantile(0.975), normal_quantile(0.75)];
    for (uncertainty, exact) in [
        ("workpiece_position_mm = { std = 0.03 }", chi.map(|own| 0.03 * own)),
        ("tool_length_mm = { std = 0.02 }", normal.map(|own| 0.02 * own)),
    ] {
        let found = on_lever(LEVER, ALONG, &format!("[uncertainty.process]\n{uncertainty}"));
        let whole = found.spread.clone().unwrap().compensated.unwrap();
        for (found, exact) in [whole.spread.p95_mm, whole.spread.median_mm].into_iter().zip(exact) {
            assert!((found.unwrap() / exact - 1.0).abs() < 0.01, "{uncertainty}: {found:?} instead of {exact}");
        }
        assert!(whole.is_confirmed && whole.spread.check_difference.unwrap().abs() < 1e-5, "{whole:?}");
        let at_point = found.whole.sources[Source::All][0].spread.as_ref().unwrap();
        let cause = at_point.compensated.as_ref().unwrap().main_cause.as_deref().unwrap();
        assert!(uncertainty.starts_with(&cause.replace(' ', "_")[..9]), "{cause}");
    }
    // A tool that lies along the prismatic joint, which the axial force pushes back by 0.1 mm: what it is longer by takes from that.
    let sideways =
        LEVER.replace("tool_tip_mm = [0.0, 0.0, 50.0]", "tool_tip_mm = [50.0, 0.0, 0.0]\ntool_axis = [1.0, 0.0, 0.0]");
    let uncertainty = "[uncertainty.process]\ntool_length_mm = { uniform = [0.0, 0.02] }";
    let found = on_lever(&sideways, ("[50.0, 0.0, 0.0]", [0.0, 0.0, -1000.0]), uncertainty);
    let plain = found.whole.sources[Source::All][0].spread.as_ref().unwrap().plain.clone();
    assert!((plain.median_mm.unwrap() - 0.09).abs() < 2e-4, "{plain:?}");
}

/// Two tools along a prismatic joint, each with a force of its own: the largest distance is that of the larger of two independent lognormal numbers; with one factor it is one number. With a single tool
/// nothing changes.
#[test]
fn each_tool_may_have_a_force_of_its_own() {
    let std = {
        let relative = 0.15f64;
        (0.5 * (1.0 + (1.0 + 4.0 * relative * relative).sqrt())).ln().sqrt()
    };
    let run = |program: &str, uncertainty: &str| {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("lever.toml"), LEVER).unwrap();
        std::fs::write(folder.path().join("part.nc"), program).unwrap();
        let process = "process.placement = { origin_mm = [0.0, 0.0, 50.0] }\nprocess.compensate = { corner_mm = 0.0 }\n"
            .to_string() + &force(0.0, 1000.0, 0.0);
        let uncertainty = format!("[uncertainty.process]\nforce_relative_std = 0.15\n{uncertainty}");
        let text = study_of("lever.toml", &process, &uncertainty, "file = \"part.nc\"");
        let study = path_study(folder.path().to_path_buf(), &text);
        path::run(&study, &Work::default()).unwrap()
    };
    let two = "G21 G90\nG0 X-0.5 Y0 Z0\nT1 M6\nG1 X0.5 F600\nT2 M6\nG1 X-0.5\n";
    let own = run(two, "force_per_tool = true\n");
    let shared = run(two, "");
    let check = |found: &PathResults, tools: i32| {
        let whole = found.spread.as_ref().unwrap();
        // Probabilities of both distances, as programmed and compensated, multiply.
        let plain = |share: f64| 0.1 * (std * normal_quantile(share.powf(1.0 / f64::from(tools)))).exp();
        let left_within = |size: f64| {
            let below = |number: f64| if number <= 0.0 { 0.0 } else { normal_cdf(number.ln() / std) };
            (below(1.0 + size / 0.1) - below(1.0 - size / 0.1)).powi(tools)
        };
        let left = |share: f64| {
            let (mut low, mut high) = (0.0, 1.0);
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if left_within(middle) < share { low = middle } else { high = middle }
            }
            low
        };
        let compensated = whole.compensated.as_ref().unwrap();
        for (found, exact, share) in [
            (whole.plain.spread.p95_mm, plain(P95), 0.005),
            (whole.plain.spread.median_mm, plain(0.5), 0.005),
            (compensated.spread.p95_mm, left(P95), 0.02),
            (compensated.spread.median_mm, left(0.5), 0.02),
        ] {
            let found = found.unwrap();
            assert!((found / exact - 1.0).abs() < share, "{tools} tools: {found} instead of {exact}");
        }
        assert!(whole.plain.is_confirmed && compensated.is_confirmed, "{whole:?}");
        // At each point a single tool cuts.
        for effect in &found.whole.sources[Source::All] {
            let plain = &effect.spread.as_ref().unwrap().plain;
            if effect.plain.position_error.norm() > 0.05 {
                let exact = 0.1 * (std * normal_quantile(P95)).exp();
                assert!((plain.p95_mm.unwrap() / exact - 1.0).abs() < 0.005, "{plain:?} instead of {exact}");
            }
        }
    };
    check(&own, 2);
    check(&shared, 1);
    let [with, without] = [&own, &shared].map(|own| &own.study.uncertainty.as_ref().unwrap().draws);
    assert_eq!((with.force_of(0), &with.normal), (without.force_of(0), &without.normal));
    assert_eq!(own.study.uncertainty.as_ref().unwrap().tools, [1, 2]);
    let one = two.replace("T2 M6\n", "");
    assert_eq!(run(&one, "force_per_tool = true\n").spread, run(&one, "").spread);
}

/// An end mill of two coefficients along a prismatic joint: with each known by itself, its force along the feed is a sum of lognormal numbers, and so is what the compensation
/// leaves; of a path and of a program alike.
#[test]
fn coefficients_of_a_cutting_force_vary_by_themselves() {
    // Down milling with a quarter of the diameter: from 120° to 180°, 4 teeth, 5 mm deep, 0.1 mm a tooth.
    let (entry, share, feed) = (2.0 / 3.0 * std::f64::consts::PI, 4.0 * 5.0 / std::f64::consts::TAU, 0.1);
    let [sine_cosine, sine_squared] =
        [-0.5 * entry.sin().powi(2), 0.5 * (std::f64::consts::PI - entry) + 0.25 * (2.0 * entry).sin()];
    let [tangential, radial] = [-share * feed * 9000.0 * sine_cosine, -share * feed * 3000.0 * sine_squared];
    let milling = "process.force.end_milling = { diameter_mm = 10.0, teeth = 4, axial_depth_mm = 5.0, radial_width_mm = 2.5, cut = \"down\", \
        feed_per_tooth_mm = 0.1, coefficients = { tangential_cutting_N_per_mm2 = 9000.0, radial_cutting_N_per_mm2 = 3000.0, axial_cutting_N_per_mm2 = 0.0 } }\n";
    let process = "process.placement = { origin_mm = [0.0, 0.0, 50.0] }\n".to_string() + milling;
    let uncertainty = "[uncertainty.process]\nforce_relative_std = 0.05\nforce_component_relative_std = { tangential = 0.15, radial = 0.3 }\n";
    let std = |relative: f64| (0.5f64 * (1.0 + (1.0 + 4.0 * relative * relative).sqrt())).ln().sqrt();
    // On a grid of quantiles of all three.
    let count = 200;
    let factors = |relative: f64| -> Vec<f64> {
        (0..count).map(|own| (std(relative) * normal_quantile((own as f64 + 0.5) / count as f64)).exp()).collect()
    };
    let [whole, one, other] = [0.05, 0.15, 0.3].map(factors);
    let sizes = |without: f64| -> Vec<f64> {
        let of = |whole: &f64, one: &f64, other: &f64| {
            ((whole * (one * tangential + other * radial) - without * (tangential + radial)) / 1e4).abs()
        };
        let (one, other) = (&one, &other);
        whole
            .iter()
            .flat_map(|all| one.iter().flat_map(move |one| other.iter().map(move |other| of(all, one, other))))
            .collect()
    };
    let exact = |without: f64| [P95, 0.5].map(|share| quantile(&mut sizes(without), share));
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("lever.toml"), LEVER).unwrap();
    let path = "line = { start_mm = [-0.5, 0.0, 0.0], end_mm = [0.5, 0.0, 0.0] }";
    let study = path_study(folder.path().to_path_buf(), &study_of("lever.toml", &process, uncertainty, path));
    let found = path::run(&study, &Work::default()).unwrap().spread.unwrap();
    let of_process = format!("{}{uncertainty}{EXACT_MODEL}", process.replace("process.", ""));
    let job = job("lever", &of_process, ("part.nc", "G21 G90\nG0 X-0.5 Y0 Z0\nG1 X0.5 F600\n"));
    let asked = CompensateOptions {
        commands: CommandSource::Method(Method::Direct),
        compared: Vec::new(),
        sources_apart: false,
        ends_early: false,
    };
    let of_program = verified(&job, &asked).unwrap().0.spread.unwrap();
    for found in [&found, &of_program] {
        for (found, exact, share) in
            [(&found.plain, exact(0.0), 5e-3), (found.compensated.as_ref().unwrap(), exact(1.0), 2e-2)]
        {
            for (found_mm, exact) in [found.spread.p95_mm, found.spread.median_mm].into_iter().zip(exact) {
                let found_mm = found_mm.unwrap();
                assert!((found_mm / exact - 1.0).abs() < share, "{found_mm} instead of {exact}: {found:?}");
            }
            assert!(found.is_confirmed && found.spread.check_difference.unwrap().abs() < 1e-5, "{found:?}");
        }
        let measured = found.compensated.as_ref().unwrap().if_measured.as_ref().unwrap();
        assert_eq!(measured.cause, "tangential force");
    }
}

/// A workpiece that is turned about its origin carries its path away from where it is commanded: what the exactly rotated path is off by, on which a prismatic joint that gives way
/// under the force adds its own.
#[test]
fn a_turned_workpiece_leaves_its_rotated_path() {
    // The slide is moved along x, 300 mm along y from the origin of the workpiece.
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("lever.toml"), LEVER).unwrap();
    let process = "process.placement = { origin_mm = [0.0, -300.0, 50.0] }\n".to_string() + &force(0.0, 1000.0, 0.0);
    let path = "line = { start_mm = [-0.5, 300.0, 0.0], end_mm = [0.5, 300.0, 0.0] }";
    let uncertainty = "[uncertainty.process]\nworkpiece_rotation_deg = { uniform = [0.0, 0.05] }";
    let study = path_study(folder.path().to_path_buf(), &study_of("lever.toml", &process, uncertainty, path));
    let found = path::run(&study, &Work::default()).unwrap();
    // About y all but nothing is moved: a grid over the two others. The force moves the prismatic joint by 0.1 mm, which the correction takes away.
    let count = 400;
    let angle = |step: usize| 0.05f64.to_radians() * (step as f64 + 0.5) / count as f64;
    let arm = Vector3::new(0.5, 300.0, 0.0);
    let sizes = |deflection: Vector3<f64>| -> Vec<f64> {
        let of = |about_x: usize| {
            (0..count).map(move |about_z| {
                let rotation = Rotation3::new(Vector3::new(angle(about_x), angle(count / 2), angle(about_z)));
                (deflection - (rotation * arm - arm)).norm()
            })
        };
        (0..count).flat_map(of).collect()
    };
    let whole = found.spread.as_ref().unwrap();
    let compensated = &whole.compensated.as_ref().unwrap().spread;
    let by_force = found.whole.at(Source::All, 0).plain.position_error;
    assert!((by_force.norm() - 0.1).abs() < 1e-6, "{by_force}");
    for (spread, deflection) in [(&whole.plain.spread, by_force), (compensated, Vector3::zeros())] {
        for (found, share) in [(spread.p95_mm, P95), (spread.median_mm, 0.5)] {
            let (found, exact) = (found.unwrap(), quantile(&mut sizes(deflection), share));
            assert!((found / exact - 1.0).abs() < 4e-3, "{share}: {found} instead of {exact}");
        }
    }
    assert!(compensated.main_cause.as_deref().unwrap().starts_with("workpiece rotation about"), "{compensated:?}");
    assert!(whole.compensated.as_ref().unwrap().is_confirmed && compensated.check_difference.unwrap().abs() < 1e-5);
}

/// A worn tool needs more force than the correction is computed with: what that leaves is uniform, and half of it if tools are changed earlier.
#[test]
fn what_tool_wear_leaves_of_a_compensation_is_uniform() {
    let found = on_lever(LEVER, ALONG, "[uncertainty.process]\nwear_force_increase = 0.3");
    let whole = found.spread.unwrap();
    let compensated = whole.compensated.unwrap();
    let check = |found: Option<f64>, exact: f64| {
        assert!((found.unwrap() / exact - 1.0).abs() < 3e-3, "{found:?} instead of {exact}");
    };
    for (share, plain, left) in [
        (0.95, whole.plain.spread.p95_mm, compensated.spread.p95_mm),
        (0.5, whole.plain.spread.median_mm, compensated.spread.median_mm),
    ] {
        check(plain, 0.1 * (1.0 + 0.3 * share));
        check(left, 0.1 * 0.3 * share);
    }
    assert!(compensated.is_confirmed && compensated.spread.main_cause.as_deref() == Some("tool wear"));
    let measured = compensated.if_measured.unwrap();
    assert_eq!(measured.cause, "tool wear");
    check(Some(measured.p95_mm[1]), 0.1 * 0.15 * 0.95);
}

/// Distances at each point, without and with compensation, and the largest last; and the largest with the correction of each drive left out.
type BruteForce = (Vec<[Vec<f64>; 2]>, Vec<Vec<f64>>);

/// Distances in draws computed one by one: without surrogate, lanes, blocks and draws of the study.
fn brute_force(found: &PathResults, count: usize) -> BruteForce {
    let study = &found.study;
    let uncertainty = study.uncertainty.as_ref().unwrap();
    let mut sizes = vec![[Vec::new(), Vec::new()]; study.tasks.len() + 1];
    let mut without = vec![Vec::new(); study.machine.drives().count()];
    for Drawn { unloaded, actual, factor } in draws(uncertainty, &study.errors, count) {
        let (mut largest, mut largest_without) = ([0.0f64; 2], vec![0.0f64; without.len()]);
        let new = || Session::new(&study.machine, &actual, settings()).with_unloaded_machine(&unloaded);
        let mut sessions = [new(), new(), new()];
        for (k, task) in study.tasks.iter().enumerate() {
            let mut task = *task;
            task.load = task.load.scale(factor);
            let nominal = &found.whole.at(Source::All, k).answer;
            let target = nominal.target.unwrap();
            for (drive, largest) in largest_without.iter_mut().enumerate() {
                let mut drives = nominal.drives.clone();
                drives[drive] = nominal.nominal_drives[drive];
                *largest = largest.max(simulate_drives(&mut sessions[2], &task, &drives).position_error.norm());
            }
            let answers =
                [compensate(&mut sessions[0], &task, Method::None), simulate(&mut sessions[1], &task, &target)];
            for (i, answer) in answers.into_iter().enumerate() {
                assert!(answer.outcome.is_some(), "{:?}", answer.status);
                let size = answer.position_error.norm();
                largest[i] = largest[i].max(size);
                sizes[k][i].push(size);
            }
        }
        let whole = &mut sizes[study.tasks.len()];
        (0..2).for_each(|i| whole[i].push(largest[i]));
        without.iter_mut().zip(largest_without).for_each(|(own, largest)| own.push(largest));
    }
    (sizes, without)
}

/// An overconstrained machine whose legs pull against one another, one with six legs, and an arm under its weight.
#[test]
fn paths_agree_with_brute_force() {
    let (small, large) = (force(215.0, -10.0, -25.0), force(800.0, 300.0, -200.0));
    let count = 1024;
    for (machine, pattern, relative, load, tolerance, centre) in [
        ("orthoglide", "material.aluminium.*", 0.3, &small, 0.4, [0.0, 0.0, 0.0]),
        ("hexapod", "leg.screw.stiffness", 0.3, &large, 0.1, [0.0, 0.0, 800.0]),
        ("kr500", "arm.*.stiffness", 0.3, &large, 0.5, [1900.0, 0.0, 900.0]),
    ] {
        let uncertainty = format!(
            "[uncertainty]\n[[uncertainty.parameter]]\nname = \"{pattern}\"\nrelative_std = {relative}\n{TOLERANCES}"
        );
        let placement = "process.placement = { reference = \"platform_point\" }";
        let process = format!("process.tolerance_mm = {tolerance}\n{placement}\n{load}");
        let path = format!("circle = {{ centre_mm = {centre:?}, diameter_mm = 60.0, points = 7 }}");
        let study = path_study(kinetostat::Folder::in_memory([]), &study_of(machine, &process, &uncertainty, &path));
        let found = path::run(&study, &Work::default()).unwrap();
        let (brute, without) = brute_force(&found, count);
        let whole = found.spread.as_ref().unwrap();
        assert_eq!(whole.worse_by_drive.len(), without.len());
        for (found, without) in whole.worse_by_drive.iter().zip(&without) {
            let largest = brute[study.tasks.len()][1].iter().zip(without);
            let expected = largest.filter(|(with, without)| **with > 1.005 * **without).count() as f64 / count as f64;
            // Either is of 1024 draws.
            assert!((found - expected).abs() < 0.05, "{machine}: {found} instead of {expected}");
        }
        assert!(whole.plain.is_confirmed, "{machine}: {whole:?}");
        let mut widest = 0.0f64;
        let mut check = |what: &str, spread: &DeflectionSpread, sizes: &[f64]| {
            for (value, share) in [(spread.p95_mm, P95), (spread.median_mm, 0.5)] {
                // Quantiles of so many draws are where the share is known to three standard errors, and draws of the study are as good.
                let error = 3.0 * (share * (1.0 - share) / count as f64).sqrt();
                let [low, high] = [share - error, share + error].map(|share| quantile(&mut sizes.to_vec(), share));
                let value = value.unwrap();
                assert!(
                    (low..=high).contains(&value),
                    "{machine} {what}: {value}, not {low} to {high} ({share}): {spread:?}"
                );
                widest = widest.max(high / low - 1.0);
            }
            let expected = sizes.iter().filter(|size| **size <= tolerance).count() as f64 / count as f64;
            assert!(
                (spread.within_tolerance.unwrap() - expected).abs() < 0.015,
                "{machine} {what}: {expected}, {spread:?}"
            );
        };
        for (k, sizes) in brute[..study.tasks.len()].iter().enumerate().step_by(3) {
            let spread = found.whole.at(Source::All, k).spread.as_ref().unwrap();
            check("plain", &spread.plain, &sizes[0]);
            check("compensated", spread.compensated.as_ref().unwrap(), &sizes[1]);
            let worse =
                sizes[1].iter().zip(&sizes[0]).filter(|(after, before)| **after > 1.005 * **before).count() as f64;
            assert!((spread.worse.unwrap() - worse / count as f64).abs() < 0.01, "{machine}: {spread:?}");
        }
        let [plain, compensated] = &brute[study.tasks.len()];
        check("whole, plain", &whole.plain.spread, plain);
        check("whole, compensated", &whole.compensated.as_ref().unwrap().spread, compensated);
        assert!(widest < 0.35, "{machine}: {widest}");
        // What the nominal machine does at the compensated command without force.
        let machines = Machines::new(&study.machine, &study.errors).unwrap();
        let mut session = machines.session(Source::All);
        let mut task = found.study.tasks[0];
        task.load = task.load.scale(0.0);
        let target = found.whole.at(Source::All, 0).answer.target.unwrap();
        let expected = simulate(&mut session, &task, &target).position_error.norm();
        let without = found.whole.at(Source::All, 0).spread.as_ref().unwrap().without_force_mm.unwrap();
        assert!((without - expected).abs() < 1e-6 * expected, "{machine}: {without} instead of {expected}");
    }
}

fn orthoglide_path(points: usize, tolerance: f64) -> Box<PathStudy> {
    let uncertainty = format!(
        "[uncertainty]\n[[uncertainty.parameter]]\nname = \"leg.*.stiffness\"\nrelative_std = 0.3\n{TOLERANCES}"
    );
    // On the platform point, within the box.
    let placement = "process.placement = { reference = \"platform_point\" }";
    let process = format!("process.tolerance_mm = {tolerance}\n{placement}\n{}", force(215.0, -10.0, -25.0));
    let path = format!("circle = {{ centre_mm = [20.0, 10.0, 0.0], diameter_mm = 80.0, points = {points} }}");
    path_study(kinetostat::Folder::in_memory([]), &study_of("orthoglide", &process, &uncertainty, &path))
}

#[test]
fn spreads_along_a_path_are_the_same_on_any_number_of_threads() {
    let study = orthoglide_path(300, 0.5);
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| path::run(&study, &Work::default()).unwrap())
    };
    let (one, three) = (on(1), on(3));
    assert_eq!(one.spread, three.spread);
    assert_eq!(one.whole.sources, three.whole.sources);
    let block = path::run_range(&study, 256..300, &Work::default()).unwrap();
    assert_eq!(block.sources[Source::All][..], one.whole.sources[Source::All][256..]);
}

/// The sentence on the tool, which may be told of the deflection alone.
fn verdict_sentence(headline: &Headline) -> String {
    let told = headline.cautions.iter().find(|own| own.contains("the tool of orthoglide")).unwrap();
    told.strip_prefix("By the deflection alone: ").unwrap_or(told).to_string()
}

/// The first sentence says whether the tolerance is kept with compensation, on machines and under forces as they may be.
#[test]
fn the_verdict_is_that_of_the_compensated_program() {
    let said = |tolerance: f64| {
        let study = orthoglide_path(7, tolerance);
        let found = path::run(&study, &Work::default()).unwrap();
        let mut summary = report::Summary::new(&study, Shown { is_circle: true });
        summary.add(&found.whole);
        summary.add_whole(&found.spread);
        let text = report::text(&summary);
        (found.spread.clone().unwrap(), verdict_sentence(&report::headline(&summary, &text)), text.place)
    };
    let (whole, sentence, place) = said(10.0);
    let expected = "Within tolerance: the tool of orthoglide, compensated, stays within 10 mm all along this path with more than 99.9 % probability, within ";
    assert!(sentence.starts_with(expected), "{sentence}");
    assert!(place.contains("Where the force is absent (in air, in a spring pass, with a broken tool)"), "{place}");
    // Its drives are all called alike: by their legs they are not.
    let (_, drives) = place.split_once("makes it larger by more than 0.5 % (estimates): x ").unwrap();
    assert!(drives.contains(", y ") && drives.contains(", z "), "{drives}");
    let spread = whole.compensated.unwrap().spread;
    let between = 0.5 * (spread.median_mm.unwrap() + spread.p95_mm.unwrap());
    let (_, sentence, _) = said(between);
    assert!(sentence.starts_with("Probably within tolerance under the cutting force: "), "{sentence}");
    // The correction for a force that is not there leads the tool as far to the other side.
    let (_, off) = sentence.split_once("the same commands lead it off by up to ").unwrap();
    let off: f64 = off.split_once(' ').unwrap().0.parse().unwrap();
    assert!(off > between, "{sentence}");
    let (_, sentence, _) = said(1e-4);
    assert!(sentence.starts_with("Out of tolerance: "), "{sentence}");
}

/// In air nothing acts but weight: stiffnesses leave rounding, which no draw is solved for.
#[test]
fn a_path_in_air_takes_no_more_draws_than_one_per_point() {
    let uncertainty = "[[uncertainty.parameter]]\nname = \"leg.*.stiffness\"\nrelative_std = 0.3";
    let path = "circle = { centre_mm = [20.0, 10.0, 0.0], diameter_mm = 80.0, points = 7 }";
    let text = study_of("orthoglide", &force(0.0, 0.0, 0.0), uncertainty, path);
    let found = path::run(&path_study(kinetostat::Folder::in_memory([]), &text), &Work::default()).unwrap();
    for effect in &found.whole.sources[Source::All] {
        let spread = effect.spread.as_ref().unwrap();
        let left = spread.compensated.clone().unwrap();
        assert!(left.solved_draws <= 1 && left.p95_mm.unwrap() < 1e-6, "{spread:?}");
        assert!(spread.worse == Some(0.0) && spread.without_force_mm.unwrap() < 1e-6, "{spread:?}");
    }
    let whole = found.spread.unwrap();
    assert!(whole.plain.is_confirmed && whole.compensated.unwrap().is_confirmed && whole.worse == Some(0.0));
}

/// A path that the machine cannot run to its end is judged nowhere as a whole, and one out of reach is answered without figures.
#[test]
fn a_path_that_is_known_in_part_has_no_verdict() {
    let said = |end: f64| {
        let uncertainty = "[uncertainty.process]\nforce_relative_std = 0.15";
        let process = format!(
            "process.tolerance_mm = 0.5\nprocess.placement = {{ reference = \"platform_point\" }}\nprocess.sampling.max_segment_mm = 20.0\n{}",
            force(215.0, -10.0, -25.0)
        );
        let path = format!("line = {{ start_mm = [{:?}, 0.0, 0.0], end_mm = [{end:?}, 0.0, 0.0] }}", end - 900.0);
        let folder = tempfile::tempdir().unwrap();
        let study = folder.path().join("study");
        std::fs::create_dir(&study).unwrap();
        std::fs::write(study.join("study.toml"), study_of("orthoglide", &process, uncertainty, &path)).unwrap();
        let (code, out, err) =
            told(&["run", study.to_str().unwrap(), "--out", folder.path().join("out").to_str().unwrap()]);
        (code, out.split_whitespace().collect::<Vec<_>>().join(" ") + &err)
    };
    let (_, partly) = said(900.0);
    assert!(
        partly.contains("Not known along all of this path: ")
            && partly.contains("Outside the workspace box: there is no verdict.")
            && partly.contains("without compensation) at the others."),
        "{partly}"
    );
    assert!(!partly.contains("within tolerance: the tool") && !partly.contains("all along this path with"), "{partly}");
    let (code, nowhere) = said(9000.0);
    assert!(code != Some(3) && nowhere.contains("could be computed at none of its points"), "{code:?} {nowhere}");
}
