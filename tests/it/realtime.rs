//! Loaded kinematics for controllers: what is generated, how closely it answers, and what is refused.

use std::{collections::HashMap, sync::OnceLock};

use kinetostat::{
    compensation::{Method, Target, TaskPoint, compensate},
    files::Foreign,
    machine::{Machine, catalogue},
    products::realtime::{Domain, MANIFEST, Question, Realtime, Start, files, generate, write},
    simulation::{Machines, Source},
    spatial::Wrench,
    statics::{Scratch, Settings, State, equilibrium},
};
use nalgebra::Vector3;

use crate::support::command::told;

const FORCE: f64 = 250.0;
const MOMENT: f64 = 2500.0;

fn question(machine: &str, errors_deg: &[f64], steps: usize) -> Question {
    question_of(Machine::named_or_file(machine).unwrap(), errors_deg, steps)
}

fn question_of(nominal: Machine, errors_deg: &[f64], steps: usize) -> Question {
    let errors = nominal.assembly_errors(errors_deg);
    Question {
        machines: Machines::new(&nominal, &errors).unwrap(),
        errors,
        domain: Domain::new(Domain::workspace(&nominal), FORCE, MOMENT).unwrap(),
        steps,
        places: 64,
        uncertainty: None,
        tolerance_mm: None,
    }
}

/// The Orthoglide with errors of its chains, generated once.
fn orthoglide() -> &'static Realtime {
    static MADE: OnceLock<Realtime> = OnceLock::new();
    MADE.get_or_init(|| generate(question("orthoglide", &[1.0, -1.0, 1.0], 2)).unwrap_or_else(|e| panic!("{e}")))
}

