//! Machines beyond the catalogue, drawn at random and often degenerate: no panic, no number that is not finite without a
//! status and its reason, and where a state is called solved it is in equilibrium by an independent recomputation.

use crate::support::{
    balance::{assert_balanced, is_determinate},
    cases::cases,
    random_machine::{RandomMachine, random_arm, random_machine},
};
use kinetostat::{
    compensation::{self, Method, Session, Target, TaskPoint, compensate},
    inspect::machine_check,
    machine::{Chain, ChainError, Configuration, Machine, Motion, SpringLaw},
    process::MillingForce,
    questions::map::{self, WorkspaceMapStudy},
    simulation::LoadCase,
    spatial::{Grid, Pose, Twist, Wrench, rotation_log},
    statics::{
        Outcome, Scratch, Settings, Solution, State, Status, aggregate_errors, equilibrium, unloaded_stiffness,
        wrench_at_pose,
    },
    work::Work,
};
use nalgebra::{DVector, Vector3};
use proptest::{
    prelude::*,
    test_runner::{Config, TestRunner},
};

/// Residual of any solved state: what [`Settings`] task, or rounding.
const RESIDUAL: f64 = 1e-8;

/// A load up to some hundred newtons, chain errors up to a millimetre and a degree.
#[derive(Debug, Clone)]
struct Trial {
    /// The machine file.
    toml: String,
    load: [f64; 6],
    errors: [f64; 14],
    step: [f64; 3],
}

fn trial(machine: impl Strategy<Value = RandomMachine>) -> impl Strategy<Value = Trial> {
    let share = || -1.0..1.0;
    let parts = (machine, prop::array::uniform6(share()), prop::array::uniform14(share()));
    (parts, prop::array::uniform3(share())).prop_map(|((machine, load, errors), step)| Trial {
        toml: machine.toml(),
        load,
        errors,
        step,
    })
}

impl Trial {
    fn load(&self) -> Wrench {
        let [a, b, c, d, e, f] = self.load;
        Wrench::new([300.0 * a, 300.0 * b, 300.0 * c, 3e4 * d, 3e4 * e, 3e4 * f])
    }

    /// Another error for every chain.
    fn chain_errors(&self, machine: &Machine) -> Vec<ChainError> {
        let share = |chain: usize, i: usize| self.errors[(5 * chain + i) % 14];
        let vector = |chain: usize, i: usize| Vector3::new(share(chain, i), share(chain, i + 1), share(chain, i + 2));
        let error = |chain: usize| ChainError {
            base: Twist { linear: vector(chain, 0), angular: vector(chain, 3) * 0.017 },
            end: Twist { linear: vector(chain, 6) * 0.2, angular: vector(chain, 9) * 0.003 },
            drive_offsets: vec![share(chain, 12) * 0.1, share(chain, 13) * 0.05, share(chain, 11) * 0.05],
        };
        (0..machine.chains.len()).map(error).collect()
    }
}

fn finite<'a>(what: &str, numbers: impl IntoIterator<Item = &'a f64>) {
    for number in numbers {
        assert!(number.is_finite(), "{what}: {number}");
    }
}

fn finite_pose(what: &str, pose: &Pose) {
    finite(what, pose.translation.iter().chain(pose.rotation.iter()));
}

fn finite_state(what: &str, state: &State) {
    finite_pose(what, &state.pose);
    for chain in &state.chains {
        finite(what, chain.coordinates.iter().chain(&chain.wrench.to_array()));
        finite(what, chain.loops.iter().flat_map(|wrench| wrench.to_array()).collect::<Vec<_>>().iter());
    }
}

fn finite_outcome(what: &str, outcome: &Outcome) {
    finite(what, outcome.stiffness.iter().flat_map(|matrix| matrix.iter()));
    finite(what, outcome.compliance.iter().flat_map(|matrix| matrix.iter()));
    finite(what, outcome.drive_sensitivity.iter());
}

