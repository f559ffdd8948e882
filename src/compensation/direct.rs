//! Newton on the drives: each step moves the drives by the exact sensitivity of the loaded machine.

use nalgebra::{DMatrix, DVector, Vector3};

use crate::{
    machine::{Coordinate, Machine},
    spatial::{Pose, Wrench, rotation_log},
    statics::{Outcome, Settings, State, Workspace, equilibrium},
};

/// What is put right.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Target {
    /// The tool tip T (and the controlled rotations).
    #[default]
    ToolTip,
    /// The platform point P (and the controlled rotations).
    PlatformPoint,
}

/// A compensated state.
#[derive(Debug, Clone, PartialEq)]
pub struct Compensated {
    /// Drives ρ that put the target right under load, mm or rad.
    pub drives: Vec<f64>,
    /// Largest task error left, mm (rotations times reach).
    pub task_error: f64,
    /// Corrections of the drives made.
    pub iterations: usize,
    /// The equilibrium reached.
    pub outcome: Outcome,
    /// Whether `task_error` came below the tolerance in a stable equilibrium.
    pub converged: bool,
}

/// Task error accepted, mm.
const TOLERANCE: f64 = 1e-10;
const MAX_ITERATIONS: usize = 12;

/// Displacement in mm of the tool tip between two poses of P, O axes: `to` less `from`.
pub fn tool_error(machine: &Machine, to: &Pose, from: &Pose) -> Vector3<f64> {
    to.transform(machine.tool_tip) - from.transform(machine.tool_tip)
}

/// Error of each controlled task coordinate at `pose`, mm (rotations times reach), and its derivative by the twist of P.
fn task(machine: &Machine, target: Target, desired: &Pose, pose: &Pose) -> (DVector<f64>, DMatrix<f64>) {
    let offset = match target {
        Target::ToolTip => machine.tool_tip,
        Target::PlatformPoint => Vector3::zeros(),
    };
    let lever = pose.rotation * offset;
    let shift = pose.transform(offset) - desired.transform(offset);
    let turn = rotation_log(&(desired.rotation.transpose() * pose.rotation));
    let count = machine.controls.len();
    let (mut error, mut slope) = (DVector::zeros(count), DMatrix::zeros(count, 6));
    for (row, coordinate) in machine.controls.iter().enumerate() {
        match *coordinate {
            Coordinate::Translation(axis) => {
                error[row] = shift[axis];
                slope[(row, axis)] = 1.0;
                let mut direction = Vector3::zeros();
                direction[axis] = 1.0;
                let by_rotation = lever.cross(&direction);
                slope.view_mut((row, 3), (1, 3)).copy_from(&by_rotation.transpose());
            }
            Coordinate::Rotation(axis) => {
                error[row] = turn[axis] * machine.reach;
                let direction = desired.rotation.column(axis) * machine.reach;
                slope.view_mut((row, 3), (1, 3)).copy_from(&direction.transpose());
            }
        }
    }
    (error, slope)
}

/// Drives that bring the controlled task coordinates of `target` to those of `desired` (pose of P) under the dead wrench
/// `load` at P.
///
/// `machine` is the real machine. `drives` are where the search starts (the nominal inverse kinematics), `state` an
/// equilibrium of the same load near there; it receives the compensated equilibrium.
pub fn compensate_directly(
    machine: &Machine,
    desired: &Pose,
    load: &Wrench,
    target: Target,
    drives: &[f64],
    state: &mut State,
    workspace: &mut Workspace,
) -> Compensated {
    let settings = Settings { tolerance: 1e-13, ..Settings::default() };
    let mut drives = drives.to_vec();
    let mut iterations = 0;
    loop {
        let outcome = equilibrium(machine, &drives, load, state, workspace, &settings);
        let (error, slope) = task(machine, target, desired, &state.pose);
        let task_error = error.amax();
        let solved = outcome.is_equilibrium();
        if !solved || task_error <= TOLERANCE || iterations == MAX_ITERATIONS {
            let converged = outcome.status == crate::statics::Status::Solved && task_error <= TOLERANCE;
            return Compensated { drives, task_error, iterations, outcome, converged };
        }
        let response = slope * &outcome.drive_sensitivity;
        let Ok(inverse) = response.pseudo_inverse(1e-12) else {
            return Compensated { drives, task_error, iterations, outcome, converged: false };
        };
        let correction = inverse * error;
        for (rho, change) in drives.iter_mut().zip(correction.iter()) {
            *rho -= change;
        }
        iterations += 1;
    }
}
