//! Inverse kinematics: from a pose of P to the drives.

use nalgebra::{DMatrix, Vector3};

use super::{
    Configuration, Unreachable,
    closure::{Closure, Command},
    continuation::MIN_STEP,
    singularity::Barriers,
};
use crate::{
    machine::{Coordinate, Machine, redundancy::is_met},
    spatial::{Pose, rotation_exp, rotation_log},
};

/// Where a straight way ends is found to this share of the machine's characteristic length, but to no less than this share of the way.
const WAY_END: f64 = 1e-4;
const MIN_WAY_STEP: f64 = 1.0 / 16384.0;

/// Straight way of P from one pose to another.
#[derive(Debug, Clone, Copy)]
pub(super) struct StraightLine {
    start: Pose,
    end: Pose,
    shift: Vector3<f64>,
    turn: Vector3<f64>,
}

impl StraightLine {
    /// The way from pose `start` to pose `end`: a straight line of P with a rotation about one axis.
    pub fn new(start: &Pose, end: &Pose) -> Self {
        let turn = rotation_log(&(start.rotation.transpose() * end.rotation));
        Self { start: *start, end: *end, shift: end.translation - start.translation, turn }
    }

    /// The pose at the share `s` of the way.
    pub fn pose(&self, s: f64) -> Pose {
        match s {
            1.0 => self.end,
            _ => Pose {
                rotation: self.start.rotation * rotation_exp(self.turn * s),
                translation: self.start.translation + self.shift * s,
            },
        }
    }

    /// Share of the way that is the shortest step along it.
    pub fn least_step(&self, machine: &Machine) -> f64 {
        let length = libm::hypot(self.shift.norm(), self.turn.norm() * machine.characteristic_length);
        (WAY_END * machine.characteristic_length / length).clamp(MIN_WAY_STEP, MIN_STEP)
    }
}

impl Machine {
    /// Inverse kinematics: the configuration that puts the controlled task coordinates of P on those of `target`, on the assembly mode of home.
    ///
    /// It is the one that the straight line from home leads to. Where that does not lead there, or beyond a limit, other
    /// ways are tried: a serial machine takes any posture that its travel allows, the nearest to home of those found, since
    /// nothing is in the way from one to another; a parallel one goes around, without passing a singularity. Revolute joints are
    /// taken a full turn back or on where that brings them within their travel. Where the drives control more than the
    /// task asks for, they stand as near to home as they can, see [`Machine::redundancy`](crate::machine::Model::redundancy).
    ///
    /// An arm for which a branch was chosen ([`Machine::on_branch`]) stands on that branch only.
    ///
    /// # Errors
    /// [`Unreachable`] if no such configuration is found, or only beyond a limit or on another branch.
    pub fn inverse_kinematics(&self, target: &Pose) -> Result<Configuration, Unreachable> {
        self.inverse_kinematics_from(&self.home, target).or_else(|straight| self.try_other_branch(target, straight))
    }

    /// Inverse kinematics continued on the straight line from a known configuration `start` instead of home; no other way is tried.
    ///
    /// # Errors
    /// As [`Machine::inverse_kinematics`].
    pub fn inverse_kinematics_from(&self, start: &Configuration, target: &Pose) -> Result<Configuration, Unreachable> {
        self.check_span(target)?;
        let configuration = self.unlimited_inverse_kinematics_from(start, target)?;
        self.adjust_to_limits(configuration, target)
    }

    /// Inverse kinematics continued from a known configuration `start`, as if travel and joints had no limits.
    pub fn unlimited_inverse_kinematics_from(
        &self,
        start: &Configuration,
        target: &Pose,
    ) -> Result<Configuration, Unreachable> {
        let line = StraightLine::new(&start.pose, target);
        let reached = self.follow(start, line.least_step(self), Barriers::All, |s, closure, from| {
            closure.newton(from, &Command::Task(&line.pose(s)))
        });
        let end = reached.at.pose;
        self.conclude(reached, &Command::Task(target)).map_err(|unreachable| match unreachable {
            Unreachable::Closure { chain, .. } => Unreachable::TooFar { chain, short_mm: self.distance(&end, target) },
            other => other,
        })
    }

