//! Inclined planes (G68.2, PLANE, CYCLE800): what X, Y and Z are coordinates of, and the angles that a control chooses.
//!
//! An inclined plane is a frame in W. X, Y and Z are those of the tip in it, whatever the rotary axes do, once the tool stands along its z.
//! Two pairs of angles, at most, turn the tool there; which of them, each control decides by its own rule.

use std::cmp::Ordering;

use nalgebra::{Matrix3, Vector3};
use thiserror::Error;

use crate::model::gcode::{Angles, Rotary, RotarySide, axis_index};
use kinetostat_spatial::{Pose, rotation_exp};

/// What X, Y and Z of a program are coordinates of.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) enum Coordinates {
    /// The head: the tip if all rotary axes are at 0.
    #[default]
    Head,
    /// The tip, in W.
    Tip,
    /// The tip, in an inclined plane with this pose in W, mm.
    Inclined(Pose),
}

/// How the rotation of an inclined plane is given, by I, J and K; angles in degrees.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Inclination {
    /// G68.2, PLANE EULER: about z, about the new x, about the new z.
    Euler,
    /// PLANE SPATIAL: about the fixed axes x, y and z, one after the other.
    Spatial,
    /// PLANE RELATIV: the same about the axes of the plane in force.
    Relative,
    /// PLANE VECTOR, PLANE POINTS: x along this vector, and z along that of P, L and R, at a right angle to it.
    Vectors,
    /// PLANE AXIAL: across the tool where the axes A, B and C are at these angles.
    Axial,
    /// CYCLE800, axis by axis: about these axes (0 is x) as turned so far, one after the other.
    AxisByAxis([usize; 3]),
}

/// Which angles a control chooses where it turns the tool along z of an inclined plane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum AngleChoice {
    /// G53.1: the first axis turns least, then the second, then the first is nearest to 0, then the second (Fanuc, *Series 16i/18i-MB
    /// Operator's Manual* B-63534EN, Tool Axis Direction Control). With one axis each of tool and table, the table's counts first.
    Least,
    /// PLANE with SEQ+ or SEQ−: the axis of the head next to the tool, or else that of the table next to the base, is at an angle of this sign
    /// (Heidenhain, *iTNC 530 User's Manual*, PLANE, Selection of alternate tilting possibilities).
    Sign {
        /// SEQ+.
        is_positive: bool,
        /// TABLE ROT: a table that turns about z of the plane turns with it, which is not followed.
        turns_table: bool,
    },
    /// PLANE without SEQ: the shorter way, and SEQ+ of two of one length (same manual).
    Shorter {
        /// TABLE ROT.
        turns_table: bool,
    },
    /// CYCLE800 with a direction: rotary axis 1 at the higher of its angles, or at the lower (Siemens, *SINUMERIK 828D Operating Manual*,
    /// Swivel plane: preferred direction, rotary axis 1). Axis 1 carries axis 2, and is that of the tool where one turns the table (Siemens,
    /// *SINUMERIK 840D sl Commissioning Manual*, CYCLE800 checklist).
    Direction {
        /// `_DIR = 1`.
        is_higher: bool,
    },
    /// PLANE RESET TURN: all axes at 0.
    Zero,
    /// PLANE AXIAL: the angles that it gives.
    Given,
}

/// Why an inclined plane is not followed.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum InclinedFault {
    /// No rotary axes.
    #[error(
        "inclines the plane, and no rotary axes are known; expected a machine with drives A, B or C, or [[gcode.rotary]] in the process file"
    )]
    NoAxes,
    /// Three rotary axes, of which the control chooses.
    #[error("turns the tool by axes that the control chooses out of three; expected a machine with two rotary axes")]
    ThreeAxes,
    /// Parameters that are not followed.
    #[error("an inclined plane that is not followed in this form; expected {expected}")]
    Form {
        /// What is followed.
        expected: &'static str,
    },
    /// Angles out of reach.
    #[error(
        "the rotary axes cannot turn the tool along z of the inclined plane, as it is asked for and within their travel; expected a plane that \
         they reach"
    )]
    NotReached,
    /// G53.1 without G68.2.
    #[error("turns the tool along z of an inclined plane where there is none; expected G68.2 before")]
    NoPlane,
    /// A motion before the tool is turned.
    #[error(
        "the tool stands {degrees:.3} degrees beside z of the inclined plane; expected before it what turns the tool there: G53.1, PLANE … TURN, \
         CYCLE800 with a direction, or the angles"
    )]
    NotAlong {
        /// Angle between tool and z, degrees.
        degrees: f64,
    },
    /// A motion that turns the tool.
    #[error("moves and turns the tool in an inclined plane; expected the angles on a line of their own")]
    Turns,
    /// A zero or a mode that would have to be followed in the plane.
    #[error(
        "not followed in an inclined plane; expected it before the plane, or behind its end (G69, PLANE RESET, CYCLE800())"
    )]
    Inside,
    /// A shifted zero.
    #[error("inclines the plane about a zero that G52, G92 or TRANS has shifted; expected the plane without them")]
    Shifted,
}

