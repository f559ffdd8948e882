//! Online studies: measured forces against predicted ones.

use std::path::Path;

use kinetostat::{
    questions::{
        Overrides, Study, StudyKind,
        online::{OnlineResults, run},
    },
    work::Work,
};

use crate::support::command::told;

/// A circle on the Orthoglide; `online` and `process` are added to their tables.
fn study(online: &str, process: &str) -> Study {
    let text = format!(
        r#"
schema = 2
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
        results(&given, "").loop_gain.unwrap().is_safe().unwrap()
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
