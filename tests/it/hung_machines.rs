//! Machines with weight, springs between points, modules and shown coordinates: condensed as uncondensed, in load steps as
//! at once, with chain errors and without.

use crate::support::{
    balance::assert_balanced,
    engine::*,
    machines::{HUNG, machine_file, places, share, some_errors, some_load},
};
use kinetostat::{
    machine::{ChainError, Configuration, Machine},
    spatial::Wrench,
    statics::{
        Outcome, Scratch, Settings, State, Status, chain_stiffnesses, drive_force_sensitivity, equilibrium,
        unloaded_stiffness, wrench_at_pose,
    },
};
use nalgebra::DMatrix;

struct Solved {
    state: State,
    outcome: Outcome,
    force_sensitivity: DMatrix<f64>,
}

fn solve(machine: &Machine, at: &Configuration, load: &Wrench, mut scratch: Scratch) -> Solved {
    let mut state = State::rigid(machine, at);
    let outcome = equilibrium(machine, &at.drives, load, &mut state, &mut scratch, &EXACT);
    assert_eq!(outcome.status, Status::Solved, "{} at {:?}", machine.name, at.drives);
    let twists = &outcome.drive_sensitivity;
    let force_sensitivity = drive_force_sensitivity(machine, &at.drives, &state, twists, &mut scratch).unwrap();
    Solved { state, outcome, force_sensitivity }
}

/// Largest difference of two states: mm, and mm of rotations at the machine's characteristic length; and of wrenches, over the largest.
fn differences(machine: &Machine, a: &State, b: &State) -> (f64, f64) {
    let motion = motion_between(&a.pose, &b.pose);
    let mut place =
        motion.fixed_rows::<3>(0).amax().max(motion.fixed_rows::<3>(3).amax() * machine.characteristic_length);
    let (mut wrench, mut largest) = (0.0f64, 1.0f64);
    for (a, b) in a.chains.iter().zip(&b.chains) {
        for (x, y) in a.coordinates.iter().zip(&b.coordinates) {
            place = place.max((x - y).abs());
        }
        for (x, y) in a.loops.iter().chain([&a.wrench]).zip(b.loops.iter().chain([&b.wrench])) {
            let off = Wrench::from_vector(&(x.to_vector() - y.to_vector()));
            (wrench, largest) = (
                wrench.max(off.norm(machine.characteristic_length)),
                largest.max(x.norm(machine.characteristic_length)),
            );
        }
    }
    (place, wrench / largest)
}

/// To 1e-8: the uncondensed equations are solved by singular values, good to rounding of the largest unknown.
#[test]
fn condensed_machines_have_the_answers_of_the_equations_as_they_stand() {
    for name in HUNG {
        let nominal = machine_file(name);
        for (seed, at) in places(&nominal, 6).into_iter().enumerate() {
            let machine = nominal.with_errors(&some_errors(&nominal, seed));
            let load = some_load(&machine, 1500.0, seed);
            let got = solve(&machine, &at, &load, Scratch::new(&machine));
            let expected = solve(&machine, &at, &load, Scratch::uncondensed(&machine));
            let (place, wrench) = differences(&machine, &expected.state, &got.state);
            assert!(place < 1e-8 && wrench < 1e-8, "{name}, place {seed}: off by {place:e} mm, {wrench:e}");
            let off = stiffness_difference(&got.outcome.stiffness.unwrap(), &expected.outcome.stiffness.unwrap());
            assert!(off < 1e-8, "{name}, place {seed}: stiffness off by {off:e}");
            let twists = &expected.outcome.drive_sensitivity;
            let off = (&got.outcome.drive_sensitivity - twists).amax();
            assert!(off < 1e-8 * twists.amax(), "{name}, place {seed}: drive sensitivity off by {off:e}");
            let stiffest = machine.drives().map(|(_, drive)| drive.stiffness).fold(0.0, f64::max);
            let off = (&got.force_sensitivity - &expected.force_sensitivity).amax();
            assert!(off < 1e-8 * stiffest, "{name}, place {seed}: force sensitivity off by {off:e} of {stiffest:e}");
            assert_balanced(&machine, &at.drives, &load, &got.state);
        }
    }
}

