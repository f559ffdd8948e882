//! A reachable box about home, the workspace of an imported machine.

use nalgebra::Vector3;

use crate::machine::{Machine, WorkspaceBox};

/// Half the box's edges as shares of the chain's length, tried in this order.
const SHARES: [f64; 11] = [0.5, 0.4, 0.3, 0.25, 0.2, 0.15, 0.1, 0.07, 0.05, 0.02, 0.01];
/// Shorter half edges are not worth a box, mm.
const SHORTEST: f64 = 1.0;

/// Returns the largest of several boxes about home (shares of `length`, mm) whose corners and middles of edges and faces are
/// reachable with the platform oriented as at home; home alone if there is none.
pub(super) fn box_about_home(machine: &Machine, length: f64) -> WorkspaceBox {
    let home = machine.home.pose.translation;
    let none = WorkspaceBox { min: home, max: home };
    let halves = SHARES.iter().map(|share| (share * length).floor()).filter(|&half| half >= SHORTEST);
    let boxes = halves.map(|half| {
        let edge = |axis: usize, half: f64| {
            if machine.controls_translation(axis) { (home[axis] + half).round() + 0.0 } else { home[axis] }
        };
        WorkspaceBox { min: Vector3::from_fn(|i, _| edge(i, -half)), max: Vector3::from_fn(|i, _| edge(i, half)) }
    });
    boxes.into_iter().find(|candidate| is_reachable(machine, candidate)).unwrap_or(none)
}

/// Whether the corners, and the middles of edges and faces, of a box are reachable.
fn is_reachable(machine: &Machine, candidate: &WorkspaceBox) -> bool {
    let middle = (candidate.min + candidate.max) * 0.5;
    let pick = |index: usize, axis: usize| match index / 3usize.pow(axis as u32) % 3 {
        0 => candidate.min[axis],
        1 => middle[axis],
        _ => candidate.max[axis],
    };
    (0..27).all(|index| {
        let position = Vector3::from_fn(|axis, _| pick(index, axis));
        let target = machine.pose_at(position);
        let reached = machine.inverse_kinematics_from(&machine.home, &target);
        reached.is_ok_and(|at| machine.check_uncontrolled(position, &at).is_ok())
    })
}
