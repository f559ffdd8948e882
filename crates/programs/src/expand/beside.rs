//! How the centre of a cutter passes the corners of a contour, and whether it keeps the way of each of its elements.

use crate::{
    expand::geometry::{Element, Point, sweep},
    model::{TurnDirection, gcode::RadiusFault},
};

/// Lines and arcs that meet at less than this angle have no corner, rad.
const SMOOTH_RAD: f64 = 1e-6;
/// Elements that turn back by less have no side on which the cutter goes round, rad.
const BACK_RAD: f64 = 1e-3;
/// At outer corners the parallels are prolonged where that leaves the cutter nearer to its radius than this, mm.
const MITRE_MM: f64 = 1e-4;
/// Corners at which the centre is moved by less are none: posts round what is tangential, mm.
const SMALL_MM: f64 = 1e-3;

/// A corner between two elements of a contour.
pub(crate) struct Corner {
    /// Where the centre is at the end of the first and the start of the second.
    pub points: [Point; 2],
    /// Sense of the arc from one to the other.
    pub turn: Option<TurnDirection>,
}

/// Returns how the centre passes the corner between two elements, of which some are rapid.
pub(crate) fn corner([a, b]: [&Element; 2], is_rapid: [bool; 2], distance: f64) -> Result<Corner, RadiusFault> {
    let (end, start) = (a.beside(true, distance), b.beside(false, distance));
    let at_once = |point: Point| Ok(Corner { points: [point; 2], turn: None });
    match is_rapid {
        [true, false] => return at_once(start),
        [_, true] => return at_once(end),
        _ => {}
    }
    let angle = a.turn_to(b);
    if angle.abs() < SMOOTH_RAD || distance == 0.0 {
        return at_once(start);
    }
    let meeting = a.meeting(b, distance);
    let reach = |p: &Point| libm::hypot(p[0] - a.to[0], p[1] - a.to[1]) - distance.abs();
    let gap = libm::hypot(end[0] - start[0], end[1] - start[1]);
    let rounding = SMALL_MM + a.radius_mismatch() + b.radius_mismatch();
    if gap < rounding && angle.abs() < 1.0 {
        return at_once(meeting.filter(|point| reach(point).abs() < rounding).unwrap_or(start));
    }
    if std::f64::consts::PI - angle.abs() < BACK_RAD {
        return Err(RadiusFault::TurnsBack);
    }
    if angle * distance > 0.0 {
        // Where rounding has moved the radius of an arc, parallels of what is nearly tangential may miss one another.
        let is_slight = distance.abs() * (1.0 - libm::cos(angle)) < SMALL_MM;
        let between = || {
            let half = libm::cos(angle / 2.0) * libm::cos(angle / 2.0);
            [0, 1].map(|axis| a.to[axis] + (f64::midpoint(end[axis], start[axis]) - a.to[axis]) / half)
        };
        return at_once(meeting.or_else(|| is_slight.then(between)).ok_or(RadiusFault::Narrow)?);
    }
    if let Some(point) = meeting.filter(|point| reach(point).abs() < MITRE_MM) {
        return at_once(point);
    }
    let turn = if angle > 0.0 { TurnDirection::CounterClockwise } else { TurnDirection::Clockwise };
    Ok(Corner { points: [end, start], turn: Some(turn) })
}

/// Smallest radius of an offset arc, mm: below it the arc has vanished.
const MIN_OFFSET_RADIUS_MM: f64 = 1e-6;

/// Whether the offset of `element` by `distance` (mm, positive to its left) between its corners `from` and `to` (mm) leads the same way as the element: not where
/// the offset of a concave arc or of a short line is turned round.
pub(crate) fn offset_keeps_direction(element: &Element, [from, to]: [Point; 2], distance: f64) -> bool {
    match element.arc {
        None => {
            let [x, y] = element.tangent(true);
            (to[0] - from[0]) * x + (to[1] - from[1]) * y > 0.0
        }
        Some(about) => {
            if element.parallel_radius(about, distance) < MIN_OFFSET_RADIUS_MM {
                return false;
            }
            // By how much the ends are moved along the arc.
            let moved = |p: Point, q: Point| {
                let [a, b] = [p, q].map(|p| libm::atan2(p[1] - about.0[1], p[0] - about.0[0]));
                let sense = if about.1 == TurnDirection::CounterClockwise { 1.0 } else { -1.0 };
                libm::remainder((b - a) * sense, std::f64::consts::TAU)
            };
            let [trimmed, extended] = [moved(element.from, from), moved(element.to, to)];
            let length = sweep(element.from, element.to, about.0, about.1).abs();
            length + extended - trimmed > 0.0 && trimmed < length && -extended < length
        }
    }
}
