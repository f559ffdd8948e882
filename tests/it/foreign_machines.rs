//! Machines that the program was not written for (`tests/machines`): independent states, and chains of rigid links condensed
//! against the same equations uncondensed.

use crate::support::{
    Within,
    engine::{EXACT, at_position, position_in_box},
};
use kinetostat::{
    compensation::{Target, TaskPoint},
    inspect::machine_check::{self, report::machine_text},
    machine::{Configuration, Machine},
    spatial::{Pose, Wrench},
    statics::{
        Batch, Case, Level, Outcome, Scratch, Settings, State, Status, drive_force_sensitivity, equilibrium,
        unloaded_stiffness,
    },
};
use nalgebra::{DMatrix, Matrix6, Matrix6xX, Vector3, Vector6};
use serde_json::Value;

/// Machines with chains whose only compliance is in their drives, with the largest load each is tried under (N).
const RIGID_LINKS: [(&str, f64); 4] =
    [("hexapod", 4000.0), ("tricept", 3000.0), ("linear_delta", 1500.0), ("kr270", 2500.0)];

fn machine(name: &str) -> Machine {
    Machine::from_file(format!("{}/tests/machines/{name}.toml", env!("CARGO_MANIFEST_DIR")).as_ref())
        .unwrap_or_else(|e| panic!("{e}"))
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().expect("an array").iter().map(|v| v.as_f64().expect("a number")).collect()
}

#[test]
fn loaded_states_are_those_of_an_independent_solution() {
    let file = format!("{}/tests/machines/states.json", env!("CARGO_MANIFEST_DIR"));
    let all: Value = serde_json::from_str(&std::fs::read_to_string(file).unwrap()).unwrap();
    for name in ["kr270", "hexapod", "rrr3", "fivebar"] {
        let machine = machine(name);
        let states = all[name].as_array().unwrap_or_else(|| panic!("no states of {name}"));
        assert_eq!(states.len(), 3, "{name}");
        for case in states {
            let position = Vector3::from_row_slice(&numbers(&case["position_mm"]));
            let at = at_position(&machine, position);
            let wrench = Wrench::new(numbers(&case["wrench_N_Nmm"]).try_into().unwrap());
            let mut state = State::rigid(&machine, &at);
            let outcome = equilibrium(&machine, &at.drives, &wrench, &mut state, &mut Scratch::new(&machine), &EXACT);
            assert_eq!(outcome.status, Status::Solved, "{name} at {position:?}");
            let tip = state.pose.transform(machine.tool_tip) - at.pose.transform(machine.tool_tip);
            let what = format!("{name} at {position:?}: tool displacement");
            Within::RelativeToLargest(1e-8).check(&what, tip.as_slice(), &numbers(&case["tool_displacement_mm"]));
            let what = format!("{name} at {position:?}: platform");
            let platform = state.pose.translation;
            Within::Absolute(1e-8).check(&what, platform.as_slice(), &numbers(&case["platform_mm"]));
        }
    }
}

/// Numbers in −1..1, spread evenly.
fn share(i: usize, step: f64) -> f64 {
    2.0 * (0.5 + i as f64 * step).fract() - 1.0
}

/// Places all over the workspace, each with a load.
fn trials(machine: &Machine, largest: f64) -> Vec<(Configuration, Wrench)> {
    let trial = |i: usize| {
        let [a, b, c] = [0.8191725134, 0.6710436067, 0.5497004779].map(|step| 0.5 * (share(i, step) + 1.0));
        let at = at_position(machine, position_in_box(machine, 0.0, 1.0, [a, b, c]));
        let [x, y, z, l, m, n] = [0.755, 0.569, 0.4294, 0.3241, 0.2446, 0.1846].map(|step| share(i, step) * largest);
        let lever = 0.1 * machine.characteristic_length;
        (at, Wrench::new([x, y, z, l * lever, m * lever, n * lever]))
    };
    (1..=12).map(trial).collect()
}

struct Solved {
    state: State,
    outcome: Outcome,
    /// Change of the drives' forces per motion of each drive.
    force_sensitivity: Option<DMatrix<f64>>,
}

