//! Cases solved several at a time have the outcomes they have alone, at every level of the processor.

use crate::support::{
    cases::cases,
    engine::{CATALOGUE, at_position, catalogue_machine, position_in_box, with_assembly_errors, wrench_from},
    machines::{HUNG, machine_file, places, some_errors, some_load},
    planar::{Leg, machine},
};
use kinetostat::{
    compensation::{self, Method, Session, Target, TaskPoint, compensate, compensate_batch},
    machine::{Configuration, Machine},
    process::MillingForce,
    spatial::Wrench,
    statics::{
        Batch, Case, LaneSolver, Level, Outcome, Scratch, Settings, State, Status, TaskError, equilibrium,
        equilibrium_at_task,
    },
};
use nalgebra::Vector3;
use proptest::prelude::*;

/// One equilibrium to be found.
#[derive(Debug, Clone)]
struct Problem {
    drives: Vec<f64>,
    load: Wrench,
    state: State,
}

impl Problem {
    fn new(machine: &Machine, at: &Configuration, load: Wrench) -> Self {
        Self { drives: at.drives.clone(), load, state: State::rigid(machine, at) }
    }
}

fn alone(machine: &Machine, problems: &mut [Problem], settings: &Settings) -> Vec<Outcome> {
    let mut scratch = Scratch::new(machine);
    let solve = |p: &mut Problem| equilibrium(machine, &p.drives, &p.load, &mut p.state, &mut scratch, settings);
    problems.iter_mut().map(solve).collect()
}

fn together(problems: &mut [Problem], batch: &mut Batch, settings: &Settings) -> Vec<Outcome> {
    let mut cases: Vec<Case<'_>> = problems
        .iter_mut()
        .map(|p| Case { drives: &mut p.drives, load: p.load, state: &mut p.state, task: None })
        .collect();
    batch.equilibria(&mut cases, settings)
}

/// Solves `problems` at every level, twice over with another load the second time, and compares with each solved alone.
fn assert_same(machine: &Machine, problems: &[Problem], settings: &Settings) -> Vec<Outcome> {
    let mut expected = problems.to_vec();
    let first = alone(machine, &mut expected, settings);
    let after_first = expected.clone();
    for problem in &mut expected {
        problem.load = problem.load.scale(0.5);
    }
    let second = alone(machine, &mut expected, settings);
    for level in Level::available() {
        let mut batch = Batch::at_level(machine, level);
        let mut got = problems.to_vec();
        let outcomes = together(&mut got, &mut batch, settings);
        for i in 0..problems.len() {
            assert_eq!(outcomes[i], first[i], "{level:?}, case {i}");
            assert_eq!(got[i].state, after_first[i].state, "{level:?}, case {i}");
        }
        for problem in &mut got {
            problem.load = problem.load.scale(0.5);
        }
        let outcomes = together(&mut got, &mut batch, settings);
        for i in 0..problems.len() {
            assert_eq!(outcomes[i], second[i], "{level:?}, case {i} from where it stood");
            assert_eq!(got[i].state, expected[i].state, "{level:?}, case {i} from where it stood");
        }
    }
    first
}

prop_compose! {
    fn six()(parts in prop::array::uniform6(-1.0..1.0f64)) -> [f64; 6] { parts }
}

proptest! {
    #![proptest_config(cases(12))]

    #[test]
    fn anywhere_in_the_workspace_lanes_have_the_bits_of_the_scalar_path(
        places in prop::collection::vec(prop::array::uniform3(0.0..1.0f64), 11),
        loads in prop::collection::vec(six(), 11),
        degrees in prop::array::uniform3(-1.0..1.0f64),
    ) {
        for (name, low, high) in CATALOGUE {
            let nominal = catalogue_machine(name);
            let actual = with_assembly_errors(&nominal, degrees);
            let problems: Vec<Problem> = places.iter().zip(&loads).map(|(&share, &parts)| {
                let at = at_position(&nominal, position_in_box(&nominal, low, high, share));
                Problem::new(&nominal, &at, wrench_from(300.0, 2e4, parts))
            }).collect();
            let outcomes = assert_same(&actual, &problems, &Settings::default());
            prop_assert!(outcomes.iter().all(|outcome| outcome.status == Status::Solved && outcome.load_steps == 1));
        }
    }
}

#[test]
fn what_lanes_cannot_solve_has_the_outcome_of_the_scalar_path() {
    let nominal = catalogue_machine("orthoglide");
    let actual = with_assembly_errors(&nominal, [1.0, -1.0, 1.0]);
    let at = at_position(&nominal, Vector3::new(126.35, 126.35, -73.65));
    // Plain cases with cases between them that need load steps, cannot be solved, or are not numbers.
    let sizes = [1.0, 1e3, 0.5, 75.0, 2.0, 24.0, f64::NAN, 0.0, 40.0];
    let problem =
        |size: f64| Problem::new(&nominal, &at, Wrench::new([-215.0, 80.0, -25.0, 3e3, -1e3, 0.0]).scale(size));
    let outcomes = outcomes_like_alone(&actual, &sizes.map(problem));
    let reached: Vec<_> = outcomes.iter().map(|outcome| (&outcome.status, outcome.load_steps)).collect();
    let count = |what: fn(&Outcome) -> bool| outcomes.iter().filter(|outcome| what(outcome)).count();
    assert!(count(|o| o.status == Status::Solved && o.load_steps == 1) >= 4, "{reached:?}");
    assert!(count(|o| o.is_equilibrium() && o.load_steps > 1) >= 1, "{reached:?}");
    assert!(count(|o| !o.is_equilibrium()) >= 2, "{reached:?}");
}

