//! Superposition with uncertain inputs: each draw is the study of that machine under that force, whatever solves it.

use std::sync::{
    Arc,
    atomic::{AtomicBool, AtomicUsize, Ordering},
};

use crate::support::{
    command::told,
    engine::settle,
    results::assert_same,
    uncertain::{Drawn, TOLERANCES, draws, study_text},
};
use kinetostat::{
    Error, Event, Overrides, RunOptions, Study, Work,
    process::uncertainty::{Draws, P95, quantile},
    questions::{
        StudyKind,
        superposition::{SuperpositionStudy, run_locations},
    },
    run::Start,
    spatial::Wrench,
    work::{part_file::Part, share::Share},
};
use nalgebra::Vector3;

const FORCE: [f64; 3] = [215.0, -10.0, -25.0];
const ERRORS: &str = "[[process.chain_error]]\nchain = \"*\"\nturn_about_drive_axis_deg = 0.5\n";

fn text_of(machine: &str, force: [f64; 3], errors: &str, uncertainty: &str, question: &str) -> String {
    let [radial, tangential, axial] = force;
    let process = format!(
        "[process.force.path_frame]\nradial_force_N = {radial:?}\ntangential_force_N = {tangential:?}\naxial_force_N = {axial:?}\n{errors}"
    );
    let question = format!("[superposition]\ngrid = [1, 1, 1]\nphi_step_deg = 60.0\n{question}");
    study_text(machine, &process, uncertainty, &question)
}

fn open(text: &str) -> Study {
    Study::from_toml(text, "study.toml", kinetostat::Folder::in_memory([]), &Overrides::default()).unwrap()
}

fn study(text: &str) -> SuperpositionStudy {
    match open(text).kind {
        StudyKind::Superposition(study, _) => *study,
        _ => panic!("no superposition study"),
    }
}

fn errors_of(chains: &[&str]) -> String {
    chains.iter().map(|chain| ERRORS.replace('*', chain)).collect()
}

/// With a force alone that varies, quantiles and probability are those of the nominal study with the force times the factors of the draws.
#[test]
fn a_force_that_varies_gives_the_errors_of_the_study_with_that_force() {
    let text = |scale: f64, uncertainty: &str| {
        let force = FORCE.map(|own| own * scale);
        let place = "slices_z_mm = [0.0]\ntolerance_mm = 0.007\nlocation = [{ point = \"Q1\" }, { point = \"Q2\" }]";
        text_of("orthoglide", force, &errors_of(&["x", "y"]), uncertainty, place)
    };
    let uncertainty = "[uncertainty.process]\nforce_relative_std = 0.3\n[uncertainty.model]\nrelative_std = 0.5\n";
    let uncertain = study(&text(1.0, uncertainty));
    let factors = &uncertain.uncertainty.as_ref().unwrap().draws.force_of(0)[..Draws::PER_SCRAMBLE];
    let found = run_locations(&uncertain, &Work::default()).unwrap();
    let nominal = |scale: f64| -> Vec<f64> {
        let found = run_locations(&study(&text(scale, "")), &Work::default()).unwrap();
        assert!(found.iter().all(|location| location.spread.is_none()));
        found.iter().map(|location| location.superposition_errors.as_ref().unwrap().superposed_tool_mm()).collect()
    };
    let at = |share| nominal(quantile(&mut factors.to_vec(), share));
    let (median, p95, exact) = (at(0.5), at(P95), nominal(1.0));
    for (k, location) in found.iter().enumerate() {
        let spread = location.spread.as_ref().unwrap();
        assert!((spread.median_mm.unwrap() - median[k]).abs() < 1e-9, "{spread:?} instead of {median:?}");
        assert!((spread.p95_mm.unwrap() - p95[k]).abs() < 1e-9, "{spread:?} instead of {p95:?}");
        assert!((location.superposition_errors.as_ref().unwrap().superposed_tool_mm() - exact[k]).abs() < 1e-12);
        assert_eq!((spread.solved_draws, spread.failed_draws, spread.failed_share), (256, 0, 0.0));
        // The error grows with the force: the draws within tolerance are those below some factor.
        let within = spread.within_tolerance.unwrap();
        let mut sorted = factors.to_vec();
        sorted.sort_by(f64::total_cmp);
        let count = (within * 256.0).round() as usize;
        assert!(count > 10 && count < 250, "{within}");
        let [below, above] = [count - 1, count].map(|index| nominal(sorted[index])[k]);
        assert!(below <= 0.007 && above > 0.007, "{below} {above} {within}");
    }
}