/// The whole load at once, in a hundred parts, and from another place.
#[test]
fn load_steps_reach_the_state_that_small_parts_of_the_load_do() {
    let mut stepped = 0;
    for (name, newtons) in
        [("robot_6r", 3e5), ("hybrid_3ups", 1e6), ("fourbar_robot", 2e5), ("coupled_6r", 2e5), ("nested", 2e5)]
    {
        let machine = machine_file(name);
        for (seed, at) in places(&machine, 4).iter().enumerate() {
            for load_share in [0.3, 1.0] {
                let load = some_load(&machine, newtons * load_share, seed);
                let mut expected = State::rigid(&machine, at);
                let parts = 200;
                let reached = (0..=parts).all(|part| {
                    let share = load.scale(f64::from(part) / f64::from(parts));
                    resettle(&machine, &at.drives, &share, &mut expected).status == Status::Solved
                });
                let (state, outcome) = settle(&machine, at, &load);
                if !reached {
                    assert_ne!(outcome.status, Status::Solved, "{name}, place {seed}: a limit point is jumped over");
                    continue;
                }
                assert_eq!(outcome.status, Status::Solved, "{name}, place {seed} under {load:?}");
                let (place, wrench) = differences(&machine, &expected, &state);
                assert!(place < 1e-7 && wrench < 1e-8, "{name}, place {seed}: off by {place:e} mm, {wrench:e}");
                stepped += usize::from(outcome.load_steps > 1);
            }
        }
        // Drives far from where the state stands: closures and forces are far off at the start.
        let far = &places(&machine, 3)[2];
        let load = some_load(&machine, 500.0, 1);
        let (expected, _) = settle(&machine, far, &load);
        let (start, _) = settle(&machine, &machine.home, &load);
        for max_iterations in [20, 2] {
            let (mut state, mut scratch) = (start.clone(), Scratch::new(&machine));
            let settings = Settings { max_iterations, ..EXACT };
            let outcome = equilibrium(&machine, &far.drives, &load, &mut state, &mut scratch, &settings);
            assert_eq!(outcome.status, Status::Solved, "{name} from home");
            assert!(max_iterations > 2 || outcome.load_steps > 1, "{name}: {outcome:?}");
            let (place, wrench) = differences(&machine, &expected, &state);
            assert!(place < 1e-7 && wrench < 1e-7, "{name} from home: off by {place:e} mm, {wrench:e}");
        }
    }
    assert!(stepped >= 5, "{stepped} loads needed steps");
}

/// Ten times the chain errors there may be: they are brought on with the weight.
#[test]
fn load_steps_bring_on_errors_in_modules() {
    for name in HUNG {
        let nominal = machine_file(name);
        let at = &places(&nominal, 2)[1];
        let errors = some_errors(&nominal, 9);
        let mut expected = State::rigid(&nominal, at);
        for part in 0..=60 {
            let scaled: Vec<ChainError> = errors.iter().map(|error| error.scale(f64::from(part) / 3.0)).collect();
            let outcome = resettle(&nominal.with_errors(&scaled), &at.drives, &Wrench::zero(), &mut expected);
            assert_eq!(outcome.status, Status::Solved, "{name}, part {part}");
        }
        let scaled: Vec<ChainError> = errors.iter().map(|error| error.scale(20.0)).collect();
        let actual = nominal.with_errors(&scaled);
        let (state, outcome) = settle(&actual, at, &Wrench::zero());
        assert_eq!(outcome.status, Status::Solved, "{name}");
        let (place, wrench) = differences(&nominal, &expected, &state);
        assert!(place < 1e-7 && wrench < 1e-7, "{name}: off by {place:e} mm, {wrench:e}");
        assert_balanced(&actual, &at.drives, &Wrench::zero(), &state);
    }
}