/// Numbers from -1 to 1, always the same.
fn numbers() -> impl Iterator<Item = f64> {
    let mut seed = 0x2545_F491_4F6C_DD1D_u64;
    std::iter::repeat_with(move || {
        seed ^= seed << 13;
        seed ^= seed >> 7;
        seed ^= seed << 17;
        (seed >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    })
}

/// Positions of the tool tip and wrenches about it, all over the domain.
fn asked(domain: Domain) -> impl Iterator<Item = ([f64; 3], [f64; 6])> {
    let mut numbers = numbers();
    std::iter::repeat_with(move || {
        let mut next = || numbers.next().unwrap();
        let (low, high) = (domain.low, domain.high);
        let position = std::array::from_fn(|i| low[i] + 0.5 * (next() + 1.0) * (high[i] - low[i]));
        (position, std::array::from_fn(|i| domain.wrench[i] * next()))
    })
}

/// Where the tool tip stands with these drives, by the engine, from where the rigid machine is.
fn tip(realtime: &Realtime, position: &[f64; 3], wrench: &[f64; 6], drives: &[f64; 3]) -> Vector3<f64> {
    let Machines { nominal, actual, .. } = &realtime.question.machines;
    let lever = nominal.home.pose.rotation * nominal.tool_tip;
    let at = nominal.inverse_kinematics(&nominal.pose_at(Vector3::from(*position) - lever)).unwrap();
    let own = Wrench::new(*wrench);
    let load = Wrench { force: own.force, moment: own.moment + lever.cross(&own.force) };
    let mut state = State::rigid(nominal, &at);
    let settings = Settings { tolerance: 1e-13, ..Settings::default() };
    let outcome = equilibrium(actual, drives, &load, &mut state, &mut Scratch::new(actual), &settings);
    assert!(outcome.is_equilibrium(), "{:?}", outcome.status);
    state.pose.transform(actual.tool_tip)
}

#[test]
fn each_step_squares_the_error_and_two_are_enough() {
    let realtime = orthoglide();
    for errors in [&realtime.correct.errors, &realtime.whereabouts.errors] {
        let [start, one, two] = errors.found_mm[..] else { panic!("{errors:?}") };
        assert!(start < 3.0 && one < 0.1 * start && two < 1e-2 * one, "{errors:?}");
        assert!(errors.stated_mm() >= 2.0 * two && errors.stated_mm() < 1e-6, "{errors:?}");
    }
}

#[test]
fn drives_and_positions_are_those_of_the_engine_within_the_stated_error() {
    let realtime = orthoglide();
    for (position, wrench) in asked(realtime.question.domain).take(100) {
        let drives = realtime.correct(&position, &wrench);
        let stands = tip(realtime, &position, &wrench, &drives);
        let off = (stands - Vector3::from(position)).norm();
        assert!(off <= realtime.correct.errors.stated_mm(), "{off} mm at {position:?} under {wrench:?}");
        let found = Vector3::from(realtime.whereabouts(&drives, &wrench));
        let off = (stands - found).norm();
        assert!(off <= realtime.whereabouts.errors.stated_mm(), "{off} mm at {position:?} under {wrench:?}");
    }
}

#[test]
fn loads_and_errors_are_in_it() {
    let realtime = orthoglide();
    let nominal = &realtime.question.machines.nominal;
    let position = [40.0, -20.0, 120.0];
    let rigid = nominal.inverse_kinematics(&nominal.pose_at(Vector3::new(40.0, -20.0, 20.0))).unwrap();
    let unloaded = Vector3::from(realtime.correct(&position, &[0.0; 6]));
    let by_errors = (unloaded - Vector3::from_column_slice(&rigid.drives)).amax();
    assert!(by_errors > 0.1, "errors of one degree move the drives by {by_errors} mm");
    let loaded = Vector3::from(realtime.correct(&position, &[200.0, 0.0, 0.0, 0.0, 0.0, 0.0]));
    let by_force = (loaded - unloaded).amax();
    assert!(by_force > 1e-2, "200 N move them by {by_force} mm");
}

#[test]
fn machines_with_weight_are_corrected_as_they_are_zeroed() {
    let orthoglide = catalogue::find("orthoglide").unwrap().toml;
    let controls = "controls = [\"x\", \"y\", \"z\"]\n";
    let heavy = orthoglide.replace(controls, &format!("{controls}mass = {{ kg = 40.0, at_mm = [0.0, 0.0, 30.0] }}\n"));
    let mut corrections = Vec::new();
    for zeroed in ["weightless", "at_home"] {
        let text = heavy.replace("schema = 1\n", &format!("schema = 1\nzeroed = \"{zeroed}\"\n"));
        let machine = Machine::from_toml(&text, "heavy.toml").unwrap();
        assert!(machine.has_weight());
        let realtime = generate(question_of(machine, &[0.2, 0.1, -0.2], 2)).unwrap();
        let Machines { nominal, .. } = &realtime.question.machines;
        let mut session = realtime.question.machines.session(Source::All);
        for (position, wrench) in asked(realtime.question.domain).take(20) {
            let lever = nominal.home.pose.rotation * nominal.tool_tip;
            let own = Wrench::new(wrench);
            let load = Wrench { force: own.force, moment: own.moment + lever.cross(&own.force) };
            let pose = nominal.pose_at(Vector3::from(position) - lever);
            let task = TaskPoint::new(pose, load, Target::ToolTip);
            let expected = compensate(&mut session, &task, Method::Direct).drives;
            let drives = realtime.correct(&position, &wrench);
            let off = Vector3::from(drives) - Vector3::from_column_slice(&expected);
            assert!(off.norm() < 3.0 * realtime.correct.errors.stated_mm(), "{zeroed}: {off}");
            let back = Vector3::from(realtime.whereabouts(&drives, &wrench)) - Vector3::from(position);
            let stated = realtime.correct.errors.stated_mm() + realtime.whereabouts.errors.stated_mm();
            assert!(stated < 1e-5 && back.norm() < stated, "{zeroed}: {back}");
        }
        commands_the_rigid_machine(&realtime);
        corrections.push(realtime.correct(&[0.0, 0.0, 100.0], &[0.0; 6]));
    }
    let apart = Vector3::from(corrections[0]) - Vector3::from(corrections[1]);
    assert!(apart.norm() > 1e-3, "zeroed at home, its drives stand {apart} mm apart from there");
    let at_rest =
        generate(question_of(Machine::from_toml(&heavy, "heavy.toml").unwrap(), &[], 2)).unwrap_err().to_string();
    assert!(
        at_rest.contains("the machine has weight and is zeroed at rest") && at_rest.contains("\"at_home\""),
        "{at_rest}"
    );
}

#[test]
fn without_correction_drives_are_those_of_the_rigid_machine() {
    commands_the_rigid_machine(orthoglide());
}

/// Whether its nominal drives are those of inverse kinematics, all over the domain.
fn commands_the_rigid_machine(realtime: &Realtime) {
    let nominal = &realtime.question.machines.nominal;
    let lever = nominal.home.pose.rotation * nominal.tool_tip;
    let stated = realtime.nominal.errors.stated_mm();
    assert!(stated < 1e-6);
    for (position, _) in asked(realtime.question.domain).take(100) {
        let rigid = nominal.inverse_kinematics(&nominal.pose_at(Vector3::from(position) - lever)).unwrap();
        let off = Vector3::from(realtime.nominal(&position)) - Vector3::from_column_slice(&rigid.drives);
        assert!(off.norm() < 3.0 * stated, "{off} at {position:?}");
    }
}

/// What a generated function computes, read from its text.
fn run(text: &str, name: &str, inputs: &[f64]) -> Vec<f64> {
    let body = text.split_once(&format!("pub fn {name}(")).unwrap().1.split_once("\n}").unwrap().0;
    let mut known: HashMap<&str, f64> = HashMap::new();
    let mut rest = inputs.iter();
    let value = |known: &HashMap<&str, f64>, word: &str| {
        let bare = word.trim_start_matches('(').trim_end_matches(')');
        bare.parse().ok().or_else(|| known.get(bare).copied()).unwrap_or_else(|| panic!("{word} is not known"))
    };
    for line in body.lines().skip(1) {
        let words: Vec<&str> = line.trim().trim_end_matches(';').split(' ').collect();
        match words[..] {
            ["let", first, ..] if first.starts_with('[') => {
                let (names, _) = line.split_once('[').unwrap().1.split_once(']').unwrap();
                for name in names.split(", ") {
                    known.insert(name, *rest.next().unwrap());
                }
            }
            ["let", name, "=", a, operation, b] => {
                let (a, b) = (value(&known, a), value(&known, b));
                let result = match operation {
                    "+" => a + b,
                    "-" => a - b,
                    "*" => a * b,
                    "/" => a / b,
                    other => panic!("{other} in {line}"),
                };
                known.insert(name, result);
            }
            ["let", name, "=", "if", a, ">", b, "{", yes, "}", "else", "{", no, "}"] => {
                let chosen = if value(&known, a) > value(&known, b) { yes } else { no };
                known.insert(name, value(&known, chosen));
            }
            ["let", name, "=", single] => {
                let inner = single.strip_prefix("size(").and_then(|rest| rest.strip_suffix(')'));
                let result = match (inner, single.strip_prefix('-')) {
                    (Some(inner), _) => value(&known, inner).abs(),
                    (None, Some(other)) => -value(&known, other),
                    (None, None) => panic!("{line}"),
                };
                known.insert(name, result);
            }
            _ => {
                let list = line.trim().trim_start_matches('[').trim_end_matches(']');
                return list.split(", ").map(|word| value(&known, word)).collect();
            }
        }
    }
    panic!("{name} returns nothing")
}

/// The coefficients in a generated module.
fn coefficients(text: &str) -> Vec<Vec<f64>> {
    let rows =
        text.split_once("static COEFFICIENTS").unwrap().1.split_once("= [\n").unwrap().1.split_once("\n];").unwrap().0;
    let numbers =
        |row: &str| row.trim().trim_matches([',', '[', ']']).split(", ").map(|n| n.parse().unwrap()).collect();
    rows.lines().map(numbers).collect()
}

/// Names and texts of the generated files, in the order in which they are placed.
fn written(realtime: &Realtime) -> Vec<(String, String)> {
    let folder = tempfile::tempdir().unwrap();
    let names: Vec<String> = files(realtime).iter().map(|file| file.name.clone()).collect();
    write(realtime, folder.path(), Foreign::Kept).unwrap();
    let text = |name: String| (name.clone(), std::fs::read_to_string(folder.path().join(name)).unwrap());
    names.into_iter().map(text).collect()
}

#[test]
fn what_is_written_is_what_was_recorded() {
    let realtime = orthoglide();
    let files: HashMap<String, String> = written(realtime).into_iter().collect();
    let (correct, whereabouts) = (&files["src/correct.rs"], &files["src/whereabouts.rs"]);
    let start = |module: &str, at: &[f64; 3], wrench: &[f64; 6]| {
        let terms = run(module, "terms", &[&at[..], wrench].concat());
        let rows = coefficients(module);
        let mut state = vec![0.0; rows[0].len()];
        for (row, term) in rows.iter().zip(terms) {
            state.iter_mut().zip(row).for_each(|(number, coefficient)| *number += coefficient * term);
        }
        state
    };
    for (position, wrench) in asked(realtime.question.domain).take(3) {
        let mut state = start(correct, &position, &wrench);
        for _ in 0..2 {
            state = run(correct, "step", &[&state[..], &position, &wrench].concat());
        }
        let drives = realtime.correct(&position, &wrench);
        assert_eq!(state[..3], drives);
        let mut state = [&drives[..], &start(whereabouts, &drives, &wrench)].concat();
        for _ in 0..2 {
            state = run(whereabouts, "step", &[&state[..], &wrench].concat());
        }
        let axes: Vec<Vector3<f64>> = state[3..12].chunks(3).map(Vector3::from_column_slice).collect();
        let tip = Vector3::from_column_slice(&state[12..15]) + axes[2] * 100.0;
        assert!((tip - Vector3::from(realtime.whereabouts(&drives, &wrench))).norm() < 1e-12);
    }
}

#[test]
fn the_same_question_has_the_same_bytes() {
    let again = generate(question("orthoglide", &[1.0, -1.0, 1.0], 2)).unwrap();
    assert!(written(orthoglide()) == written(&again));
    // Without it nothing builds: an export that is cut short is no mixture of two.
    assert_eq!(written(&again).last().unwrap().0, MANIFEST);
}

#[test]
fn other_machines_with_three_translations_have_code_as_well() {
    for name in ["tripteron", "delta_3puu", "delta_3prpar", "rotary_delta"] {
        // The middle of the workspace, of which the corners of some are nearly singular.
        let [low, high] = Domain::workspace(&Machine::named(name).unwrap());
        let (middle, half) = (0.5 * (low + high), 0.3 * (high - low));
        let domain = Domain::new([middle - half, middle + half], 50.0, 500.0).unwrap();
        let asked = Question { domain, ..question(name, &[0.1, -0.1, 0.1], 3) };
        let realtime = generate(asked).unwrap_or_else(|e| panic!("{name}: {e}"));
        for errors in [&realtime.correct.errors, &realtime.whereabouts.errors] {
            assert!(errors.stated_mm() < 1e-6, "{name}: {errors:?}");
        }
    }
}

#[test]
fn other_machines_are_refused_by_what_is_missing() {
    for (machine, missing) in [
        (
            "hexapod",
            "its drives control x, y, z, rotation_x, rotation_y, rotation_z: expected the translations x, y, z",
        ),
        ("kr270", "expected the translations x, y, z and nothing else"),
        ("hybrid_3ups", "expected"),
    ] {
        let fault = generate(question(machine, &[], 2)).unwrap_err().to_string();
        assert!(fault.starts_with(&format!("--machine: {machine}: ")) && fault.contains(missing), "{fault}");
    }
    let fault = generate(question("orthoglide", &[], 0)).unwrap_err().to_string();
    assert_eq!(fault, "--steps: must be from 1 to 8, got 0");
    let far = Domain::new([Vector3::zeros(), Vector3::new(900.0, 10.0, 10.0)], 1.0, 1.0).unwrap();
    let fault = generate(Question { domain: far, ..question("orthoglide", &[], 2) }).unwrap_err().to_string();
    assert!(
        fault.starts_with("--box: the machine does not stand with its tool tip at (")
            && fault.contains("expected a box")
    );
    let empty = Domain::new([Vector3::zeros(), Vector3::new(10.0, 0.0, 10.0)], 1.0, 1.0).unwrap_err().to_string();
    assert_eq!(empty, "--box: y from 0 to 0 mm is no range: expected the smaller first");
    let negative = Domain::new([Vector3::zeros(), Vector3::new(1.0, 1.0, 1.0)], 1.0, -1.0).unwrap_err().to_string();
    assert_eq!(negative, "--moment-Nmm: must be 0 or more, got -1");
}

#[test]
fn code_of_a_rotary_delta_is_generated_for_its_own_workspace() {
    let machine = Machine::named("rotary_delta").unwrap();
    let domain = Domain::new(Domain::workspace(&machine), 250.0, 2500.0).unwrap();
    let machines = Machines::new(&machine, &[]).unwrap();
    let question = Question { machines, errors: Vec::new(), domain, places: 20, ..question("orthoglide", &[], 2) };
    let realtime = generate(question).unwrap();
    // A corner of the workspace, unloaded: there the rigid machine stands with the drives of the engine.
    let at = [-300.0, -300.0, -1100.0];
    let rigid = machine.inverse_kinematics(&machine.pose_at(at.into())).unwrap();
    for (found, expected) in realtime.nominal(&at).iter().zip(&rigid.drives) {
        assert!((found - expected).abs() < 1e-6, "{found} {expected}");
    }
}

#[test]
fn the_command_writes_a_folder_and_replaces_what_it_wrote() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("correction");
    let shown = out.display().to_string();
    let export = |more: &[&str]| {
        let small = ["--box", "-10,-10,90,10,10,110", "--force-N", "20", "--moment-Nmm", "0", "--out", &shown];
        told(&[&["export-realtime", "--machine", "orthoglide"], &small[..], more].concat())
    };
    let (code, _, errors) = export(&["--steps", "0"]);
    assert!(code == Some(2) && errors.contains("--steps: must be from 1 to 8, got 0") && !out.exists(), "{errors}");
    let (code, said, errors) = export(&[]);
    assert_eq!(code, Some(0), "{errors}");
    assert!(said.contains("kinetostat_correct: error below") && said.contains("cargo build --release"), "{said}");
    for name in ["Cargo.toml", "src/lib.rs", "include/kinetostat_correction.h", "example/main.c", "README.md"] {
        let text = std::fs::read_to_string(out.join(name)).unwrap();
        assert!(text.contains("Generated by kinetostat export-realtime"), "{name}");
        let is_open = |(at, _): (usize, &str)| {
            let rest = text[at + 1..].trim_start_matches(|c: char| c.is_ascii_uppercase() || c == '_');
            rest.len() < text.len() - at - 1 && rest.starts_with('}')
        };
        assert!(!text.match_indices('{').any(is_open), "a word of {name} is not filled in");
    }
    // What an export that was killed left.
    let left = out.join(".partial-left");
    std::fs::create_dir(&left).unwrap();
    let mark = "Files that kinetostat has not finished: they go with its next run.\n";
    std::fs::write(left.join("kinetostat_unfinished"), mark).unwrap();
    assert_eq!(export(&[]).0, Some(0));
    assert!(!left.exists());
    std::fs::write(out.join("README.md"), "mine").unwrap();
    let (code, _, errors) = export(&[]);
    assert!(
        code == Some(2) && errors.contains("README.md: cannot be written: was not written by kinetostat"),
        "{errors}"
    );
    assert_eq!(export(&["--force"]).0, Some(0));
}