/// As [`assert_same`], for outcomes that may hold NaN, which equals nothing: compared as text.
fn outcomes_like_alone(machine: &Machine, problems: &[Problem]) -> Vec<Outcome> {
    let settings = Settings::default();
    let mut expected = problems.to_vec();
    let outcomes = alone(machine, &mut expected, &settings);
    for level in Level::available() {
        let mut got = problems.to_vec();
        let mut batch = Batch::at_level(machine, level);
        assert_eq!(format!("{:?}", together(&mut got, &mut batch, &settings)), format!("{outcomes:?}"), "{level:?}");
        for (got, expected) in got.iter().zip(&expected) {
            assert_eq!(got.state, expected.state, "{level:?}");
        }
    }
    outcomes
}

#[test]
fn lanes_without_iterations_leave_all_to_the_scalar_path() {
    let machine = catalogue_machine("tripteron");
    let at = machine.home.clone();
    let problems: Vec<Problem> = (0..5)
        .map(|i| Problem::new(&machine, &at, Wrench::new([50.0 * f64::from(i), 30.0, -20.0, 0.0, 1e3, 0.0])))
        .collect();
    for max_iterations in [0, 1] {
        let outcomes = assert_same(&machine, &problems, &Settings { max_iterations, ..Settings::default() });
        assert!(outcomes.iter().all(|outcome| outcome.load_steps != 1), "{outcomes:?}");
    }
}

