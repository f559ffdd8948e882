//! Short ways to the engine, and finite motions, for tests of its invariants.

use kinetostat::{
    machine::{ChainError, Configuration, Machine},
    spatial::{Pose, Twist, Wrench, rotation_exp, rotation_log},
    statics::{Outcome, Scratch, Settings, State, equilibrium},
};
use nalgebra::{Matrix6, Vector3, Vector6};

/// Converged to rounding.
pub const EXACT: Settings = Settings { tolerance: 1e-13, max_iterations: 20 };

/// Machines of the catalogue with three chains, each with the share of its workspace box in which it is far from singular.
pub const CATALOGUE: [(&str, f64, f64); 3] =
    [("orthoglide", 0.0, 1.0), ("tripteron", 0.15, 0.9), ("delta_3prpar", 0.0, 1.0)];

pub fn catalogue_machine(name: &str) -> Machine {
    Machine::named_or_file(name).unwrap()
}

pub fn machine_from(toml: &str) -> Machine {
    Machine::from_toml(toml, "test machine").unwrap_or_else(|e| panic!("{e}"))
}

/// Position at the fractions `share` of the part `low..high` of the workspace box.
pub fn position_in_box(machine: &Machine, low: f64, high: f64, share: [f64; 3]) -> Vector3<f64> {
    let size = machine.workspace.max - machine.workspace.min;
    machine.workspace.min + size.component_mul(&Vector3::from(share).map(|s| low + (high - low) * s))
}

pub fn at_position(machine: &Machine, position: Vector3<f64>) -> Configuration {
    machine
        .inverse_kinematics(&machine.pose_at(position))
        .unwrap_or_else(|e| panic!("{} at {position:?}: {e}", machine.name))
}

/// Assembly errors in degrees about the first base axis of each chain, all frames also displaced a little.
pub fn with_assembly_errors(machine: &Machine, degrees: [f64; 3]) -> Machine {
    machine.with_errors(&degrees.map(assembly_error))
}

/// The chain turned about the first axis of its base frame.
pub fn turned_chain(degrees: f64) -> ChainError {
    let angular = Vector3::x() * degrees.to_radians();
    ChainError { base: Twist { linear: Vector3::zeros(), angular }, ..ChainError::default() }
}

pub fn assembly_error(degrees: f64) -> ChainError {
    let mut error = turned_chain(degrees);
    error.base.linear = Vector3::new(0.2, -0.1, 0.3) * degrees;
    error.end.angular = Vector3::new(1e-3, 2e-3, -1e-3) * degrees;
    error.drive_offsets = vec![0.05 * degrees];
    error
}

/// Equilibrium from the rigid configuration, converged to rounding.
pub fn settle(machine: &Machine, at: &Configuration, load: &Wrench) -> (State, Outcome) {
    let mut state = State::rigid(machine, at);
    let outcome = resettle(machine, &at.drives, load, &mut state);
    (state, outcome)
}

/// Equilibrium from a neighbouring state.
pub fn resettle(machine: &Machine, drives: &[f64], load: &Wrench, state: &mut State) -> Outcome {
    equilibrium(machine, drives, load, state, &mut Scratch::new(machine), &EXACT)
}

/// Displacement and rotation vector that lead from one pose to another, in the axes of O.
pub fn motion_between(from: &Pose, to: &Pose) -> Vector6<f64> {
    let angular = rotation_log(&(to.rotation * from.rotation.transpose()));
    Twist { linear: to.translation - from.translation, angular }.to_vector()
}

/// The pose moved by displacement and rotation vector, in the axes of O.
pub fn moved(pose: &Pose, motion: &Vector6<f64>) -> Pose {
    let Twist { linear, angular } = Twist::from_vector(motion);
    Pose { rotation: rotation_exp(angular) * pose.rotation, translation: pose.translation + linear }
}

/// Unit motion along (0–2) or about (3–5) an axis of O.
pub fn unit_motion(index: usize) -> Vector6<f64> {
    Vector6::from_fn(|i, _| if i == index { 1.0 } else { 0.0 })
}

/// Largest difference of two stiffness matrices, each entry over the geometric mean of the diagonal entries of its row
/// and column in `expected`.
pub fn stiffness_difference(got: &Matrix6<f64>, expected: &Matrix6<f64>) -> f64 {
    let scale = |i: usize, j: usize| (expected[(i, i)] * expected[(j, j)]).abs().sqrt();
    Matrix6::from_fn(|i, j| (got[(i, j)] - expected[(i, j)]).abs() / scale(i, j)).max()
}

/// A milling-like wrench from three numbers in −1..1 per part.
pub fn wrench_from(force_n: f64, moment_nmm: f64, parts: [f64; 6]) -> Wrench {
    let [a, b, c, d, e, f] = parts;
    Wrench::new([force_n * a, force_n * b, force_n * c, moment_nmm * d, moment_nmm * e, moment_nmm * f])
}

/// Largest difference of two stiffness matrices over the largest entry of the 3×3 block; for singular matrices.
pub fn block_difference(got: &Matrix6<f64>, expected: &Matrix6<f64>) -> f64 {
    let block = |m: &Matrix6<f64>, i: usize, j: usize| m.fixed_view::<3, 3>(3 * i, 3 * j).amax();
    let size = |i: usize| block(expected, i, i).sqrt();
    let pairs = [(0, 0), (0, 1), (1, 0), (1, 1)];
    pairs.into_iter().fold(0.0, |most, (i, j)| most.max(block(&(got - expected), i, j) / (size(i) * size(j))))
}