fn solve(machine: &Machine, at: &Configuration, load: &Wrench, mut scratch: Scratch) -> Solved {
    let mut state = State::rigid(machine, at);
    let outcome = equilibrium(machine, &at.drives, load, &mut state, &mut scratch, &EXACT);
    let twists = &outcome.drive_sensitivity;
    let force_sensitivity = drive_force_sensitivity(machine, &at.drives, &state, twists, &mut scratch);
    Solved { state, outcome, force_sensitivity }
}

/// Rotations of a twist matrix, or moments of a wrench, made comparable with displacements or forces.
fn scaled(matrix: &Matrix6<f64>, factor: f64) -> Matrix6<f64> {
    let lever = |i: usize| if i < 3 { 1.0 } else { factor };
    Matrix6::from_fn(|i, j| matrix[(i, j)] * lever(i) * lever(j))
}

fn scaled_rows(matrix: &Matrix6xX<f64>, factor: f64) -> Matrix6xX<f64> {
    let mut matrix = matrix.clone();
    matrix.fixed_rows_mut::<3>(3).scale_mut(factor);
    matrix
}

fn assert_close(what: &str, got: &[f64], expected: &[f64], allowed: f64) {
    let scale = expected.iter().fold(1e-300f64, |most, v| most.max(v.abs()));
    for (a, b) in got.iter().zip(expected) {
        assert!((a - b).abs() <= allowed * scale, "{what}: {a} against {b}, of {scale}");
    }
}

/// Compares what was found condensed and uncondensed, relative to the largest number of each kind.
fn assert_same(what: &str, machine: &Machine, at: &Configuration, condensed: &Solved, uncondensed: &Solved) {
    let reach = machine.characteristic_length;
    let (got, expected) = (&condensed.outcome, &uncondensed.outcome);
    assert_eq!(got.status, expected.status, "{what}");
    let twist = |state: &State| {
        let mut twist = crate::support::engine::motion_between(&at.pose, &state.pose);
        twist.fixed_rows_mut::<3>(3).scale_mut(reach);
        twist
    };
    let (a, b) = (twist(&condensed.state), twist(&uncondensed.state));
    assert_close(&format!("{what}: twist"), a.as_slice(), b.as_slice(), 1e-9);
    for (chain, (a, b)) in condensed.state.chains.iter().zip(&uncondensed.state.chains).enumerate() {
        let scaled = |wrench: &Wrench| {
            let mut wrench: Vector6<f64> = wrench.to_vector();
            wrench.fixed_rows_mut::<3>(3).unscale_mut(reach);
            wrench
        };
        let largest = uncondensed.state.chains.iter().map(|c| c.wrench.norm(reach)).fold(0.0, f64::max);
        let difference = (scaled(&a.wrench) - scaled(&b.wrench)).amax();
        assert!(difference <= 1e-9 * largest, "{what}: wrench of chain {chain} differs by {difference} N of {largest}");
    }
    let pairs = [
        ("stiffness", &got.stiffness, &expected.stiffness, 1.0 / reach),
        ("compliance", &got.compliance, &expected.compliance, reach),
    ];
    for (kind, got, expected, factor) in pairs {
        assert_eq!(got.is_some(), expected.is_some(), "{what}: {kind}");
        if let (Some(got), Some(expected)) = (got, expected) {
            let (got, expected) = (scaled(got, factor), scaled(expected, factor));
            assert_close(&format!("{what}: {kind}"), got.as_slice(), expected.as_slice(), 1e-9);
        }
    }
    let (a, b) = (scaled_rows(&got.drive_sensitivity, reach), scaled_rows(&expected.drive_sensitivity, reach));
    assert_close(&format!("{what}: drive sensitivity"), a.as_slice(), b.as_slice(), 1e-9);
    let (a, b) = (condensed.force_sensitivity.as_ref().unwrap(), uncondensed.force_sensitivity.as_ref().unwrap());
    let stiffest = machine.drives().map(|(_, drive)| drive.stiffness).fold(0.0, f64::max);
    let difference = (a - b).amax();
    assert!(difference <= 1e-9 * stiffest, "{what}: force sensitivity differs by {difference} of {stiffest}");
}