#[test]
fn a_chain_that_cannot_be_condensed_is_left_to_the_scalar_path() {
    let drive = |axis: &str| {
        format!(
            r#"{{ prismatic_drive = {{ name = "{axis}", axis = "{axis}", stiffness_N_per_mm = 1e3, home_mm = 0.0 }} }}"#
        )
    };
    let elements = ["x", "y", "z"].map(drive);
    let elements: Vec<&str> = elements.iter().map(String::as_str).collect();
    let stage = machine("stage", [0.0; 3], r#""x", "y", "z""#, &[Leg::new("stage", &elements, "")]);
    let problems: Vec<Problem> = (0..3)
        .map(|i| Problem::new(&stage, &stage.home, Wrench::new([10.0, 20.0, 30.0 * f64::from(i), 0.0, 0.0, 0.0])))
        .collect();
    let outcomes = assert_same(&stage, &problems, &Settings::default());
    assert!(outcomes.iter().all(|outcome| outcome.status == Status::Solved && outcome.stiffness.is_none()));
}

#[test]
fn a_level_the_processor_does_not_have_is_replaced() {
    let machine = catalogue_machine("tripteron");
    assert_eq!(Level::available()[0], Level::One);
    for level in [Level::One, Level::Four, Level::Eight] {
        let mut problems = [Problem::new(&machine, &machine.home, Wrench::new([100.0, 0.0, 0.0, 0.0, 0.0, 0.0]))];
        let outcomes = together(&mut problems, &mut Batch::at_level(&machine, level), &Settings::default());
        assert_eq!(outcomes[0].status, Status::Solved);
    }
}

#[test]
fn sessions_compensated_together_end_as_each_alone() {
    for (name, low, high) in CATALOGUE {
        let nominal = catalogue_machine(name);
        let actual = with_assembly_errors(&nominal, [1.0, -1.0, 1.0]);
        let positions: Vec<Vector3<f64>> = (0..10)
            .map(|i| position_in_box(&nominal, low, high, [0.1 * f64::from(i), 0.5, 1.0 - 0.09 * f64::from(i)]))
            .collect();
        for method in [Method::None, Method::Direct, Method::Newton] {
            for level in Level::available() {
                let session = Session::new(&nominal, &actual, compensation::CompensationSettings::default());
                let (mut alone, mut grouped) = (vec![session.clone(); 10], vec![session; 10]);
                let mut batch = Batch::at_level(&actual, level);
                // The second round starts near, the third asks some sessions for places that are far or out of reach.
                for (round, away) in [(0, 0.0), (1, 1.0), (2, 2e4)] {
                    let task = |(i, position): (usize, &Vector3<f64>)| {
                        let shift = if i % 3 == 0 { away } else { f64::from(round) };
                        let load = MillingForce::KLIMCHIK_GROOVE.wrench(f64::from(round), &nominal.tool());
                        TaskPoint::new(nominal.pose_at(position.add_scalar(shift)), load, Target::ToolTip)
                    };
                    let tasks: Vec<TaskPoint> = positions.iter().enumerate().map(task).collect();
                    let pairs = alone.iter_mut().zip(&tasks);
                    let expected: Vec<_> = pairs.map(|(session, task)| compensate(session, task, method)).collect();
                    let mut sessions: Vec<&mut Session> = grouped.iter_mut().collect();
                    let got = compensate_batch(&mut sessions, &tasks, method, &mut batch);
                    assert_eq!(got, expected, "{name}, {method:?}, {level:?}, round {round}");
                    assert_eq!(got.iter().filter(|c| !c.status.is_success()).count(), if round == 2 { 4 } else { 0 });
                }
                for (grouped, alone) in grouped.iter().zip(&alone) {
                    assert_eq!(grouped.state(), alone.state(), "{name}, {method:?}, {level:?}");
                }
            }
        }
    }
}

#[test]
fn weight_springs_and_modules_have_the_bits_of_the_scalar_path() {
    for name in HUNG {
        let nominal = machine_file(name);
        let actual = nominal.with_errors(&some_errors(&nominal, 3));
        let problem =
            |(seed, at): (usize, &Configuration)| Problem::new(&nominal, at, some_load(&nominal, 1500.0, seed));
        let problems: Vec<Problem> = places(&nominal, 11).iter().enumerate().map(problem).collect();
        let outcomes = assert_same(&actual, &problems, &Settings::default());
        assert!(outcomes.iter().all(|outcome| outcome.status == Status::Solved), "{name}: {outcomes:?}");
    }
}

/// Drives and state are found in one iteration, and [`Batch::equilibria_at_task`] says what is left to the scalar path.
#[test]
fn weight_springs_and_modules_are_compensated_in_lanes() {
    for name in HUNG {
        let nominal = machine_file(name);
        let actual = nominal.with_errors(&some_errors(&nominal, 5));
        let places = &places(&nominal, 10)[1..];
        for level in Level::available() {
            let mut batch = Batch::at_level(&actual, level);
            let task = |(seed, at): (usize, &Configuration)| {
                let load = some_load(&nominal, 800.0, seed);
                TaskPoint::new(at.pose, load, Target::FullPose)
            };
            let tasks: Vec<TaskPoint> = places.iter().enumerate().map(task).collect();
            let task_errors: Vec<_> =
                tasks.iter().map(|task| |pose: &kinetostat::spatial::Pose| task.task_error(&nominal, pose)).collect();
            let mut problems: Vec<Problem> =
                places.iter().zip(&tasks).map(|(at, task)| Problem::new(&nominal, at, task.load)).collect();
            let mut cases: Vec<Case<'_>> = problems
                .iter_mut()
                .zip(&task_errors)
                .map(|(p, task_error)| Case {
                    drives: &mut p.drives,
                    load: p.load,
                    state: &mut p.state,
                    task: Some(task_error),
                })
                .collect();
            let got = batch.equilibria_at_task(&mut cases, &Settings::default());
            let mut scratch = Scratch::new(&actual);
            for (i, (at, task_error)) in places.iter().zip(&task_errors).enumerate() {
                let (mut drives, mut state) = (at.drives.clone(), State::rigid(&nominal, at));
                let settings = Settings::default();
                let load = &tasks[i].load;
                let expected =
                    equilibrium_at_task(&actual, task_error, &mut drives, load, &mut state, &mut scratch, &settings);
                assert!(expected.is_some(), "{name}, case {i}");
                assert_eq!(got[i], expected, "{name}, {level:?}, case {i}");
                assert_eq!(problems[i].state, state, "{name}, {level:?}, case {i}");
                assert_eq!(problems[i].drives, drives, "{name}, {level:?}, case {i}");
            }
        }
    }
}

/// What was solved before, drives found by a task, does not move the drives of what is solved next, nor keep lanes from solving it.
#[test]
fn drives_that_a_task_has_moved_stay_without_one() {
    let machine = catalogue_machine("orthoglide");
    let at = &places(&machine, 9)[5];
    let task = TaskPoint::new(at.pose, some_load(&machine, 800.0, 3), Target::ToolTip);
    let problem = Problem::new(&machine, at, task.load);
    let task_error = |pose: &kinetostat::spatial::Pose| task.task_error(&machine, pose);
    let mut solver: LaneSolver<f64> = LaneSolver::new(&machine);
    let mut solve = |problem: &mut Problem, task: Option<&dyn Fn(&kinetostat::spatial::Pose) -> TaskError>| {
        let case = Case { drives: &mut problem.drives, load: problem.load, state: &mut problem.state, task };
        let mut outcomes = Vec::new();
        solver.solve(&machine, &mut [case], &Settings::default(), &mut outcomes);
        outcomes.remove(0)
    };
    let mut moved = problem.clone();
    assert!(solve(&mut moved, Some(&task_error)).is_some());
    assert_ne!(moved.drives, problem.drives);
    let (mut expected, mut got) = (problem.clone(), problem.clone());
    let alone = alone(&machine, std::slice::from_mut(&mut expected), &Settings::default()).remove(0);
    assert_eq!(solve(&mut got, None), Some(alone));
    assert_eq!((got.drives, got.state), (problem.drives, expected.state));
}
