//! How far the tool can be moved from home.

use nalgebra::Vector3;

use super::size;
use crate::machine::{Machine, Motion};

/// Length of the steps from home in which a direction is tried, as a share of the machine's size.
const STEP: f64 = 0.04;
/// Nothing is tried farther from home than this many sizes and what slides travel.
const FARTHEST: f64 = 4.0;
/// Where reach ends is found to this, mm.
const RESOLUTION_MM: f64 = 0.1;

/// How far P can go from home along an axis of O, mm: towards negative and towards positive coordinates.
pub type Span = [f64; 2];

/// Spans along x, y and z with the tool oriented as at home; `None` along an axis that the drives do not control. Infinite where
/// nothing ends it.
pub(super) fn spans(machine: &Machine) -> [Option<Span>; 3] {
    let along = |axis: usize| {
        let mut direction = Vector3::zeros();
        direction[axis] = 1.0;
        machine.controls_translation(axis).then(|| [-farthest(machine, -direction), farthest(machine, direction)])
    };
    [along(0), along(1), along(2)]
}

fn farthest(machine: &Machine, direction: Vector3<f64>) -> f64 {
    let home = machine.home.pose.translation;
    let is_reached = |distance: f64| machine.command(home + direction * distance).is_ok();
    let (step, farthest) = (STEP * size(machine), FARTHEST * size(machine) + travel(machine));
    let (mut near, mut far) = (0.0, step);
    while is_reached(far) {
        (near, far) = (far, far + step);
        if far > farthest {
            return f64::INFINITY;
        }
    }
    while far - near > RESOLUTION_MM {
        let middle = 0.5 * (near + far);
        if is_reached(middle) { near = middle } else { far = middle }
    }
    near
}

/// How far all slides travel together, mm.
fn travel(machine: &Machine) -> f64 {
    let slides = machine.drives().filter(|(_, drive)| drive.motion == Motion::Prismatic);
    slides.filter_map(|(_, drive)| drive.travel).map(|(least, largest)| largest - least).sum()
}
