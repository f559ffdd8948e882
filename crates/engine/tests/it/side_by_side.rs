//! Kinematics of several points at a time, with the answers that each has alone.

use kinetostat_engine::{
    Machine, Pose,
    machine::{BatchKinematics, Configuration, catalogue},
    nalgebra::Vector3,
    statics::Level,
};

/// Poses about home: near ones that lanes find, and one far beyond reach.
fn targets(machine: &Machine) -> Vec<Pose> {
    let home = machine.home.pose;
    let way = |k: usize| {
        let k = k as f64;
        Vector3::new((1.3 * k).sin(), (0.7 * k).cos() - 1.0, (2.1 * k).sin()) * (0.02 * machine.characteristic_length)
    };
    let near = (0..19).map(|k| machine.pose_at(machine.controllable_position(home.translation + way(k))));
    near.chain([machine.pose_at(home.translation + Vector3::repeat(10.0 * machine.characteristic_length))]).collect()
}

fn assert_found(machine: &Machine, found: &[Option<Configuration>], alone: impl Fn(usize) -> Option<Configuration>) {
    for (k, at) in found.iter().enumerate() {
        if at.is_some() {
            assert_eq!(*at, alone(k), "{}, {k}", machine.name);
        }
    }
    assert!(found.iter().flatten().count() >= 16, "{}: {found:?}", machine.name);
}

#[test]
fn lanes_find_what_is_found_alone() {
    for name in catalogue::names() {
        let machine = Machine::named(name).unwrap();
        let targets = targets(&machine);
        for level in Level::available().into_iter().filter(|level| *level != Level::One) {
            let mut lanes = BatchKinematics::at_level(&machine, level);
            let asked: Vec<_> = targets.iter().map(|target| (&machine.home, *target)).collect();
            let found = lanes.inverse_kinematics(&asked);
            if machine.redundancy > 0 {
                assert!(found.iter().all(Option::is_none));
                continue;
            }
            assert_found(&machine, &found, |k| machine.inverse_kinematics_from(&machine.home, &targets[k]).ok());
            let drives: Vec<Vec<f64>> = found.iter().flatten().map(|at| at.drives.clone()).collect();
            let asked: Vec<_> = drives.iter().map(|drives| (&machine.home, drives.as_slice())).collect();
            let back = lanes.forward_kinematics(&asked);
            assert_found(&machine, &back, |k| machine.forward_kinematics_from(&machine.home, &drives[k]).ok());
        }
    }
}

#[test]
fn lanes_follow_ways_all_over_the_workspace_in_steps() {
    const PLACES: usize = 48;
    for name in catalogue::names() {
        let machine = Machine::named(name).unwrap();
        if machine.redundancy > 0 {
            continue;
        }
        let (low, high) = (machine.workspace.min, machine.workspace.max);
        // A little beyond the box too, where some places are out of reach.
        let share = |i: usize, step: f64| 1.2 * (0.5 + i as f64 * step).fract() - 0.1;
        let place = |i: usize| Vector3::new(share(i, 0.819_172_5), share(i, 0.671_043_6), share(i, 0.549_700_5));
        let place = |i: usize| machine.controllable_position(low + (high - low).component_mul(&place(i)));
        let targets: Vec<Pose> = (0..PLACES).map(|i| machine.pose_at(place(i))).collect();
        let alone: Vec<_> =
            targets.iter().map(|pose| machine.inverse_kinematics_from(&machine.home, pose).ok()).collect();
        let reached = alone.iter().flatten().count();
        assert!(reached >= PLACES / 2, "{name}: {reached}");
        let asked: Vec<_> = targets.iter().map(|target| (&machine.home, *target)).collect();
        for level in Level::available().into_iter().filter(|level| *level != Level::One) {
            let found = BatchKinematics::at_level(&machine, level).inverse_kinematics(&asked);
            let same = found.iter().zip(&alone).filter(|(found, alone)| found.is_some() && found == alone).count();
            assert_eq!(same, found.iter().flatten().count(), "{name}: another configuration than alone");
            // Those beside a singularity are left to the search alone.
            assert!(20 * (reached - same) <= reached, "{name}, {level:?}: {same} of {reached} in lanes");
        }
    }
}