/// Axes that differ by less, as a cosine or sine, are the same.
const SAME_DIRECTION: f64 = 1e-9;
/// Angles that differ by less are the same, degrees: rounding must not choose.
const SAME_DEG: f64 = 1e-6;

/// Angles are whole numbers of this share of a degree.
const PER_DEG: f64 = 1e9;

/// A direction in W about which an axis turns the tool right-handed, and the axis, an index into the angles.
type Turn = (Vector3<f64>, usize);

impl Inclination {
    /// Returns the rotation of the plane in W, by its I, J and K and its P, L and R; `before` is that of the plane in force. With
    /// [`Inclination::Axial`], see [`Rotary::plane_across_tool`].
    pub fn rotation(self, angles: [f64; 3], normal: [f64; 3], before: Matrix3<f64>) -> Matrix3<f64> {
        let about = |axis: usize, k: usize| {
            let mut turn = Vector3::zeros();
            turn[axis] = angles[k].to_radians();
            rotation_exp(turn)
        };
        match self {
            Inclination::Euler => about(2, 0) * about(0, 1) * about(2, 2),
            Inclination::Spatial => about(2, 2) * about(1, 1) * about(0, 0),
            Inclination::Relative => before * Inclination::Spatial.rotation(angles, normal, before),
            Inclination::Vectors => {
                let z = Vector3::from(normal).normalize();
                let y = z.cross(&Vector3::from(angles)).normalize();
                Matrix3::from_columns(&[y.cross(&z), y, z])
            }
            Inclination::Axial => before,
            Inclination::AxisByAxis([a, b, c]) => about(a, 0) * about(b, 1) * about(c, 2),
        }
    }
}

impl Rotary {
    /// Returns the tip in W, mm, for the programmed `position` (mm) at `angles` (degrees).
    pub(crate) fn tip_at(&self, coordinates: Coordinates, position: Vector3<f64>, angles: &Angles) -> Vector3<f64> {
        match coordinates {
            Coordinates::Head => self.tip_position(position, angles),
            Coordinates::Tip => position,
            Coordinates::Inclined(plane) => plane.transform(position),
        }
    }

    /// Returns the position to program, mm, for the `tip` in W (mm) at `angles` (degrees).
    pub(crate) fn programmed_position(
        &self,
        coordinates: Coordinates,
        tip: Vector3<f64>,
        angles: &Angles,
    ) -> Vector3<f64> {
        match coordinates {
            Coordinates::Head => self.head_position(tip, angles),
            Coordinates::Tip => tip,
            Coordinates::Inclined(plane) => plane.inverse().transform(tip),
        }
    }

    /// Returns the axes in W of the plane across the tool at `angles`, degrees. Which way its x points is certain where no axis is turned but
    /// one at a right angle to z; `None` otherwise.
    pub(crate) fn plane_across_tool(&self, angles: &Angles) -> Option<Matrix3<f64>> {
        let mut turned = self.axes.iter().filter(|axis| angles[axis_index(axis.letter)] != 0.0);
        let is_certain =
            turned.next().is_none_or(|axis| axis.about.z.abs() <= SAME_DIRECTION) && turned.next().is_none();
        let [table, head] = self.displacements(angles);
        is_certain.then(|| table.rotation.tr_mul(&head.rotation))
    }