fn check_findings(machine: &Machine) {
    let findings = machine_check::check(machine).unwrap();
    finite("round trip", [&findings.round_trip.0, &findings.round_trip.1]);
    finite("home", &findings.home_drives);
    finite("stiffness at home", findings.stiffness.iter().flat_map(|matrix| matrix.iter()));
    finite("compliance shares", findings.compliance_shares.iter().map(|(_, share)| share));
    // Infinite where the tool is rigid in a direction.
    assert!(findings.tool_stiffness.iter().flatten().all(|k| !k.is_nan()), "{:?}", findings.tool_stiffness);
    let unreached = findings.reached.iter().filter_map(|(.., reached)| reached.as_ref().err());
    assert!(unreached.into_iter().all(|reason| !reason.is_empty()));
}

/// Equilibria at `at` under the trial's load and errors; whether all are solved, and the largest number of load steps.
fn check_equilibrium(machine: &Machine, trial: &Trial, at: &Configuration) -> (bool, usize) {
    let actual = machine.with_errors(&trial.chain_errors(machine));
    let mut scratch = Scratch::new(machine);
    let (mut solved, mut load_steps) = (true, 0);
    for (answering, load) in [(machine, trial.load()), (&actual, Wrench::zero()), (&actual, trial.load())] {
        let start = State::rigid(machine, at);
        let mut state = start.clone();
        let settings = Settings::default();
        let outcome = equilibrium(answering, &at.drives, &load, &mut state, &mut scratch, &settings);
        finite_state("equilibrium", &state);
        finite_outcome("equilibrium", &outcome);
        load_steps = load_steps.max(outcome.load_steps);
        match &outcome.status {
            Status::NotConverged { load_fraction } | Status::SnapThrough { load_fraction } => {
                assert!((0.0..1.0).contains(load_fraction) && outcome.stiffness.is_none());
                assert_eq!(state, start, "a failed solve leaves its start");
            }
            Status::SingularPlace => assert_eq!(state, start, "a failed solve leaves its start"),
            _ => {
                assert!(outcome.residual <= RESIDUAL, "{outcome:?}");
                assert_balanced(answering, &at.drives, &load, &state);
            }
        }
        let is_solved = outcome.status == Status::Solved;
        if std::env::var_os("RANDOM_MACHINES_TIMES").is_some() {
            eprintln!(
                "  {:?} n {} loops {} weight {} steps {}",
                outcome.status,
                unknown_count(machine),
                machine.chains.iter().map(|c| c.route.loop_count()).sum::<usize>(),
                machine.has_weight(),
                outcome.load_steps
            );
        }
        assert_eq!(outcome.status.reason(machine).is_empty(), is_solved, "{:?}", outcome.status);
        let solution = Solution::new(answering, &at.drives, &state, &outcome, &mut scratch);
        finite("drive forces", &solution.drive_forces());
        finite("stability", solution.stability.iter());
        finite(
            "internal wrench",
            solution
                .chains
                .iter()
                .flat_map(|c| c.internal_wrench.map(|w| w.to_array()))
                .flatten()
                .collect::<Vec<_>>()
                .iter(),
        );
        solved &= is_solved;
    }
    finite("unloaded stiffness", unloaded_stiffness(machine, at, &mut scratch).iter().flat_map(|k| k.iter()));
    if let Some(moved) = aggregate_errors(machine, &actual, at, &mut scratch) {
        finite("aggregated errors", moved.to_vector().iter());
    }
    let mut state = State::rigid(machine, at);
    let pose = Pose { translation: at.pose.translation.add_scalar(0.1), ..at.pose };
    if let Some(held) = wrench_at_pose(machine, &at.drives, &pose, &mut state, &mut scratch, &Settings::default()) {
        finite(
            "wrench at pose",
            held.wrench.to_array().iter().chain(held.stiffness.iter()).chain(held.drive_wrench.iter()),
        );
    }
    (solved, load_steps)
}

/// Load steps from which a machine is not compensated and mapped here: each takes a hundred equilibria.
const MANY_LOAD_STEPS: usize = 500;

/// Coordinates and wrenches of all chains and loops.
fn unknown_count(machine: &Machine) -> usize {
    let unknowns = |chain: &Chain| chain.coordinate_count() + 6 * (1 + chain.route.loop_count());
    machine.chains.iter().map(unknowns).sum()
}

