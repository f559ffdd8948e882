//! Rotary axes: where the tool is and how it stands when A, B and C turn tool and workpiece.
//!
//! With every axis at 0 the tool stands along z of W and its tip at the coordinates X, Y, Z. Axes that turn the workpiece displace it by
//! `D_t`, the product of their turns from the base outwards; those that turn the tool displace a tool whose tip is at the origin by `D_h`.
//! In machine coordinates, X, Y and Z move the head: the tip is at `D_t⁻¹ (p + D_h 0)` in W. With control of the tip (G43.4, TRAORI, M128),
//! X, Y and Z are where the tip is in W. Both ways the tool's axis in W is `R_t⁻¹ R_h z`.

use nalgebra::{Matrix3, Vector3};
use serde::Deserialize;

use crate::{
    spatial::{Pose, rotation_exp},
    toolpath::model::gcode::{Known, located},
};

/// What a rotary axis turns.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Turned {
    /// The tool, in a head.
    Tool,
    /// The workpiece, on a table.
    Workpiece,
}

/// A rotary axis of a machine tool.
#[derive(Clone, Debug, PartialEq)]
pub struct RotaryAxis {
    /// A, B or C.
    pub letter: char,
    /// The direction it turns about with the other axes at 0, a unit vector in W; what it turns turns right-handed about it.
    pub about: Vector3<f64>,
    /// What it turns.
    pub turns: Turned,
    /// A point of its axis with the other axes at 0: of a table in W, of a head from the tip of the tool, mm. It is needed only where
    /// the control does not keep the tip in its place.
    pub through_mm: Option<Vector3<f64>>,
}

/// A rotary axis that is a drive of the machine.
#[derive(Clone, Debug, PartialEq)]
pub struct RotaryColumn {
    /// A, B or C.
    pub letter: char,
    /// What a path calls it: `external_A_deg`.
    pub column: String,
    /// Whether the file has it as well, so that it stands at 0 in programs that do not name it; else it stands at home in those that
    /// name none.
    pub is_given: bool,
}

/// The rotary axes of a machine tool, from its base outwards.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Rotary {
    /// The axes; none if the program's A, B and C must stand still.
    pub axes: Vec<RotaryAxis>,
    /// Whether X, Y and Z are always those of the tip, whatever the program says.
    pub always_of_tip: bool,
}

/// Whether they are followed: pages get programs that turn as points.
const FOLLOWED: bool = !cfg!(target_family = "wasm");

/// Most steps to the angles of an axis of the tool.
const MOST_STEPS: usize = 10;
/// Axes that differ by less are the same.
const SAME: f64 = 1e-13;
/// Angle for difference quotients, rad.
const SMALL_RAD: f64 = 1e-5;
/// An axis that turns the tool by less than this share of its own turn is not used.
const POLE: f64 = 0.05;

/// Angles of A, B and C, degrees.
pub(crate) type Angles = [f64; 3];

/// Index of a letter among A, B and C.
pub(crate) fn index(letter: char) -> usize {
    ['A', 'B', 'C'].iter().position(|known| *known == letter).unwrap_or(0)
}