    /// Returns the angles (degrees) that a control by the rule `choice` turns the axes to from `now`, so that the tool stands along `direction`, a
    /// unit vector in W. An axis that turns the tool about itself there stays. `Err` if there are none, or they depend on more than the rule. With
    /// [`AngleChoice::Given`] they are `now`, if they are within travel.
    pub(crate) fn chosen_angles(
        &self,
        direction: &Vector3<f64>,
        now: &Angles,
        choice: AngleChoice,
    ) -> Result<Angles, InclinedFault> {
        if choice == AngleChoice::Zero {
            return Ok([0.0; 3]);
        }
        if choice == AngleChoice::Given {
            let within = self.within_travel(*now, now).filter(|angles| is_same(angles, now));
            return within.ok_or(InclinedFault::NotReached);
        }
        let turns_table =
            matches!(choice, AngleChoice::Sign { turns_table: true, .. } | AngleChoice::Shorter { turns_table: true });
        let outermost = self.axes.iter().rfind(|axis| axis.turns == RotarySide::Workpiece);
        if turns_table && outermost.is_some_and(|axis| axis.about.cross(direction).norm() < SAME_DIRECTION.sqrt()) {
            return Err(InclinedFault::Form { expected: "no TABLE ROT where z of the plane is the axis of the table" });
        }
        let indices = |side: Option<RotarySide>| {
            let of_side = self.axes.iter().filter(move |axis| side.is_none_or(|side| axis.turns == side));
            of_side.map(|axis| axis_index(axis.letter))
        };
        let (tables, heads) = (indices(Some(RotarySide::Workpiece)), indices(Some(RotarySide::Tool)));
        let is_mixed = tables.clone().next().is_some() && heads.clone().next().is_some();
        let turned = |angles: &Angles, axis: usize| (angles[axis] - now[axis]).abs();
        let from_zero = |angles: &Angles, axis: usize| (angles[axis] - 360.0 * (angles[axis] / 360.0).round()).abs();
        let nearer = |a: f64, b: f64| if (a - b).abs() <= SAME_DEG { Ordering::Equal } else { a.total_cmp(&b) };
        // The axes in the order of the machine; of mixed ones those of the tool come first to Siemens, those of the table to Fanuc.
        let order: Vec<usize> = match choice {
            AngleChoice::Direction { .. } => heads.chain(tables).collect(),
            AngleChoice::Least if is_mixed => tables.chain(heads).collect(),
            AngleChoice::Sign { .. } | AngleChoice::Shorter { .. } => heads.rev().chain(tables).collect(),
            _ => indices(None).collect(),
        };
        let Some(&first) = order.first() else { return Err(InclinedFault::NoAxes) };
        let mut near = *now;
        // Within half a turn, the two pairs differ in sign; beyond it, each could have either.
        if matches!(choice, AngleChoice::Sign { .. }) && order.len() > 1 {
            near[first] = 0.0;
        }
        let mut solutions = self.angles_along(direction, &near)?;
        match choice {
            AngleChoice::Sign { is_positive, .. } => {
                solutions
                    .retain(|angles| if is_positive { angles[first] > -SAME_DEG } else { angles[first] < SAME_DEG });
            }
            AngleChoice::Direction { is_higher } => {
                let sign = if is_higher { -1.0 } else { 1.0 };
                solutions.sort_by(|a, b| nearer(sign * a[first], sign * b[first]));
            }
            AngleChoice::Shorter { .. } => solutions.sort_by(|a, b| {
                let way = |angles: &Angles| order.iter().map(|axis| turned(angles, *axis)).sum::<f64>();
                nearer(way(a), way(b)).then(nearer(b[first], a[first]))
            }),
            AngleChoice::Least | AngleChoice::Zero | AngleChoice::Given => solutions.sort_by(|a, b| {
                let by_turn = order.iter().map(|axis| nearer(turned(a, *axis), turned(b, *axis)));
                let by_angle = order.iter().map(|axis| nearer(from_zero(a, *axis), from_zero(b, *axis)));
                by_turn.chain(by_angle).fold(Ordering::Equal, Ordering::then)
            }),
        }
        solutions.first().copied().ok_or(InclinedFault::NotReached)
    }

