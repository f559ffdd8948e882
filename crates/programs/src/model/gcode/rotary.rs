//! Rotary axes A, B and C: position and orientation of the tool in W, and the inverse.
//!
//! With every axis at 0 the tool stands along z of W and its tip at the coordinates X, Y, Z. Axes that turn the workpiece displace it by
//! `D_t`, the product of their turns from the base outwards; those that turn the tool displace a tool whose tip is at the origin by `D_h`.
//! In machine coordinates, X, Y and Z move the head: the tip is at `D_t⁻¹ (p + D_h 0)` in W. With control of the tip (G43.4, TRAORI, M128),
//! X, Y and Z are where the tip is in W, or in an inclined plane. All these ways the tool's axis in W is `R_t⁻¹ R_h z`.

use nalgebra::{Matrix3, Vector3};
use serde::Deserialize;

use crate::model::gcode::{Coordinates, PartialPosition, located};
use kinetostat_spatial::{Pose, rotation_exp};

/// What a rotary axis turns: the tool or the workpiece.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RotarySide {
    /// The tool, in a head.
    Tool,
    /// The workpiece, on a table.
    Workpiece,
}

/// A rotary axis of a machine tool: its letter, direction, position and what it turns.
#[derive(Clone, Debug, PartialEq)]
pub struct RotaryAxis {
    /// A, B or C.
    pub letter: char,
    /// Direction of the axis with the other axes at 0, a unit vector in W; a positive angle turns the tool or workpiece right-handed about it.
    pub about: Vector3<f64>,
    /// What the axis turns.
    pub turns: RotarySide,
    /// A point of the axis with the other axes at 0, mm: of a table in W, of a head from the tool tip. Needed only where the control
    /// does not keep the tip in place.
    pub through_mm: Option<Vector3<f64>>,
    /// Least and greatest angle, degrees; `None` if they are not known.
    pub travel_deg: Option<[f64; 2]>,
}

/// A rotary axis of the program that is a drive of the machine, and the path column that commands it.
#[derive(Clone, Debug, PartialEq)]
pub struct RotaryColumn {
    /// A, B or C.
    pub letter: char,
    /// The drive's column in a path, such as `external_A_deg`.
    pub column: String,
    /// Whether the process file lists the axis too: then it is at 0 in programs that do not name it; otherwise it is at home in programs
    /// that name no rotary axis.
    pub is_given: bool,
    /// Whether the drive serves the task near where the program leads it, as the orientation is corrected: it is no external axis then. Those
    /// are the last of all.
    pub is_led: bool,
}

/// The rotary axes of a machine tool, from its base outwards.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Rotary {
    /// The axes; none if the program's A, B and C must stand still.
    pub axes: Vec<RotaryAxis>,
    /// Whether X, Y and Z are always coordinates of the tool tip, with or without G43.4.
    pub always_of_tip: bool,
}

/// Whether they are followed: pages get programs that turn as points.
const FOLLOWED: bool = !cfg!(target_family = "wasm");

/// Most steps to the angles of an axis of the tool.
const MAX_STEPS: usize = 10;
/// Axes that differ by less are the same.
const SAME: f64 = 1e-13;
/// Angle for difference quotients, rad.
const SMALL_RAD: f64 = 1e-5;
/// An axis that turns the tool by less than this share of its own turn is not used.
const POLE: f64 = 0.05;

/// Angles of A, B and C, degrees.
pub(crate) type Angles = [f64; 3];

/// Returns the index of a letter among A, B and C; 0 for any other.
pub(crate) fn axis_index(letter: char) -> usize {
    ['A', 'B', 'C'].iter().position(|known| *known == letter).unwrap_or(0)
}

