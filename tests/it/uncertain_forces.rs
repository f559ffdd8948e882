//! Limits of drive forces where inputs are uncertain: against a closed form, and against brute force along the program as written.

use crate::support::{
    command::told,
    uncertain::{Drawn, EXACT_MODEL, Kept, NC, draws, job, verified},
};
use kinetostat::{
    compensation::{Session, TaskPoint, simulate},
    input::error::Result,
    process::uncertainty::normal_cdf,
    products::program::{CommandSource, CompensateOptions, ProgramJob, VerifiedProgram},
    simulation::settings,
};
use serde_json::Value;

/// A slide along x under a force along its path.
const ALONG: &str = "[placement]\norigin_mm = [0.0, 0.0, 50.0]\n[force.path_frame]\nradial_force_N = 0.0\ntangential_force_N = 1000.0\naxial_force_N = 0.0\n";
const ALONG_NC: &str = "G21 G90\nG0 X-0.5 Y0 Z0\nG1 X0.5 F600\n";
const ORTHOGLIDE: &str = "[placement]\nreference = \"platform_point\"\n[sampling]\nmax_segment_mm = 15.0\n\
    [force.path_frame]\nradial_force_N = 215.0\ntangential_force_N = -10.0\naxial_force_N = -25.0\n";

/// A force limit above the nominal force along [`NC`], 220 N, and below that in 95 of 100, 228 N.
const LIMIT: f64 = 224.0;
const UNCERTAIN: &str = "[[uncertainty.parameter]]\nname = \"leg.*.stiffness\"\nrelative_std = 0.3\n\
    [[uncertainty.chain_error]]\nchain = \"*\"\nturn_about_drive_axis_deg = { uniform = [-0.1, 0.1] }\n\
    [uncertainty.process]\nforce_relative_std = 0.02\n[uncertainty.model]\nrelative_std = 0.0\n";

fn force_std(relative: f64) -> String {
    format!("[uncertainty.process]\nforce_relative_std = {relative:?}\n{EXACT_MODEL}")
}

/// The program of `job` within its limits, verified.
fn bounded(job: &ProgramJob) -> Result<(VerifiedProgram, Kept)> {
    let asked = CompensateOptions {
        commands: CommandSource::Bounded,
        compared: Vec::new(),
        sources_apart: false,
        ends_early: false,
    };
    verified(job, &asked)
}

/// Share of machines and forces as they may be on which all drive forces along `kept` are at most `limit`, in N: solved point by point, from another seed.
fn share_within(job: &ProgramJob, kept: &Kept, limit: f64, count: usize) -> f64 {
    let uncertainty = job.uncertainty.as_ref().unwrap();
    let holds = |Drawn { unloaded, actual, factor }: Drawn| {
        let mut session = Session::new(&job.machine, &actual, settings()).with_unloaded_machine(&unloaded);
        kept.tasks.iter().zip(&kept.commanded).all(|(task, commanded)| {
            let task = TaskPoint { load: task.load.scale(factor), ..*task };
            let answer = simulate(&mut session, &task, commanded);
            assert!(answer.outcome.is_some(), "{:?}", answer.status);
            answer.drive_forces.iter().all(|force| force.abs() <= limit)
        })
    };
    let within = draws(uncertainty, &job.process.errors, count).map(holds).filter(|own| *own).count();
    within as f64 / count as f64
}