/// Legs, an arm and six legs, weight among the sources: against draws of another seed, solved here one by one.
#[test]
fn machines_that_vary_agree_with_brute_force() {
    let count = 1024;
    // Turned about their axes, the screws of the last bring about nothing.
    let moved = "base_translation_mm = { uniform = [-0.2, 0.2] }";
    for (machine, pattern, chains, weight) in [
        ("orthoglide", "leg.*.stiffness", &["x", "y", "z"][..], false),
        ("kr500", "arm.*.stiffness", &["arm"], true),
        ("hexapod", "leg.screw.stiffness", &[], false),
    ] {
        let tolerances = match chains {
            [] => TOLERANCES.replace("turn_about_drive_axis_deg = { uniform = [-0.1, 0.1] }", moved),
            _ => TOLERANCES.into(),
        };
        let uncertainty =
            format!("[uncertainty]\n[[uncertainty.parameter]]\nname = \"{pattern}\"\nrelative_std = 0.3\n{tolerances}");
        let machine_of = kinetostat::Machine::named_or_file(machine).unwrap();
        assert_eq!(machine_of.own_load_text().is_some(), weight, "{machine}");
        let home: [f64; 3] = machine_of.home.pose.translation.into();
        let z = 0.5 * (machine_of.workspace.min.z + machine_of.workspace.max.z);
        let place = format!(
            "slices_z_mm = [{z:?}]\ntolerance_mm = 0.01\nlocation = [{{ name = \"home\", position_mm = {home:?} }}]"
        );
        let force = FORCE.map(|own| 3.0 * own);
        let study = study(&text_of(machine, force, &errors_of(chains), &uncertainty, &place));
        let load_case = &study.load_case;
        let found = run_locations(&study, &Work::default()).unwrap().remove(0);
        let spread = found.spread.unwrap();
        let at = load_case.machine.inverse_kinematics_at(study.locations[0].position).unwrap();
        let tool = load_case.machine.tool_at(&at.pose.rotation);
        let mut sizes: Vec<f64> = draws(study.uncertainty.as_ref().unwrap(), &load_case.errors, count)
            .map(|Drawn { unloaded, actual, factor }| {
                let tip = |machine, load: &Wrench| -> Vector3<f64> {
                    let pose = settle(machine, &at, load).0.pose;
                    load_case.machine.tool_displacement(&at.pose, &pose)
                };
                let rest = [&unloaded, &actual].map(|machine| tip(machine, &Wrench::zero()));
                let error = |phi: &f64| {
                    let load = load_case.force.wrench(*phi, &tool).scale(factor);
                    let [by_force, both] = [&unloaded, &actual].map(|machine| tip(machine, &load));
                    // Whatever is measured from: what each does by itself, added, less both.
                    (by_force - rest[0] + rest[1] - both).norm()
                };
                load_case.phis.iter().map(error).fold(0.0, f64::max)
            })
            .collect();
        sizes.sort_by(f64::total_cmp);
        for (value, share) in [(spread.p95_mm.unwrap(), P95), (spread.median_mm.unwrap(), 0.5)] {
            // Three standard errors of as many independent draws, of both.
            let error = 3.0 * (share * (1.0 - share) * (1.0 / 256.0 + 1.0 / count as f64)).sqrt();
            let [low, high] = [share - error, share + error].map(|share| quantile(&mut sizes.clone(), share));
            assert!((low..=high).contains(&value), "{machine}: {value}, not {low} to {high} ({share})");
            assert!(low > 1e-5 && high < 2.5 * low, "{machine}: {low} to {high}");
        }
        let expected = sizes.iter().filter(|size| **size <= 0.01).count() as f64 / count as f64;
        assert!((spread.within_tolerance.unwrap() - expected).abs() < 0.09, "{machine}: {expected} {spread:?}");
    }
}

const PLACES: &str = "slices_z_mm = [0.0]\ntolerance_mm = 0.01\nlocation = [{ point = \"Q1\" }, { point = \"Q2\" }]";

fn uncertain_text() -> String {
    let uncertainty = format!(
        "[uncertainty]\nmachine = \"provenance\"\n[[uncertainty.parameter]]\nname = \"leg.*.stiffness\"\nrelative_std = 0.3\n{TOLERANCES}\
         [uncertainty.model]\nrelative_std = 0.4\n"
    );
    text_of("orthoglide", FORCE, &errors_of(&["x"]), &uncertainty, PLACES)
}

