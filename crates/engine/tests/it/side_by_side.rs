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