#[test]
fn rigid_links_condensed_have_the_answers_of_the_equations_as_they_stand() {
    for (name, largest) in RIGID_LINKS {
        let machine = machine(name);
        for (i, (at, load)) in trials(&machine, largest).into_iter().enumerate() {
            for share in [0.0, 0.05, 1.0] {
                let load = load.scale(share);
                let condensed = solve(&machine, &at, &load, Scratch::new(&machine));
                let uncondensed = solve(&machine, &at, &load, Scratch::uncondensed(&machine));
                assert_eq!(condensed.outcome.status, Status::Solved, "{name}, trial {i}");
                let what = format!("{name}, trial {i}, {share} of the load");
                if share > 0.0 {
                    assert_same(&what, &machine, &at, &condensed, &uncondensed);
                }
            }
        }
    }
}

#[test]
fn the_hexapod_and_the_arm_have_a_stiffness_and_the_tricept_does_not() {
    for (name, has_stiffness) in [("hexapod", true), ("kr270", true), ("tricept", false), ("linear_delta", false)] {
        let machine = machine(name);
        let stiffness = unloaded_stiffness(&machine, &machine.home, &mut Scratch::new(&machine));
        assert_eq!(stiffness.is_some(), has_stiffness, "{name}");
        let unloaded = solve(&machine, &machine.home, &Wrench::zero(), Scratch::new(&machine)).outcome;
        assert_eq!(unloaded.stiffness.is_some(), has_stiffness, "{name}");
        assert!(unloaded.compliance.is_some(), "{name}");
        if let (Some(a), Some(b)) = (stiffness, unloaded.stiffness) {
            let factor = 1.0 / machine.characteristic_length;
            assert_close(name, scaled(&a, factor).as_slice(), scaled(&b, factor).as_slice(), 1e-10);
        }
    }
}

#[test]
fn check_says_what_is_rigid_and_blames_no_drive_for_being_the_only_spring() {
    let expected = [
        ("hexapod", ["K_C at home        N/mm", "leg6 screw"]),
        ("tricept", ["none: rigid in 3 of 6 directions by chain centre\n", "no motion by     1 N·mm about z at P\n"]),
        (
            "linear_delta",
            ["none: rigid in 3 of 6 directions by chains leg1, leg2, leg3\n", "no motion by     1 N·mm about x at P\n"],
        ),
        ("kr270", ["K_C at home        N/mm", "robot A6"]),
    ];
    for (name, lines) in expected {
        let machine = machine(name);
        let findings = machine_check::check(&machine).unwrap();
        let text = machine_text(&machine, &findings);
        assert!(lines.iter().all(|line| text.contains(line)), "{text}");
        assert!(!text.contains("1000 times"), "{text}");
    }
    // N·m instead of N·mm in one drive of the arm is still asked about.
    let arm = std::fs::read_to_string(format!("{}/tests/machines/kr270.toml", env!("CARGO_MANIFEST_DIR"))).unwrap();
    let arm = Machine::from_toml(&arm.replace("stiffness_Nmm_per_rad = 3.8e9", "stiffness_Nmm_per_rad = 3.8e6"), "arm");
    let warnings = machine_check::check(&arm.unwrap_or_else(|e| panic!("{e}"))).unwrap().warnings;
    assert!(warnings.iter().any(|w| w.contains("A1: makes 99.") && w.contains("1000 times too small")), "{warnings:?}");
}

/// Legs between two ball joints turn idly about their lines; that changes nothing.
#[test]
fn a_hexapod_with_idle_legs_has_the_answers_of_one_without() {
    let text = std::fs::read_to_string(format!("{}/tests/machines/hexapod.toml", env!("CARGO_MANIFEST_DIR"))).unwrap();
    let ball = "{ revolute_joint = { name = \"u0\", axis = \"z\" } },\n  { revolute_joint = { name = \"u1\"";
    let idle = text.replace("{ revolute_joint = { name = \"u1\"", ball);
    let (plain, idle) = (machine("hexapod"), Machine::from_toml(&idle, "idle").unwrap_or_else(|e| panic!("{e}")));
    for (i, (at, load)) in trials(&plain, 4000.0).into_iter().take(4).enumerate() {
        let idle_at = at_position(&idle, at.pose.translation);
        let with = solve(&idle, &idle_at, &load, Scratch::new(&idle));
        let without = solve(&plain, &at, &load, Scratch::new(&plain));
        assert_same(&format!("trial {i}"), &idle, &at, &with, &without);
    }
}