impl Rotary {
    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        !FOLLOWED || self.axes.is_empty()
    }

    pub(crate) fn has(&self, letter: char) -> bool {
        FOLLOWED && self.axes.iter().any(|axis| axis.letter == letter)
    }

    /// The first axis that stands elsewhere than at 0 and of which it is not known where it is.
    pub(crate) fn without_place(&self, angles: &Angles) -> Option<char> {
        if !FOLLOWED {
            return None;
        }
        let turned = |axis: &&RotaryAxis| angles[index(axis.letter)] != 0.0 && axis.through_mm.is_none();
        self.axes.iter().find(turned).map(|axis| axis.letter)
    }

    /// How the axes displace what they turn.
    fn displacement(&self, turned: Turned, angles: &Angles) -> Pose {
        let own = self.axes.iter().filter(|axis| axis.turns == turned);
        own.fold(Pose::identity(), |so_far, axis| {
            let rotation = rotation_exp(axis.about * angles[index(axis.letter)].to_radians());
            let through = axis.through_mm.unwrap_or_default();
            so_far.compose(&Pose { rotation, translation: through - rotation * through })
        })
    }

    /// The tool's axis from its tip to the spindle, a unit vector in W.
    pub fn tool_axis(&self, angles: &Angles) -> Vector3<f64> {
        let (table, head) = (self.displacement(Turned::Workpiece, angles), self.displacement(Turned::Tool, angles));
        table.rotation.tr_mul(&(head.rotation * Vector3::z())).normalize()
    }

    /// Angles near `near` at which the tool's axis is `wanted`, a unit vector in W, as nearly as the axes can without turning far: near a pole,
    /// where an axis turns the tool about itself, what only that axis could do is left.
    pub(crate) fn angles_for(&self, wanted: &Vector3<f64>, near: &Angles) -> Angles {
        let mut angles = *near;
        for _ in 0..MOST_STEPS {
            let off = wanted - self.tool_axis(&angles);
            if off.norm() <= SAME {
                break;
            }
            let slope = |axis: usize| {
                let at = |turn: f64| {
                    let mut angles = angles;
                    angles[axis] += turn.to_degrees();
                    self.tool_axis(&angles)
                };
                (at(SMALL_RAD) - at(-SMALL_RAD)) / (2.0 * SMALL_RAD)
            };
            let slopes = Matrix3::from_columns(&[slope(0), slope(1), slope(2)]);
            let Ok(step) = slopes.svd(true, true).solve(&off, POLE) else { break };
            (0..3).for_each(|axis| angles[axis] += step[axis].to_degrees());
        }
        angles
    }

    /// Where the tip is in W, mm, with the head at `machine`, mm.
    pub fn tip(&self, machine: Vector3<f64>, angles: &Angles) -> Vector3<f64> {
        let (table, head) = (self.displacement(Turned::Workpiece, angles), self.displacement(Turned::Tool, angles));
        table.inverse().transform(machine + head.translation)
    }

    /// Coordinates of the head as those of the tip that is there, or the other way; none where it is not known.
    pub(crate) fn switched(&self, position: Known, angles: &Angles, to_tip: bool) -> Known {
        if !FOLLOWED || *angles == [0.0; 3] {
            return position;
        }
        let here = located(position).filter(|_| self.without_place(angles).is_none());
        let there = here.map(|at| if to_tip { self.tip(at, angles) } else { self.head(at, angles) });
        there.map_or([None; 3], |at| [Some(at.x), Some(at.y), Some(at.z)])
    }

    /// Where the head is for a tip at `tip` of W, mm.
    pub fn head(&self, tip: Vector3<f64>, angles: &Angles) -> Vector3<f64> {
        let (table, head) = (self.displacement(Turned::Workpiece, angles), self.displacement(Turned::Tool, angles));
        table.transform(tip) - head.translation
    }
}

/// How the rotary axes turn along a motion.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Turning {
    pub from: Angles,
    pub to: Angles,
    /// Whether X, Y and Z are those of the tip.
    pub of_tip: bool,
}

impl Turning {
    /// The angles at the share `t` of the motion.
    pub fn at(&self, t: f64) -> Angles {
        std::array::from_fn(|axis| {
            if t < 1.0 { self.from[axis] + (self.to[axis] - self.from[axis]) * t } else { self.to[axis] }
        })
    }

    /// Whether an axis turns.
    pub fn turns(&self) -> bool {
        FOLLOWED && self.from != self.to
    }

    /// Whether coordinates are other than those of the tip in W.
    pub fn displaces(&self) -> bool {
        FOLLOWED && !self.of_tip && (self.from != [0.0; 3] || self.to != [0.0; 3])
    }
}