/// The force of a prismatic joint is the cutting force, whatever the correction: the probability that it is within its limit is that of a lognormal number.
#[test]
fn the_force_of_a_slide_is_within_its_limit_with_the_exact_probability() {
    let relative = 0.15f64;
    let std = (0.5 * (1.0 + (1.0 + 4.0 * relative * relative).sqrt())).ln().sqrt();
    let process =
        |z: f64| format!("{ALONG}[limits]\nforce_limit_N = {:?}\n{}", 1000.0 * (std * z).exp(), force_std(relative));
    for z in [2.1, 2.6] {
        let (verified, _) = bounded(&job("lever", &process(z), ("part.nc", ALONG_NC))).unwrap();
        let (forces, exact) = (verified.forces.unwrap(), normal_cdf(z));
        let share = forces.within as f64 / forces.draws as f64;
        let error = 3.0 * (exact * (1.0 - exact) / forces.draws as f64).sqrt();
        assert!((share - exact).abs() < error, "{share} instead of {exact}: {forces:?}");
        // The density of the normal distribution at its 95 % quantile is 0.103.
        let quantile = (forces.p95.value / 1000.0).ln() / std;
        assert!((quantile - 1.645).abs() < 3.0 * (0.05f64 * 0.95 / 512.0).sqrt() / 0.103, "{quantile}");
        // What no correction changes cannot be tightened.
        assert_eq!((forces.failed, &forces.tightened[..]), (0, &[0.0][..]));
    }
    let problem = bounded(&job("lever", &process(1.0), ("part.nc", ALONG_NC))).map(|_| ()).unwrap_err().to_string();
    assert!(problem.starts_with("limits: drive forces stay within their limits in only 4"), "{problem}");
    assert!(
        problem.contains("in 95 of 100 the force of drive guide is up to 1") && problem.contains("line 3"),
        "{problem}"
    );
    assert!(problem.contains("its force cannot be brought below 1000.000 N"), "{problem}");
    // With exact inputs it holds.
    let exact = process(1.0).split("[uncertainty").next().unwrap().to_owned();
    assert!(bounded(&job("lever", &exact, ("part.nc", ALONG_NC))).unwrap().0.forces.is_none());
}

/// Of two tools with a force each, the larger is within the limit where both are.
#[test]
fn forces_of_two_tools_are_independent() {
    let relative = 0.15f64;
    let std = (0.5 * (1.0 + (1.0 + 4.0 * relative * relative).sqrt())).ln().sqrt();
    let uncertainty = force_std(relative).replace("[uncertainty.model]", "force_per_tool = true\n[uncertainty.model]");
    let limit = 1000.0 * (std * 2.6).exp();
    let process = format!("{ALONG}[compensate]\ncorner_mm = 0.0\n[limits]\nforce_limit_N = {limit:?}\n{uncertainty}");
    let two = "G21 G90\nT1 M6\nG0 X-0.5 Y0 Z0\nG1 X0.5 F600\nT2 M6\nG1 X-0.5\n";
    let quantile = |program: &str| {
        let forces = bounded(&job("lever", &process, ("part.nc", program))).unwrap().0.forces.unwrap();
        (forces.p95.value / 1000.0).ln() / std
    };
    // The density of the larger of two normal numbers at its 95 % quantile, 1.955, is 0.115.
    for (program, exact, density) in [(two, 1.955, 0.115), (&two.replace("T2 M6\n", ""), 1.645, 0.103)] {
        let found = quantile(program);
        assert!((found - exact).abs() < 3.0 * (0.05f64 * 0.95 / 512.0).sqrt() / density, "{found} instead of {exact}");
    }
}

/// Corrections move the tool to where forces are smaller: the tightened program is within its limits on other draws, the one by nominal numbers is not.
#[test]
fn tightened_forces_agree_with_brute_force() {
    let process = format!("{ORTHOGLIDE}[limits]\nforce_limit_N = {LIMIT:?}\n");
    let uncertain = job("orthoglide", &format!("{process}{UNCERTAIN}"), ("part.nc", NC));
    let (verified, kept) = bounded(&uncertain).unwrap();
    let forces = verified.forces.unwrap();
    let reported = forces.within as f64 / forces.draws as f64;
    let found = share_within(&uncertain, &kept, LIMIT * (1.0 + 1e-6), 1024);
    assert!(found > 0.95 && (found - reported).abs() < 0.025, "{found}: {forces:?}");
    assert!(forces.tightened.iter().any(|share| *share > 0.0), "{forces:?}");

    let (nominal, kept) = bounded(&job("orthoglide", &process, ("part.nc", NC))).unwrap();
    assert!(nominal.forces.is_none());
    let without = share_within(&uncertain, &kept, LIMIT * (1.0 + 1e-6), 1024);
    assert!(without < 0.9, "{without}");

    // The same draws on any number of threads.
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| bounded(&uncertain).unwrap().0)
    };
    let [one, two] = [1, 2].map(on);
    assert_eq!((one.forces.as_ref(), two.forces.as_ref()), (Some(&forces), Some(&forces)));
    assert!(one.written.bytes == two.written.bytes && one.written.bytes == verified.written.bytes);
}

