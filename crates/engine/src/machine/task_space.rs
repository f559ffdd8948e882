//! Task coordinates of a machine: the translations that its drives control, and its workspace box.

use std::fmt;

use nalgebra::{Matrix3, Vector3};

use super::{Configuration, Coordinate, Machine, Unreachable};
use crate::spatial::rotation_log;

/// Names of the axes of O.
const AXES: [&str; 3] = ["x", "y", "z"];

/// A difference below this share of the machine's characteristic length is none: machine files are written with so many digits.
pub(super) const SAME_PLACE: f64 = 1e-6;

/// Orientations nearer to each other are the same, rad: angles are given with so many digits.
const SAME_ORIENTATION: f64 = 1e-5;

/// A position outside the workspace box by less is within it but for rounding, mm: less than any machine is positioned to.
const ROUNDING_MM: f64 = 1e-4;

impl Coordinate {
    /// Name of the coordinate in machine files.
    pub fn name(self) -> &'static str {
        match self {
            Coordinate::Translation(axis) => AXES[axis],
            Coordinate::Rotation(axis) => ["rotation_x", "rotation_y", "rotation_z"][axis],
        }
    }
}

/// Difference between asked and actual position of P along an axis that the drives do not control.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UncontrolledDifference {
    /// Index of the axis of O.
    pub axis: usize,
    /// Position asked for, mm.
    pub asked: f64,
    /// Position of P, mm.
    pub stands: f64,
}

/// A position outside the machine's workspace box.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OutsideWorkspace {
    /// Index of the axis of O along which it is farthest outside.
    pub axis: usize,
    /// The position along it, mm.
    pub value: f64,
    /// Ends of the box along it, mm.
    pub ends: [f64; 2],
}

/// Rounds a number to six decimals, for messages.
pub(super) fn round_off(length: f64) -> f64 {
    (length * 1e6).round() / 1e6
}

impl fmt::Display for OutsideWorkspace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (axis, [low, high]) = (AXES[self.axis], self.ends);
        write!(f, "{axis} = {} mm is outside the machine's workspace box, {low} to {high} mm", round_off(self.value))
    }
}

impl Machine {
    /// Whether the drives control the translation of P along this axis of O.
    pub fn controls_translation(&self, axis: usize) -> bool {
        self.controls.contains(&Coordinate::Translation(axis))
    }

    /// Axes of O along which the drives do not move P; another axis of the machine tool may.
    pub fn uncontrolled_axes(&self) -> impl Iterator<Item = usize> {
        (0..3).filter(|&axis| !self.controls_translation(axis))
    }

    /// Describes how coordinates of a path that the drives do not control are treated; `None` if they control all translations.
    pub fn uncontrolled_text(&self) -> Option<String> {
        let names = self.uncontrolled_names()?;
        Some(format!("{names} of the base, taken where the machine stands; words of a program for {names} stay"))
    }

    /// Names of [`Machine::uncontrolled_axes`], separated by commas; `None` if there are none.
    pub fn uncontrolled_names(&self) -> Option<String> {
        let names: Vec<&str> = self.uncontrolled_axes().map(|axis| AXES[axis]).collect();
        (!names.is_empty()).then(|| names.join(", "))
    }

    /// Position `asked` of P (O, mm) with the coordinates that the drives do not control replaced by those of home.
    pub fn controllable_position(&self, asked: Vector3<f64>) -> Vector3<f64> {
        let home = self.home.pose.translation;
        Vector3::from_fn(|axis, _| if self.controls_translation(axis) { asked[axis] } else { home[axis] })
    }

    /// Largest difference between `asked` and where P `stands` (both in O, mm) along an axis that the drives do not control; `None` if they agree.
    pub fn uncontrolled_difference(&self, asked: Vector3<f64>, stands: Vector3<f64>) -> Option<UncontrolledDifference> {
        let differences = self.uncontrolled_axes().map(|axis| UncontrolledDifference {
            axis,
            asked: asked[axis],
            stands: stands[axis],
        });
        let size = |d: &UncontrolledDifference| (d.asked - d.stands).abs();
        differences
            .filter(|d| size(d) > SAME_PLACE * self.characteristic_length)
            .max_by(|a, b| size(a).total_cmp(&size(b)))
    }

    /// Checks that P at the configuration `at` is at `asked` (O, mm) along the axes that the drives do not control.
    ///
    /// # Errors
    /// [`Unreachable::Uncontrolled`], which names the coordinate and the difference.
    pub fn check_uncontrolled(&self, asked: Vector3<f64>, at: &Configuration) -> Result<(), Unreachable> {
        let Some(difference) = self.uncontrolled_difference(asked, at.pose.translation) else { return Ok(()) };
        Err(Unreachable::Uncontrolled {
            axis: AXES[difference.axis].into(),
            asked: round_off(difference.asked),
            stands: round_off(difference.stands),
            controls: self.controls.iter().map(|c| c.name()).collect::<Vec<_>>().join(", "),
        })
    }

    /// Checks that the platform at the configuration `at` has the orientation `asked` (`R_OP`), to 1e-5 rad.
    ///
    /// # Errors
    /// [`Unreachable::OtherOrientation`].
    pub fn check_orientation(&self, asked: &Matrix3<f64>, at: &Configuration) -> Result<(), Unreachable> {
        let apart = rotation_log(&(asked.transpose() * at.pose.rotation)).norm();
        if apart <= SAME_ORIENTATION {
            return Ok(());
        }
        let [roll, pitch, yaw] = at.pose.roll_pitch_yaw_deg().map(|angle| round_off(angle) + 0.0);
        Err(Unreachable::OtherOrientation {
            apart_deg: apart.to_degrees(),
            stands: format!("({roll}, {pitch}, {yaw})"),
            controls: self.controls.iter().map(|c| c.name()).collect::<Vec<_>>().join(", "),
        })
    }

    /// Inverse kinematics of P at `position` mm, the platform oriented as at home as far as the drives control that.
    ///
    /// # Errors
    /// As [`Machine::inverse_kinematics`], and [`Unreachable::Uncontrolled`] for an uncontrolled coordinate elsewhere than where it stands.
    pub fn inverse_kinematics_at(&self, position: Vector3<f64>) -> Result<Configuration, Unreachable> {
        let at = self.inverse_kinematics(&self.pose_at(position))?;
        self.check_uncontrolled(position, &at)?;
        Ok(at)
    }

    /// The axis along which `position` of P (O, mm) is farthest outside the machine's workspace box; `None` inside.
    pub fn outside_workspace(&self, position: Vector3<f64>) -> Option<OutsideWorkspace> {
        let (min, max) = (self.workspace.min, self.workspace.max);
        let excess = |axis: usize| (min[axis] - position[axis]).max(position[axis] - max[axis]);
        let axis = (0..3).max_by(|&a, &b| excess(a).total_cmp(&excess(b)))?;
        let is_outside = excess(axis) > ROUNDING_MM;
        is_outside.then(|| OutsideWorkspace { axis, value: position[axis], ends: [min[axis], max[axis]] })
    }
}