/// Rigid links condensed against the same equations uncondensed. Whether these were compared. What rigid chains carry against
/// each other in an over-constrained machine, and with it the loaded compliance, is not determined. Compliance and drive
/// sensitivities are held against differences of equilibria: the pseudo-inverse of a machine drawn at random may have
/// singular values where it cuts them off.
fn check_condensation(machine: &Machine, trial: &Trial, at: &Configuration) -> bool {
    let has_link = |chain: &Chain| chain.springs.iter().any(|spring| matches!(spring.law, SpringLaw::Link(_)));
    let is_elastic = machine.chains.iter().all(|chain| has_link(chain) && chain.route.loops.is_empty());
    let mobility = machine.mobility(at);
    let start = State::rigid(machine, at);
    let is_degenerate = mobility.uncontrolled > 0 || !is_determinate(machine, &at.drives, &start);
    if is_elastic || unknown_count(machine) > 90 || is_degenerate {
        return false;
    }
    let settings = Settings { tolerance: 1e-13, max_iterations: 20 };
    let load = trial.load().scale(0.1);
    let [condensed, uncondensed] = [Scratch::new(machine), Scratch::uncondensed(machine)].map(|mut scratch| {
        let mut state = start.clone();
        let outcome = equilibrium(machine, &at.drives, &load, &mut state, &mut scratch, &settings);
        (state, outcome)
    });
    let ((state, got), (expected_state, expected)) = (condensed, uncondensed);
    assert_eq!(got.status, expected.status);
    if got.status != Status::Solved || got.load_steps > 1 {
        return false;
    }
    let lever = |i: usize| if i < 3 { 1.0 } else { machine.characteristic_length };
    let twist = |from: &Pose, to: &Pose| {
        let angular = rotation_log(&(to.rotation * from.rotation.transpose())) * machine.characteristic_length;
        let linear = to.translation - from.translation;
        DVector::from_iterator(6, linear.iter().chain(&angular).copied())
    };
    let (moved, expected_moved) = (twist(&at.pose, &state.pose), twist(&at.pose, &expected_state.pose));
    let difference = (&moved - &expected_moved).amax();
    assert!(difference <= 1e-7 * moved.amax() + 1e-9 * machine.characteristic_length, "{moved} {expected_moved}");
    let mut scratch = Scratch::new(machine);
    let mut difference = |load_step: Wrench, drive_step: (usize, f64)| {
        let ends = [1.0, -1.0].map(|sign| {
            let mut loaded = load.to_vector();
            loaded += load_step.to_vector() * sign;
            let mut drives = at.drives.clone();
            drives[drive_step.0] += drive_step.1 * sign;
            let mut end = state.clone();
            let outcome =
                equilibrium(machine, &drives, &Wrench::from_vector(&loaded), &mut end, &mut scratch, &settings);
            outcome.is_equilibrium().then_some(end.pose)
        });
        let [Some(after), Some(before)] = ends else { return None };
        Some(twist(&before, &after) * 0.5)
    };
    for j in 0..6 + machine.drive_count() {
        let step = 0.1;
        let (moved, column) = if j < 6 {
            let mut parts = [0.0; 6];
            parts[j] = step * lever(j);
            (difference(Wrench::new(parts), (0, 0.0)), got.compliance.unwrap().column(j) * step * lever(j))
        } else {
            let step = step / if machine.drives().nth(j - 6).unwrap().1.motion == Motion::Revolute { 1e4 } else { 1e3 };
            (difference(Wrench::zero(), (j - 6, step)), got.drive_sensitivity.column(j - 6) * step)
        };
        let Some(moved) = moved else { continue };
        let expected = DVector::from_fn(6, |i, _| column[i] * lever(i));
        // Differences of large motions are no derivatives.
        if expected.amax() > 1e-4 * machine.characteristic_length {
            continue;
        }
        let off = (&moved - &expected).amax();
        assert!(off <= 1e-3 * expected.amax() + 1e-9, "column {j}: moved by {moved}, expected {expected}");
    }
    true
}