    /// Distance from `at` to `target` in the controlled coordinates, mm, rotations weighted by the characteristic length.
    fn distance(&self, at: &Pose, target: &Pose) -> f64 {
        let turn = rotation_log(&(at.rotation.transpose() * target.rotation)) * self.characteristic_length;
        let shift = target.translation - at.translation;
        let gap = self.controls.iter().map(|coordinate| match *coordinate {
            Coordinate::Translation(axis) => shift[axis],
            Coordinate::Rotation(axis) => turn[axis],
        });
        gap.map(|gap| gap * gap).sum::<f64>().sqrt()
    }

    /// Derivative of the drives by the controlled task coordinates at `at`: one row per drive (mm, rad), one column per
    /// coordinate (mm, rad about the axes of the platform). Redundant drives move as little as they can, prismatic joints in mm and
    /// revolute joints in mm at the machine's characteristic length. `None` in a singularity, as at the end of a chain's reach.
    pub fn drive_jacobian(&self, at: &Configuration) -> Option<DMatrix<f64>> {
        let mut closure = Closure::new(self);
        closure.linearise(at, &Command::Task(&at.pose));
        let right = self.equation_changes(&closure, &DMatrix::identity(self.controls.len(), self.controls.len()));
        let by_task = if self.redundancy > 0 {
            closure.min_norm_motions(&right)?
        } else {
            let transposed = closure.jacobian.transpose();
            let factor = (&transposed * &closure.jacobian).cholesky()?;
            let unknowns = factor.solve(&(transposed * &right));
            if !is_met(&(&closure.jacobian * &unknowns), &right) {
                return None;
            }
            unknowns.rows(6, self.drive_count()).into_owned()
        };
        Some(self.to_drive_units(&closure, by_task))
    }

    /// Drive motions (rows; mm, rad) that change the controlled coordinates by the columns of `changes` (mm, rad about platform axes).
    /// `None` only for changes that the drives cannot make: a singular fork head, its tool along its first axis, still moves the tip.
    pub(crate) fn drive_motions(&self, at: &Configuration, changes: &DMatrix<f64>) -> Option<DMatrix<f64>> {
        if let Some(jacobian) = self.drive_jacobian(at) {
            return Some(jacobian * changes);
        }
        let mut closure = Closure::new(self);
        closure.linearise(at, &Command::Task(&at.pose));
        let motions = closure.min_norm_motions(&self.equation_changes(&closure, changes))?;
        Some(self.to_drive_units(&closure, motions))
    }

    /// Right-hand sides by which the equations of `closure` change where the controlled coordinates change by `changes` (mm, rad).
    fn equation_changes(&self, closure: &Closure<'_>, changes: &DMatrix<f64>) -> DMatrix<f64> {
        let (equations, coordinates) = (closure.jacobian.nrows(), self.controls.len());
        let mut right = DMatrix::zeros(equations, changes.ncols());
        right.rows_mut(equations - coordinates, coordinates).copy_from(changes);
        for (i, _) in self.controls.iter().enumerate().filter(|(_, c)| matches!(c, Coordinate::Rotation(_))) {
            right.row_mut(equations - coordinates + i).scale_mut(self.characteristic_length);
        }
        right
    }

    /// Converts drive motions (rows) from mm to mm and rad.
    fn to_drive_units(&self, closure: &Closure<'_>, mut motions: DMatrix<f64>) -> DMatrix<f64> {
        for (mut row, (_, drive)) in motions.row_iter_mut().zip(self.drives()) {
            row /= closure.mm_per_unit(drive.motion);
        }
        motions
    }
}
