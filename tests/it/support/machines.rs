//! Machines with weight, springs between points, parallel modules and shown coordinates, from `tests/machines`.

use kinetostat::{
    machine::{ChainError, Configuration, Machine, Motion},
    spatial::{Twist, Wrench},
};
use nalgebra::Vector3;

/// Names of their files.
pub const HUNG: [&str; 5] = ["robot_6r", "hybrid_3ups", "fourbar_robot", "coupled_6r", "nested"];

/// The path of a machine file in `tests/machines`.
pub fn machine_path(name: &str) -> String {
    format!("{}/tests/machines/{name}.toml", env!("CARGO_MANIFEST_DIR"))
}

pub fn machine_file(name: &str) -> Machine {
    Machine::from_file(machine_path(name).as_ref()).unwrap_or_else(|e| panic!("{e}"))
}

/// Numbers in −1..1, the same for the same `seed` and place.
pub fn share(seed: usize, place: usize) -> f64 {
    let number = 0.5 + (seed as f64 + 1.0) * 0.754_877_666 + (place as f64 + 1.0) * 0.569_840_290;
    2.0 * number.fract() - 1.0
}

/// Places with the drives up to 0.2 rad or 60 mm beside home, the first of them home. The last drive is turned by 0.3 rad more:
/// at home the wrist of the hybrid machine is stretched.
pub fn places(machine: &Machine, count: usize) -> Vec<Configuration> {
    let last = machine.drive_count() - 1;
    let place = |seed: usize| {
        let beside = |(i, (_, drive)): (usize, (usize, &kinetostat::machine::Drive))| match drive.motion {
            Motion::Prismatic => 60.0 * share(seed, i),
            Motion::Revolute if i == last => 0.3 + 0.2 * share(seed, i),
            Motion::Revolute => 0.2 * share(seed, i),
        };
        let steps: Vec<f64> = machine.drives().enumerate().map(beside).collect();
        let drives: Vec<f64> = machine.home.drives.iter().zip(steps).map(|(home, step)| home + step).collect();
        machine.forward_kinematics(&drives).unwrap_or_else(|e| panic!("{} at {drives:?}: {e}", machine.name))
    };
    std::iter::once(machine.home.clone()).chain((1..count).map(place)).collect()
}

/// A wrench of up to `newtons` in each direction at half the machine's characteristic length.
pub fn some_load(machine: &Machine, newtons: f64, seed: usize) -> Wrench {
    let lever = |i: usize| if i < 3 { 1.0 } else { 0.5 * machine.characteristic_length };
    Wrench::new(std::array::from_fn(|i| newtons * lever(i) * share(seed, 10 + i)))
}

/// Errors of all chains: up to a millimetre and a degree, and an offset of every drive.
pub fn some_errors(machine: &Machine, seed: usize) -> Vec<ChainError> {
    let vector = |first: usize| Vector3::from_fn(|i, _| share(seed, first + i));
    let error = |chain: &kinetostat::machine::Chain| {
        let offset = |(i, drive): (usize, &kinetostat::machine::Drive)| match drive.motion {
            Motion::Prismatic => 0.5 * share(seed, 40 + i),
            Motion::Revolute => 2e-3 * share(seed, 40 + i),
        };
        ChainError {
            base: Twist { linear: vector(20), angular: vector(23) * 0.017 },
            end: Twist { linear: vector(26), angular: vector(29) * 0.01 },
            drive_offsets: chain.drives.iter().enumerate().map(offset).collect(),
        }
    };
    machine.chains.iter().map(error).collect()
}
