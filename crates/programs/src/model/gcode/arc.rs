//! Circular and helical arcs: centre, sense and turns from the words of a block.

use std::f64::consts::TAU;

use nalgebra::Vector3;

use crate::model::{
    Plane, TurnDirection, direction,
    gcode::{ArcFault, LengthUnit},
};

/// The centre of an arc as the program gives it, mm, in the order of the plane's two axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Centre {
    /// From the start (G91.1).
    FromStart([f64; 2]),
    /// In the workpiece frame (G90.1).
    At([f64; 2]),
    /// In the workpiece frame, given by a line before it (Heidenhain's CC).
    Pole([f64; 2]),
    /// By the radius: positive for the shorter of the two arcs, negative for the longer.
    Radius(f64),
}

/// An arc in a plane, with a linear motion along the plane's normal.
///
/// At t from 0 to 1 it is at the angle α + t·σ from the plane's first axis, σ negative for G2, at the distance
/// r_0 + t (r_1 − r_0) from its centre. The two radii differ by what rounding in the program leaves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Arc {
    plane: Plane,
    centre: [f64; 2],
    radii: [f64; 2],
    start_angle_rad: f64,
    sweep_rad: f64,
    start: Vector3<f64>,
    end: Vector3<f64>,
}

/// Below this distance, mm, the ends of an arc are the same point and the arc a full circle.
pub(crate) const SAME_POINT_MM: f64 = 1e-9;

impl Arc {
    /// Creates the arc from `start` to `end`, mm in the workpiece frame.
    ///
    /// # Errors
    /// When no such arc exists. Radii may differ as LinuxCNC and the defaults of other controllers allow: by 0.005 mm (0.0005 inch in
    /// programs in inches), or by 0.1 % of the radius up to 0.5 mm (0.05 inch).
    pub fn new(
        plane: Plane,
        turn: TurnDirection,
        start: Vector3<f64>,
        end: Vector3<f64>,
        centre: Centre,
        unit: LengthUnit,
    ) -> Result<Arc, ArcFault> {
        let [first, second, _] = plane.axes();
        let from = [start[first], start[second]];
        let to = [end[first], end[second]];
        let centre = match centre {
            Centre::At(centre) | Centre::Pole(centre) => centre,
            Centre::FromStart(offset) => [from[0] + offset[0], from[1] + offset[1]],
            Centre::Radius(radius) => centre_by_radius(from, to, radius, turn)?,
        };
        let arm = |p: [f64; 2]| [p[0] - centre[0], p[1] - centre[1]];
        let radii = [arm(from), arm(to)].map(|[a, b]| libm::hypot(a, b));
        check_radii(radii, unit)?;
        let [start_angle_rad, end_angle_rad] = [arm(from), arm(to)].map(|[a, b]| libm::atan2(b, a));
        let full = libm::hypot(to[0] - from[0], to[1] - from[1]) < SAME_POINT_MM;
        let sweep_rad = signed_sweep_rad(if full { 0.0 } else { end_angle_rad - start_angle_rad }, turn);
        Ok(Arc { plane, centre, radii, start_angle_rad, sweep_rad, start, end })
    }

    /// Returns the position (mm in W) and the unit tangent at the share `t` (0 to 1) of the arc; exactly the programmed end at 1.
    pub fn at(&self, t: f64) -> (Vector3<f64>, Vector3<f64>) {
        let [first, second, normal] = self.plane.axes();
        let (sin, cos) = libm::sincos(self.start_angle_rad + t * self.sweep_rad);
        let widening = self.radii[1] - self.radii[0];
        let radius = self.radii[0] + t * widening;
        let rise = self.end[normal] - self.start[normal];
        let mut position = self.end;
        if t < 1.0 {
            position[first] = self.centre[0] + radius * cos;
            position[second] = self.centre[1] + radius * sin;
            position[normal] = self.start[normal] + t * rise;
        }
        let mut velocity = Vector3::zeros();
        velocity[first] = widening * cos - radius * self.sweep_rad * sin;
        velocity[second] = widening * sin + radius * self.sweep_rad * cos;
        velocity[normal] = rise;
        (position, direction(velocity))
    }

    /// Returns the length, mm, including the rise of a helix; exact where the radii are equal.
    pub fn length(&self) -> f64 {
        let rise = self.end[self.plane.axes()[2]] - self.start[self.plane.axes()[2]];
        let round = f64::midpoint(self.radii[0], self.radii[1]) * self.sweep_rad;
        libm::hypot(round, rise)
    }

    /// Returns the centre, mm, in the order of the plane's axes.
    pub fn centre(&self) -> [f64; 2] {
        self.centre
    }

    /// Returns the larger of the radii at start and end, mm.
    pub fn radius(&self) -> f64 {
        self.radii[0].max(self.radii[1])
    }

    /// Returns the signed angle from start to end of the arc, rad, negative for G2.
    pub fn sweep_rad(&self) -> f64 {
        self.sweep_rad
    }
}

/// Returns the signed angle from start to end, rad, in the direction `turn`, for angles that differ by `difference_rad`; a full turn for 0.
fn signed_sweep_rad(difference_rad: f64, turn: TurnDirection) -> f64 {
    let positive = difference_rad.rem_euclid(TAU);
    match turn {
        TurnDirection::CounterClockwise if positive > 0.0 => positive,
        TurnDirection::CounterClockwise => TAU,
        TurnDirection::Clockwise => positive - TAU,
    }
}

/// Checks that the radii (mm) at start and end are above 0 and differ by at most the rounding in `unit`, or 0.1 % up to 100 times that.
pub(crate) fn check_radii([start_mm, end_mm]: [f64; 2], unit: LengthUnit) -> Result<(), ArcFault> {
    if start_mm < SAME_POINT_MM {
        return Err(ArcFault::NoRadius);
    }
    let difference = (start_mm - end_mm).abs();
    let rounding_mm = match unit {
        LengthUnit::Millimetre => 0.005,
        LengthUnit::Inch => 0.0127,
    };
    if difference > 100.0 * rounding_mm || (difference > rounding_mm && difference > 1e-3 * start_mm) {
        return Err(ArcFault::Radii { start_mm, end_mm, rounding_mm });
    }
    Ok(())
}

/// Returns the centre of the arc of the signed `radius`, mm: on the bisector of the chord, at √(r² − (c/2)²) from its middle; to the left
/// of the motion for a short counter-clockwise arc. Fails if the radius is too small or the ends coincide.
pub(crate) fn centre_by_radius(
    from: [f64; 2],
    to: [f64; 2],
    radius: f64,
    turn: TurnDirection,
) -> Result<[f64; 2], ArcFault> {
    let chord = [to[0] - from[0], to[1] - from[1]];
    let chord_mm = libm::hypot(chord[0], chord[1]);
    if chord_mm < SAME_POINT_MM {
        return Err(ArcFault::NoChord);
    }
    let half = chord_mm / 2.0;
    if radius.abs() + 0.0025 < half {
        return Err(ArcFault::TooShort { radius_mm: radius.abs(), chord_mm });
    }
    let height = (radius * radius - half * half).max(0.0).sqrt();
    let left = (turn == TurnDirection::CounterClockwise) == (radius > 0.0);
    let side = if left { height } else { -height } / chord_mm;
    Ok([f64::midpoint(from[0], to[0]) - side * chord[1], f64::midpoint(from[1], to[1]) + side * chord[0]])
}