/// Threads, parts and a run that is stopped and taken up again leave the same bytes.
#[test]
fn threads_parts_and_stops_leave_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let study = open(&uncertain_text());
    let stop = || Arc::new(AtomicBool::new(false));
    let options = |begin| RunOptions { figures: false, begin, ..RunOptions::default() };
    let on = |threads: usize, work: &(dyn Fn() + Sync)| {
        rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(work);
    };
    let at = |name: &str| folder.path().join(name);
    for (threads, name) in [(1, "one"), (2, "two")] {
        on(threads, &|| {
            study.run_into(&at(name), &options(Start::New), stop(), |_| ()).unwrap();
        });
    }
    assert_same(&at("two"), &at("one"), "threads");
    let parts: Vec<Part> = (1..=2)
        .map(|part| {
            let share = Share::new(part, 2).unwrap();
            let bytes = study.part(share, Vec::new(), None, stop(), |_| ()).unwrap();
            let source = kinetostat::work::part_file::PartSource::Bytes(format!("part {part}"), bytes.into());
            Part::read(source).unwrap()
        })
        .collect();
    study.merge_into(parts, &at("merged"), &options(Start::New), stop(), |_| ()).unwrap();
    assert_same(&at("merged"), &at("one"), "parts");
    // Stopped once the map and one location are kept, on one thread.
    on(1, &|| {
        let (flag, computed) = (stop(), AtomicUsize::new(0));
        let set = Arc::clone(&flag);
        let watch = move |event| {
            if matches!(event, Event::Computed(1)) && computed.fetch_add(1, Ordering::Relaxed) == 1 {
                set.store(true, Ordering::Relaxed);
            }
        };
        let stopped = study.run_into(&at("stopped"), &options(Start::New), flag, watch);
        assert!(matches!(stopped, Err(Error::Stopped)));
        let kept = Arc::new(AtomicUsize::new(0));
        let count = Arc::clone(&kept);
        let watch = move |event| {
            if let Event::Resumed { pieces, .. } = event {
                count.store(pieces, Ordering::Relaxed);
            }
        };
        study.run_into(&at("stopped"), &options(Start::Resume), stop(), watch).unwrap();
        assert_eq!(kept.load(Ordering::Relaxed), 2);
    });
    assert_same(&at("stopped"), &at("one"), "stopped and resumed");
}

/// The command line: the verdict first, what it is of, the columns and the summary.
#[test]
fn the_answer_begins_with_the_probability() {
    let folder = tempfile::tempdir().unwrap();
    let study = folder.path().join("study");
    std::fs::create_dir(&study).unwrap();
    std::fs::write(study.join("study.toml"), uncertain_text()).unwrap();
    let out = folder.path().join("out");
    let arguments = ["run", study.to_str().unwrap(), "--out", out.to_str().unwrap(), "--verbose", "--no-figures"];
    let (code, said, err) = told(&arguments);
    assert_eq!(code, Some(0), "{said}{err}");
    let said = said.split_whitespace().collect::<Vec<_>>().join(" ");
    for expected in [
        "the superposition error is within 0.01 mm with ",
        " probability at Q",
        "Nominally, the effects of cutting force and chain errors may ",
        "not exceeded with 95 % probability, at the tool tip, at Q",
        "solved in 256 draws. The map, largest factors, growth and causes are nominal.",
        "What the model leaves out does not count here",
        "1 grid point, 6 tool angles, a cutting force of 217 N, 256 draws, all points solved",
        "With uncertain inputs: median ",
    ] {
        assert!(said.contains(expected), "{expected}: {said}");
    }
    assert!(!said.contains("inexact model") && !said.contains("4096"), "{said}");
    let mut reader = csv::Reader::from_path(out.join("locations.csv")).unwrap();
    let header = reader.headers().unwrap().clone();
    let column = |name: &str| header.iter().position(|own| own == name).unwrap_or_else(|| panic!("{name}"));
    let rows: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
    assert_eq!(rows.len(), 8);
    for row in &rows {
        let is_tool = &row[column("sum")] == "superposition" && &row[column("followed")] == "tool";
        for name in ["superposition_error_p95_mm", "superposition_error_median_mm", "within_tolerance_probability"] {
            assert_eq!(row[column(name)].parse::<f64>().is_ok(), is_tool, "{name}: {row:?}");
        }
        assert_eq!(&row[column("spread_solved_draws")], if is_tool { "256" } else { "" });
        assert!(row[column("spread_reason")].is_empty());
    }
    let summary: serde_json::Value = serde_json::from_slice(&std::fs::read(out.join("summary.json")).unwrap()).unwrap();
    let first = &rows[0];
    for name in ["superposition_error_p95_mm", "superposition_error_median_mm", "within_tolerance_probability"] {
        assert_eq!(summary["locations"][0][name].as_f64(), first[column(name)].parse().ok(), "{name}");
    }
    assert_eq!(summary["locations"][0]["failed_draws_share"], 0.0);
    assert_eq!(summary["uncertainty"]["draws"], 256);
    let page = std::fs::read_to_string(out.join("report.html")).unwrap();
    assert!(page.contains("256 draws") && page.contains("the superposition error is within"), "the page");
}