fn check_compensation(machine: &Machine, trial: &Trial, at: &Configuration) {
    let actual = machine.with_errors(&trial.chain_errors(machine));
    // Where the nominal machine rests under its weight and springs.
    let mut rest = State::rigid(machine, at);
    let settings = Settings::default();
    let at_rest = equilibrium(machine, &at.drives, &Wrench::zero(), &mut rest, &mut Scratch::new(machine), &settings);
    let wanted = Some(if machine.own_load_text().is_some() { rest.pose } else { at.pose });
    for target in [Target::ToolTip, Target::FullPose] {
        let own = TaskPoint::new(at.pose, trial.load(), target);
        // Where a machine rests is known to the tolerance of equilibria, and the session finds another one than we: asked for ours, it is tracked
        // there; asked for its own, it is near.
        let is_at_rest = machine.own_load_text().is_some() && at_rest.status == Status::Solved;
        let ours = TaskPoint { wanted: wanted.filter(|_| is_at_rest), ..own };
        let tight = 1e-10 + 1e-12 * machine.characteristic_length;
        let asked = Method::ALL.map(|method| (ours, method, tight));
        for (task, method, most) in
            asked.into_iter().chain([(own, Method::Direct, tight.max(1e-8 * machine.characteristic_length))])
        {
            let settings = compensation::CompensationSettings {
                max_iterations: 30,
                ..compensation::CompensationSettings::default()
            };
            let mut session = Session::new(machine, &actual, settings);
            let done = compensate(&mut session, &task, method);
            finite(&method.label(), done.drives.iter().chain(&done.drive_forces));
            finite(&method.label(), done.position_error.iter().chain(done.residual_rotation.iter()));
            assert_eq!(done.status.reason(machine).is_empty(), done.status.is_success(), "{:?}", done.status);
            if done.status == compensation::CompensationStatus::Converged {
                // What carries nothing of its own rests where it is rigid, also where it is singular there.
                assert!(at_rest.status == Status::Solved || machine.own_load_text().is_none(), "{at_rest:?}");
                let left = TaskPoint { wanted, ..task }.task_error(machine, &session.state().pose).size();
                assert!(
                    left <= most && done.outcome.is_some(),
                    "{}: {left} mm left, {:?}",
                    method.label(),
                    done.history
                );
                assert_balanced(&actual, &done.drives, &task.load, session.state());
            }
        }
    }
}

fn check_map(machine: &Machine, trial: &Trial) {
    let (min, max) = (machine.workspace.min, machine.workspace.max);
    let load_case = LoadCase {
        force_of_turn: String::new(),
        machine: machine.clone(),
        errors: trial.chain_errors(machine),
        force: MillingForce::KLIMCHIK_GROOVE,
        tolerance_mm: None,
        phis: vec![0.0, 2.0],
        target: Target::ToolTip,
    };
    let study = WorkspaceMapStudy { load_case, grid: Grid::new(min, max, [2; 3]), uncertainty: None };
    for point in map::run(&study, &Work::default()).unwrap().points {
        for (_, effect) in point.effects.iter() {
            match effect {
                Ok(effect) => {
                    finite(
                        "map",
                        effect
                            .delta_rho
                            .iter()
                            .flatten()
                            .chain(&effect.drive_force)
                            .chain(&effect.deflection_vector_mm),
                    );
                    finite("map", effect.superposition_error_vector_mm.iter().flatten());
                    assert!(effect.principal_stiffness_n_per_mm.iter().all(|k| !k.is_nan()), "{effect:?}");
                }
                Err(failure) => assert!(!failure.reason.is_empty() && !failure.status.is_empty()),
            }
        }
    }
}

/// What became of a drawn machine.
#[derive(Debug, Default)]
struct Tally {
    drawn: usize,
    accepted: usize,
    reached: usize,
    solved: usize,
    /// Of those solved, how many were compared with the uncondensed equations.
    compared: usize,
}