impl Rotary {
    /// Whether the machine has no rotary axes that programs may turn.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        !FOLLOWED || self.axes.is_empty()
    }

    /// Returns what X, Y and Z are coordinates of outside of inclined planes, with control of the tip or without.
    pub(crate) fn coordinates(&self, has_tip_control: bool) -> Coordinates {
        if has_tip_control || self.always_of_tip { Coordinates::Tip } else { Coordinates::Head }
    }

    /// Whether there is a rotary axis with this letter.
    pub(crate) fn has_axis(&self, letter: char) -> bool {
        FOLLOWED && self.axes.iter().any(|axis| axis.letter == letter)
    }

    /// Returns the letter of the first axis that is not at 0 and whose position (`through_mm`) is unknown; `None` if there is none.
    pub(crate) fn first_unlocated_axis(&self, angles: &Angles) -> Option<char> {
        if !FOLLOWED {
            return None;
        }
        let turned = |axis: &&RotaryAxis| angles[axis_index(axis.letter)] != 0.0 && axis.through_mm.is_none();
        self.axes.iter().find(turned).map(|axis| axis.letter)
    }

    /// Returns the displacements (mm in W) that the axes on the side of the workpiece, and those on the side of the tool, give at `angles`
    /// (degrees), relative to all at 0.
    pub(super) fn displacements(&self, angles: &Angles) -> [Pose; 2] {
        [RotarySide::Workpiece, RotarySide::Tool].map(|side| {
            let axes = self.axes.iter().filter(|axis| axis.turns == side);
            axes.fold(Pose::identity(), |so_far, axis| {
                let rotation = rotation_exp(axis.about * angles[axis_index(axis.letter)].to_radians());
                let through = axis.through_mm.unwrap_or_default();
                so_far.compose(&Pose { rotation, translation: through - rotation * through })
            })
        })
    }

    /// Returns the tool axis from tip to spindle at `angles` (degrees), a unit vector in W.
    pub fn tool_axis(&self, angles: &Angles) -> Vector3<f64> {
        let [table, head] = self.displacements(angles);
        table.rotation.tr_mul(&(head.rotation * Vector3::z())).normalize()
    }

    /// Solves for the angles (degrees) near `near` at which the tool axis is `target_axis`, a unit vector in W. Near a pole, where an axis
    /// turns the tool about itself, the part of the change that only that axis could make is left out.
    pub(crate) fn angles_for(&self, target_axis: &Vector3<f64>, near: &Angles) -> Angles {
        let mut angles = *near;
        for _ in 0..MAX_STEPS {
            let error = target_axis - self.tool_axis(&angles);
            if error.norm() <= SAME {
                break;
            }
            let slope = |axis: usize| {
                let axis_at = |turn: f64| {
                    let mut angles = angles;
                    angles[axis] += turn.to_degrees();
                    self.tool_axis(&angles)
                };
                (axis_at(SMALL_RAD) - axis_at(-SMALL_RAD)) / (2.0 * SMALL_RAD)
            };
            let slopes = Matrix3::from_columns(&[slope(0), slope(1), slope(2)]);
            let Ok(step) = slopes.svd(true, true).solve(&error, POLE) else { break };
            (0..3).for_each(|axis| angles[axis] += step[axis].to_degrees());
        }
        angles
    }

    /// Returns the position of the tool tip in W, mm, for the programmed head position `machine` (mm) and `angles` (degrees).
    pub fn tip_position(&self, machine: Vector3<f64>, angles: &Angles) -> Vector3<f64> {
        let [table, head] = self.displacements(angles);
        table.inverse().transform(machine + head.translation)
    }

    /// Converts a position, mm, to other coordinates at `angles` (degrees): unknown if a coordinate or axis is, and into and out of an inclined
    /// plane, where it is not certain that the tool stands along z.
    pub(crate) fn convert_position(
        &self,
        position: PartialPosition,
        angles: &Angles,
        [from, to]: [Coordinates; 2],
    ) -> PartialPosition {
        if from == to || !FOLLOWED {
            return position;
        }
        if [from, to].iter().any(|coordinates| matches!(coordinates, Coordinates::Inclined(_))) {
            return [None; 3];
        }
        if *angles == [0.0; 3] {
            return position;
        }
        let old = located(position).filter(|_| self.first_unlocated_axis(angles).is_none());
        let new = old.map(|at| self.programmed_position(to, self.tip_at(from, at, angles), angles));
        new.map_or([None; 3], |at| [Some(at.x), Some(at.y), Some(at.z)])
    }

    /// Returns the programmed head position, mm, for a tool tip at `tip` in W (mm) and `angles` (degrees).
    pub fn head_position(&self, tip: Vector3<f64>, angles: &Angles) -> Vector3<f64> {
        let [table, head] = self.displacements(angles);
        table.transform(tip) - head.translation
    }
}

/// The angles of the rotary axes, degrees, at the start and the end of a motion.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct RotaryMotion {
    pub from: Angles,
    pub to: Angles,
    /// What X, Y and Z are coordinates of.
    pub coordinates: Coordinates,
}

impl RotaryMotion {
    /// Returns the angles of the rotary axes, degrees, at the share `t` of the motion: 0 at its start, from 1 on its end.
    pub fn at(&self, t: f64) -> Angles {
        std::array::from_fn(|axis| {
            if t < 1.0 { self.from[axis] + (self.to[axis] - self.from[axis]) * t } else { self.to[axis] }
        })
    }

    /// Whether an axis turns during the motion.
    pub fn turns(&self) -> bool {
        FOLLOWED && self.from != self.to
    }

    /// Whether X, Y and Z differ from the tip coordinates in W: those of an inclined plane, or of the head with an axis that is not at 0.
    pub fn displaces_tip(&self) -> bool {
        FOLLOWED
            && match self.coordinates {
                Coordinates::Head => self.from != [0.0; 3] || self.to != [0.0; 3],
                Coordinates::Tip => false,
                Coordinates::Inclined(_) => true,
            }
    }
}
