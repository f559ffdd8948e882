//! Positions and forces at which a correction is looked at.

use nalgebra::Vector3;

use super::CorrectionQuestion;
use crate::{answer::halton::radical_inverse, spatial::Grid};

/// A position of P (O, mm) and a force on the tool tip (O axes, N).
pub(super) type Case = (Vector3<f64>, Vector3<f64>);

/// Corners and middles of cells, faces and edges, under no force and the largest one along each axis.
pub(super) fn lattice(question: &CorrectionQuestion, cells: &Grid) -> Vec<Case> {
    let [min, max] = question.corners;
    let grid = Grid::new(min, max, cells.counts().map(|count| 2 * count - 1));
    let forces = axis_forces(question.largest_force_N);
    (0..grid.len())
        .flat_map(|index| forces.iter().map(move |force| (index, *force)))
        .map(|(index, force)| (grid.position(index), force))
        .collect()
}

/// The largest force along, and between, the axes, and about half of it.
pub(super) fn force_directions(largest: f64) -> Vec<Vector3<f64>> {
    if largest == 0.0 {
        return vec![Vector3::zeros()];
    }
    let sides = Grid::new(-Vector3::repeat(1.0), Vector3::repeat(1.0), [3; 3]);
    let directions = (0..sides.len()).filter_map(|index| sides.position(index).try_normalize(0.0));
    directions.flat_map(|direction| [direction * largest, direction * (0.55 * largest)]).collect()
}

/// A point of the Halton sequence: position, direction and size of the force.
pub(super) fn spread(question: &CorrectionQuestion, index: usize) -> Case {
    let [min, max] = question.corners;
    let at = |base| radical_inverse(index, base);
    let position = min + (max - min).component_mul(&Vector3::new(at(2), at(3), at(5)));
    let (height, turn, size) = (2.0 * at(7) - 1.0, std::f64::consts::TAU * at(11), at(13).cbrt());
    let across = (1.0 - height * height).max(0.0).sqrt();
    let direction = Vector3::new(across * turn.cos(), across * turn.sin(), height);
    (position, direction * (size * question.largest_force_N))
}

/// No force, and one of the size `largest` along each axis, both ways.
pub(super) fn axis_forces(largest: f64) -> Vec<Vector3<f64>> {
    let mut forces = vec![Vector3::zeros()];
    if largest > 0.0 {
        forces.extend((0..3).flat_map(|axis| [largest, -largest].map(|size| Vector3::ith(axis, size))));
    }
    forces
}