fn run(trial: &Trial, tally: &mut Tally) {
    tally.drawn += 1;
    let machine = match Machine::from_toml(&trial.toml, "random.toml") {
        Ok(machine) => machine,
        Err(refusal) => {
            if std::env::var_os("RANDOM_MACHINES_TIMES").is_some() {
                eprintln!("  refused {refusal}");
            }
            return assert!(refusal.to_string().starts_with("random.toml:"), "{refusal}");
        }
    };
    tally.accepted += 1;
    // A survey of what is hardly reached takes half a minute.
    if tally.accepted % 10 == 1 {
        check_findings(&machine);
    }
    // What cannot be condensed and goes in 2000 load steps takes a minute to solve where there is more, and each method solves it.
    let mut is_small = unknown_count(&machine) <= 90;
    let home = machine.home.pose.translation;
    let near = home + Vector3::from(trial.step) * 20.0;
    for (index, position) in [home, near].into_iter().enumerate() {
        let at = match machine.inverse_kinematics(&machine.pose_at(position)) {
            Ok(at) => at,
            Err(unreachable) => {
                assert!(!unreachable.to_string().is_empty());
                continue;
            }
        };
        finite_pose("inverse kinematics", &at.pose);
        finite("inverse kinematics", at.drives.iter().chain(at.passive.iter().flatten()));
        tally.reached += 1;
        let (is_solved, load_steps) = check_equilibrium(&machine, trial, &at);
        tally.solved += usize::from(is_solved);
        is_small &= load_steps < MANY_LOAD_STEPS;
        tally.compared += usize::from(check_condensation(&machine, trial, &at));
        if index == 0 && is_small {
            check_compensation(&machine, trial, &at);
        }
    }
    if is_small {
        check_map(&machine, trial);
    }
}

/// Draws that have failed once: they come first, beside those asked for.
fn kept() -> usize {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/proptest-regressions/random_machines.txt");
    std::fs::read_to_string(file).unwrap_or_default().lines().filter(|line| line.starts_with("cc ")).count()
}

/// Draws `count` machines, and on, up to four times as many, until a third of `count` states are solved. Of the states that machines drawn at random
/// reach, a sixth to a third rest under a trial's load: a share of few would be held by the seed that was looked at, not by the search.
fn search(count: u32, machine: impl Strategy<Value = RandomMachine>) -> Tally {
    let mut runner = TestRunner::new(Config { max_shrink_time: 60_000, ..cases(4 * count) });
    let asked = cases(count).cases as usize;
    let (count, wanted) = (asked + kept(), asked / 3);
    let tally = std::cell::RefCell::new(Tally::default());
    let slow = std::env::var_os("RANDOM_MACHINES_TIMES").is_some();
    let outcome = runner.run(&trial(machine), |trial| {
        let is_enough = |tally: &Tally| tally.drawn >= count && tally.solved >= wanted;
        if is_enough(&tally.borrow()) {
            return Ok(());
        }
        let began = std::time::Instant::now();
        if let Some(f) = std::env::var_os("RANDOM_MACHINES_LAST") {
            std::fs::write(f, format!("{:?}\n{}", trial, trial.toml)).unwrap();
        }
        run(&trial, &mut tally.borrow_mut());
        if slow {
            eprintln!("{:.2?} {:?}", began.elapsed(), tally.borrow());
        }
        Ok(())
    });
    if let Err(failure) = outcome {
        panic!("{failure}");
    }
    let tally = tally.into_inner();
    // The search is worth nothing if nearly all machines are refused or singular.
    assert!(2 * tally.accepted > tally.drawn && tally.solved >= wanted, "{tally:?}");
    tally
}

#[test]
fn random_machines_are_solved_or_say_why_not() {
    let tally = search(20, random_machine());
    assert!(tally.compared > 0, "{tally:?}");
}

#[test]
fn random_arms_with_modules_are_solved_or_say_why_not() {
    search(12, random_arm());
}

/// Minutes; `PROPTEST_RNG_SEED` draws other machines, `INVARIANT_CASES` more of them.
#[test]
#[ignore = "takes minutes; .ci/full runs it"]
fn many_random_machines_are_solved_or_say_why_not() {
    let tally = search(300, random_machine());
    assert!(tally.compared > 0, "{tally:?}");
}
