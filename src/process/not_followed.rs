//! Checks that a machine can give its tool the orientations of a path.

use nalgebra::Vector3;

use crate::{
    machine::{Coordinate, Machine},
    process::Placement,
    spatial::rotation_log,
    toolpath::{Orientation, PathPoint, Toolpath},
};

/// Rotations that differ by less are the same, rad: programs give angles with so many digits.
const SAME_TURN: f64 = 1e-5;

/// Returns the first point of `path`, placed by `placement`, whose tool orientation `machine` cannot reach, and why; `None` if there is none.
pub(super) fn first_unreachable<'a>(
    machine: &Machine,
    placement: &Placement,
    path: &'a Toolpath,
) -> Option<(&'a PathPoint, String)> {
    let home = &machine.home.pose.rotation;
    let placed = placement.on_machine(home, &machine.tool());
    let placed = machine.carrier.as_ref().map_or(placed, |carrier| placed.on_carrier(&carrier.home.pose));
    path.points().iter().find_map(|point| {
        let orientation = point.orientation?;
        // In axes of the platform, as the coordinates of the drives are.
        let turn = rotation_log(&(home.transpose() * placed.with_tool_orientation(&orientation).orientation()));
        let controls = |axis: usize| machine.controls.contains(&Coordinate::Rotation(axis));
        let mut missing = Vector3::from_fn(|axis, _| if controls(axis) { 0.0 } else { turn[axis] });
        if let Orientation::ToolAxis(_) = orientation {
            let free = machine.tool_axes.column(2);
            missing -= free * free.dot(&missing);
        }
        (missing.norm() > SAME_TURN).then(|| (point, describe_unreachable(machine, &orientation, turn.norm())))
    })
}

/// Describes an orientation, rotated from that at home by `turn_rad` (rad), that the machine's controlled rotations cannot reach.
fn describe_unreachable(machine: &Machine, orientation: &Orientation, turn_rad: f64) -> String {
    let rotations = machine.controls.iter().filter(|c| matches!(c, Coordinate::Rotation(_))).map(|c| c.name());
    let controlled = rotations.collect::<Vec<_>>().join(", ");
    let degrees = (turn_rad.to_degrees() * 1e3).round() / 1e3;
    let (what, name) = (
        match orientation {
            Orientation::ToolAxis(_) => "tool",
            Orientation::Platform(_) => "platform",
        },
        &machine.name,
    );
    match controlled.is_empty() {
        true => format!(
            "turns the {what} by {degrees} degrees from where it stands at home, and machine {name} controls no rotation: expected a \
             path whose tool keeps its direction"
        ),
        false => format!(
            "turns the {what} by {degrees} degrees from where it stands at home in a way that machine {name} does not control: its \
             drives control {controlled}"
        ),
    }
}