    /// Returns the angles (degrees) within travel at which the tool stands along `direction`, a unit vector in W, each axis by the shortest way
    /// from `now`; two pairs at most.
    fn angles_along(&self, direction: &Vector3<f64>, now: &Angles) -> Result<Vec<Angles>, InclinedFault> {
        // From the workpiece through the machine to the tool.
        let of_side = |side| self.axes.iter().filter(move |axis| axis.turns == side);
        let tables = of_side(RotarySide::Workpiece).rev().map(|axis| (-axis.about, axis_index(axis.letter)));
        let heads = of_side(RotarySide::Tool).map(|axis| (axis.about, axis_index(axis.letter)));
        let turns: Vec<Turn> = tables.chain(heads).collect();
        let raw = match turns[..] {
            [] => return Err(InclinedFault::NoAxes),
            [outer] => turn_to(outer, &Vector3::z(), direction, now).into_iter().collect(),
            [outer, inner] => turns_to(outer, inner, direction, now),
            _ => return Err(InclinedFault::ThreeAxes),
        };
        let mut solutions: Vec<Angles> = Vec::new();
        for angles in raw.into_iter().filter_map(|angles| self.within_travel(angles, now)) {
            if !solutions.iter().any(|other| is_same(other, &angles)) {
                solutions.push(angles);
            }
        }
        Ok(solutions)
    }

    /// Returns `angles` by whole turns within the travel of each axis and nearest to `now`, degrees; `None` if an axis cannot go there.
    fn within_travel(&self, mut angles: Angles, now: &Angles) -> Option<Angles> {
        for axis in &self.axes {
            let index = axis_index(axis.letter);
            let at = angles[index];
            let nearest = at + 360.0 * ((now[index] - at) / 360.0).round();
            let is_within = |angle: &f64| {
                axis.travel_deg.is_none_or(|[low, high]| (low - SAME_DEG..=high + SAME_DEG).contains(angle))
            };
            let turns = [0.0, 1.0, -1.0, 2.0, -2.0].map(|turns| nearest + 360.0 * turns);
            let mut possible: Vec<f64> = turns.into_iter().filter(is_within).collect();
            possible.sort_by(|a, b| (a - now[index]).abs().total_cmp(&(b - now[index]).abs()));
            // Controls know fewer digits; what rounding left of 0 is none.
            angles[index] = (*possible.first()? * PER_DEG).round() / PER_DEG + 0.0;
        }
        Some(angles)
    }
}

/// Whether `a` and `b`, degrees, are the same but for rounding.
fn is_same(a: &Angles, b: &Angles) -> bool {
    (0..3).all(|axis| (a[axis] - b[axis]).abs() <= SAME_DEG)
}

/// Returns the angles with which `turn` brings `from` to `to`, unit vectors; `None` if it cannot. If both lie on its axis, it stays as it is `now`.
fn turn_to((about, axis): Turn, from: &Vector3<f64>, to: &Vector3<f64>, now: &Angles) -> Option<Angles> {
    if (about.dot(from) - about.dot(to)).abs() > SAME_DIRECTION {
        return None;
    }
    let (from, to) = (from - about * about.dot(from), to - about * about.dot(to));
    let mut angles = [0.0; 3];
    angles[axis] = match from.norm().min(to.norm()) > SAME_DIRECTION.sqrt() {
        true => libm::atan2(about.dot(&from.cross(&to)), from.dot(&to)).to_degrees(),
        false => now[axis],
    };
    Some(angles)
}

/// Returns the angles with which `inner` and then `outer` bring z to `direction`, a unit vector; two pairs at most.
fn turns_to(outer: Turn, inner: Turn, direction: &Vector3<f64>, now: &Angles) -> Vec<Angles> {
    let ((outer_axis, _), (about, index)) = (outer, inner);
    // outer · (R_inner z) = outer · direction: a cos + b sin + c = 0.
    let along = about * about.z;
    let (a, b) = (outer_axis.dot(&(Vector3::z() - along)), outer_axis.dot(&about.cross(&Vector3::z())));
    let c = outer_axis.dot(&(along - direction));
    let radius = libm::hypot(a, b);
    if radius <= SAME_DIRECTION {
        return Vec::new();
    }
    let share = -c / radius;
    if share.abs() > 1.0 + SAME_DIRECTION {
        return Vec::new();
    }
    let (middle, half) = (libm::atan2(b, a), libm::acos(share.clamp(-1.0, 1.0)));
    let pair = |angle: f64| {
        let turned = rotation_exp(about * angle) * Vector3::z();
        // Where the outer axis cannot bring it there exactly, the share was rounded.
        let level = direction + outer_axis * (outer_axis.dot(&turned) - outer_axis.dot(direction));
        let mut angles = turn_to(outer, &turned, &level, now)?;
        angles[index] = angle.to_degrees();
        Some(angles)
    };
    [middle + half, middle - half].into_iter().filter_map(pair).collect()
}