/// Where no force is limited, or nothing that a force depends on is uncertain, corrections are those of exact inputs.
#[test]
fn nothing_is_tightened_where_no_limited_force_is_uncertain() {
    let setup = format!("[uncertainty.process]\ntool_length_mm = {{ std = 0.02 }}\n{EXACT_MODEL}");
    for (limits, uncertain) in [("max_correction_mm = 0.5", force_std(0.15)), ("force_limit_N = 600.0", setup)] {
        let process = format!("{ORTHOGLIDE}[limits]\n{limits}\n");
        let (exact, _) = bounded(&job("orthoglide", &process, ("part.nc", NC))).unwrap();
        let (found, _) = bounded(&job("orthoglide", &format!("{process}{uncertain}"), ("part.nc", NC))).unwrap();
        assert!(found.forces.is_none() && found.spread.is_some());
        assert_eq!((found.written.bytes, found.bounded), (exact.written.bytes, exact.bounded), "{limits}");
    }
}

/// Runs `compensate --method bounded` in a new folder: exit code, words of both outputs, and the folder.
fn command(limits: &str) -> (Option<i32>, String, tempfile::TempDir) {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let process = format!("schema = 1\n{ORTHOGLIDE}[limits]\n{limits}\n{UNCERTAIN}");
    let texts = [("part.nc", NC), ("process.toml", &process)];
    texts.iter().for_each(|(name, text)| std::fs::write(at(name), text).unwrap());
    let (part, process, out) = (at("part.nc"), at("process.toml"), at("out.nc"));
    let own = ["compensate", &part, "--machine", "orthoglide", "--process", &process, "--out", &out];
    let (code, out, err) = told(&[&own[..], &["--method", "bounded"]].concat());
    (code, (out + &err).split_whitespace().collect::<Vec<_>>().join(" "), folder)
}

#[test]
fn a_program_says_with_which_probability_limits_of_forces_hold() {
    let (code, words, folder) = command(&format!("force_limit_N = {LIMIT:?}"));
    // The limit costs more than compensation gains: the program is written, and its exit code is no success.
    assert!(
        code == Some(1)
            && words.starts_with("✗ Probably worse than without compensation [simulated] ● force ")
            && words.contains(" ○ vibration Off with 95 %: within ")
            && words.contains("compute again. Probably worse than without compensation"),
        "{code:?} {words}"
    );
    let report = std::fs::read_to_string(folder.path().join("out.nc.report.json")).unwrap();
    let report: Value = serde_json::from_str(&report).unwrap();
    let forces = &report["bounded"]["forces"];
    let share = forces["probability"].as_f64().unwrap();
    let [low, high] = [0, 1].map(|end| forces["probability_interval_95"][end].as_f64().unwrap());
    assert!(share >= 0.95 && low < share && share < high && high - low < 0.05, "{forces}");
    assert!(forces["tightened_share"].as_object().unwrap().len() == 3, "{forces}");
    for sentence in [
        "Drive forces stay within their limits all along it with 9".to_owned(),
        "for that their limits were tightened by up to ".into(),
        format!("hold all along the program as written in {} (", forces["draws_within"]),
        "Tightened in the optimisation: the force limits of drive ".into(),
        "With nominal numbers that leaves up to ".into(),
        "Limits of corrections are limits of commands: they hold on any machine. With nominal numbers: Limits bind"
            .into(),
    ] {
        assert!(words.contains(&sentence), "{sentence} is missing in {words}");
    }
    let page = std::fs::read_to_string(folder.path().join("out.nc.html")).unwrap();
    assert!(page.contains("Drive forces stay within their limits all along it with 9"));

    // The correction may not be as large: nothing is written.
    let (code, words, folder) = command(&format!("max_correction_mm = 0.1\nforce_limit_N = {LIMIT:?}"));
    assert!(code == Some(2) && words.contains("expected 95 %: in 95 of 100 the force of drive "), "{code:?} {words}");
    assert!(words.contains("A smaller cutting force, a higher limit") && words.contains("line "), "{words}");
    let left: Vec<_> = std::fs::read_dir(folder.path()).unwrap().map(|own| own.unwrap().file_name()).collect();
    assert_eq!(left.len(), 2, "{left:?}");

    let (code, words, _) = command("max_correction_mm = 5.0");
    assert!(code == Some(0) && !words.contains("Drive forces stay within"), "{words}");
}