#[test]
fn a_start_of_the_degrees_of_a_polynomial_is_that_polynomial() {
    let range = Domain { low: [1.0, -2.0, 0.0], high: [3.0, 2.0, 0.5], wrench: [10.0, 10.0, 10.0, 0.0, 0.0, 0.0] };
    let state = |x: &[f64]| vec![x[0] * x[1] * x[2] - 2.0, x[2] * x[4] + x[0] * x[0] * x[1]];
    let inputs: Vec<Vec<f64>> =
        asked(range).take(100).map(|(position, wrench)| position.into_iter().chain(wrench).collect()).collect();
    let states: Vec<Vec<f64>> = inputs.iter().map(|inputs| state(inputs)).collect();
    let start = Start::fit(&range, (3, Some(1)), &inputs, &states).unwrap();
    assert_eq!(start.coefficients.len(), 20 + 3 * 4);
    let inputs = [1.7, 0.3, 0.2, 4.0, -6.0, 1.0, 0.0, 0.0, 0.0];
    for (found, expected) in start.evaluate(&inputs).into_iter().zip(state(&inputs)) {
        assert!((found - expected).abs() < 1e-12, "{found} for {expected}");
    }
    assert!(Start::fit(&range, (7, None), &vec![inputs.to_vec(); 20], &vec![vec![1.0]; 20]).is_none());
}