/// The wrench that holds P where it stands is the load, from wherever it is sought.
#[test]
fn the_weight_alone_is_held_by_no_wrench() {
    for name in HUNG {
        let machine = machine_file(name);
        for at in places(&machine, 3) {
            let (rest, _) = settle(&machine, &at, &Wrench::zero());
            let mut state = State::rigid(&machine, &at);
            let settings = Settings::default();
            let mut scratch = Scratch::new(&machine);
            let held = wrench_at_pose(&machine, &at.drives, &rest.pose, &mut state, &mut scratch, &settings).unwrap();
            let largest =
                rest.chains.iter().map(|chain| chain.wrench.norm(machine.characteristic_length)).fold(1.0, f64::max);
            assert!(held.wrench.norm(machine.characteristic_length) < 1e-7 * largest, "{name}: {:?}", held.wrench);
            let (place, wrench) = differences(&machine, &rest, &state);
            assert!(place < 1e-8 && wrench < 1e-7, "{name}: off by {place:e} mm, {wrench:e}");
        }
    }
}

/// A drive's zero-point error is what it would be commanded: nominal drives moved, or the joints offset.
#[test]
fn an_offset_drive_is_one_commanded_elsewhere() {
    for name in HUNG {
        let machine = machine_file(name);
        let chain = &machine.chains[0];
        let count = machine.drive_count();
        let commanded: Vec<f64> = (0..count).map(|i| 2e-3 * share(2, i)).collect();
        let offset =
            |joint: usize| (0..count).map(|drive| chain.joint_per_drive(joint, drive) * commanded[drive]).sum();
        let error = ChainError { drive_offsets: (0..count).map(offset).collect(), ..ChainError::default() };
        let actual = machine.with_errors(&[error]);
        for (seed, at) in places(&machine, 3).iter().enumerate() {
            let load = some_load(&machine, 1000.0, seed);
            let moved: Vec<f64> = at.drives.iter().zip(&commanded).map(|(rho, step)| rho + step).collect();
            let (mut expected, mut got) = (State::rigid(&machine, at), State::rigid(&machine, at));
            let by_command = resettle(&machine, &moved, &load, &mut expected);
            let by_error = resettle(&actual, &at.drives, &load, &mut got);
            assert_eq!((&by_command.status, &by_error.status), (&Status::Solved, &Status::Solved), "{name}");
            let (place, wrench) = differences(&machine, &expected, &got);
            assert!(place < 1e-8 && wrench < 1e-8, "{name}: off by {place:e} mm, {wrench:e}");
        }
    }
}

#[test]
fn unloaded_stiffness_is_that_of_the_machine_without_weight() {
    for name in ["hybrid_3ups", "fourbar_robot", "coupled_6r"] {
        let machine = machine_file(name);
        let weightless = machine.weightless();
        for at in places(&machine, 3) {
            let stiffness = unloaded_stiffness(&machine, &at, &mut Scratch::new(&machine)).unwrap();
            let (_, outcome) = settle(&weightless, &at, &Wrench::zero());
            let off = stiffness_difference(&stiffness, &outcome.stiffness.unwrap());
            assert!(off < 1e-8, "{name}: off by {off:e}");
            let off = stiffness_difference(&stiffness.transpose(), &stiffness);
            assert!(off < 1e-10, "{name}: asymmetry {off:e}");
        }
        // The chains' stiffnesses and the platform's weight are all there is.
        let (state, outcome) = settle(&machine, &machine.home, &Wrench::zero());
        let own = chain_stiffnesses(&machine, &machine.home.drives, &state, &mut Scratch::new(&machine));
        assert!(own[0].is_some() && outcome.stiffness.is_some());
    }
}