/// Lanes leave to the scalar path what they cannot condense; they leave none of these. The drives end where they put the
/// tool right.
#[test]
fn rigid_links_are_compensated_in_lanes() {
    for (name, largest) in RIGID_LINKS {
        let machine = machine(name);
        let target = if machine.drive_count() == 6 { Target::FullPose } else { Target::ToolTip };
        for (at, load) in trials(&machine, largest) {
            let task = TaskPoint::new(at.pose, load, target);
            let task_error = |pose: &Pose| task.task_error(&machine, pose);
            let (mut state, mut drives) = (State::rigid(&machine, &at), at.drives.clone());
            let mut cases = [Case { drives: &mut drives, load, state: &mut state, task: Some(&task_error) }];
            let outcomes = Batch::new(&machine).equilibria_at_task(&mut cases, &EXACT);
            let outcome = outcomes[0].as_ref().unwrap_or_else(|| panic!("{name}: lanes gave up"));
            assert_eq!(outcome.status, Status::Solved, "{name}");
            assert!(task_error(&state.pose).size() < 1e-9, "{name}");
            let mut again = State::rigid(&machine, &at);
            let outcome =
                equilibrium(&machine, &drives, &load, &mut again, &mut Scratch::uncondensed(&machine), &EXACT);
            assert_eq!(outcome.status, Status::Solved, "{name}");
            assert!((again.pose.translation - state.pose.translation).norm() < 1e-9, "{name}");
        }
    }
}

/// A hexapod's stiffness is `Σ k s sᵀ` over its legs' lines: what drives alone make of it.
#[test]
fn the_stiffness_of_the_hexapod_is_that_of_six_axial_springs() {
    let machine = machine("hexapod");
    let at = at_position(&machine, Vector3::new(70.0, -40.0, -930.0));
    let mut expected = Matrix6::zeros();
    for chain in &machine.chains {
        let base = chain.route.base.translation;
        let hand = at.pose.compose(&chain.route.attachment.inverse()).translation;
        let line = (hand - base).normalize();
        let moment = (hand - at.pose.translation).cross(&line);
        let screw = Vector6::new(line.x, line.y, line.z, moment.x, moment.y, moment.z);
        expected += screw * screw.transpose() * chain.drives[0].stiffness;
    }
    let got = unloaded_stiffness(&machine, &at, &mut Scratch::new(&machine)).expect("a stiffness");
    let factor = 1.0 / machine.characteristic_length;
    assert_close("hexapod", scaled(&got, factor).as_slice(), scaled(&expected, factor).as_slice(), 1e-11);
}

#[test]
fn rigid_links_have_the_same_bits_in_lanes() {
    for (name, largest) in RIGID_LINKS {
        let machine = machine(name);
        let problems = trials(&machine, largest);
        let mut scratch = Scratch::new(&machine);
        let alone: Vec<(State, Outcome)> = problems
            .iter()
            .map(|(at, load)| {
                let mut state = State::rigid(&machine, at);
                let settings = Settings::default();
                let outcome = equilibrium(&machine, &at.drives, load, &mut state, &mut scratch, &settings);
                (state, outcome)
            })
            .collect();
        for level in Level::available() {
            let mut states: Vec<State> = problems.iter().map(|(at, _)| State::rigid(&machine, at)).collect();
            let mut drives: Vec<Vec<f64>> = problems.iter().map(|(at, _)| at.drives.clone()).collect();
            let cases = states.iter_mut().zip(&mut drives).zip(&problems);
            let mut cases: Vec<Case<'_>> =
                cases.map(|((state, drives), (_, load))| Case { drives, load: *load, state, task: None }).collect();
            let outcomes = Batch::at_level(&machine, level).equilibria(&mut cases, &Settings::default());
            for (i, (state, outcome)) in alone.iter().enumerate() {
                assert_eq!(&outcomes[i], outcome, "{name}, {level:?}, case {i}");
                assert_eq!(&states[i], state, "{name}, {level:?}, case {i}");
                assert_eq!(outcome.load_steps, 1, "{name}, case {i}");
            }
        }
    }
}
