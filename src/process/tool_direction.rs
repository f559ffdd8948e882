//! How the tool stands in a program that does not say it: along the normal of its plane, or the machine is set up for another program.

use nalgebra::Vector3;

use super::file::Process;
use crate::{
    input::error::{Error, Result},
    toolpath::gcode::GcodeProgram,
};

/// A tool that leans by more is nearer to the normal of another plane, degrees.
const MAX_DEG: f64 = 45.0;
/// A direction that is given is that of the machine to this angle, degrees.
const GIVEN_DEG: f64 = 1.0;

/// Checks that the tool of the machine stands along a direction that `program`, called `name`, can mean where its A, B and C are 0 or nothing: the
/// normal of the plane of its feed moves, in whichever sense, or what `[gcode]` says.
///
/// # Errors
/// A stationary tool otherwise.
pub(super) fn check(program: &GcodeProgram, process: &Process, name: &str) -> Result<()> {
    let Some(axis) = tool_axis(program, process) else { return Ok(()) };
    let [x, y, z]: [f64; 3] = axis.map(|v| (v * 1e4).round() / 1e4 + 0.0).into();
    let machine = &process.machine.name;
    if let Some(given) = process.gcode.tool_axis {
        let apart = given.angle(&axis).to_degrees();
        let problem = format!(
            "stands along gcode.tool_axis, and the tool of machine {machine}, from its tip to the spindle, along ({x}, {y}, {z}) of W, {apart:.1} \
             degrees from it: expected the same direction"
        );
        return if apart <= GIVEN_DEG { Ok(()) } else { Err(Error::argument(name, problem)) };
    }
    let normals = normals(program.notes().feed_normals);
    let lean = |normal: &usize| libm::acos(axis[*normal].abs().min(1.0)).to_degrees();
    let least = normals.iter().map(lean).fold(f64::INFINITY, f64::min);
    if least <= MAX_DEG {
        return Ok(());
    }
    let meant =
        normals.iter().map(|normal| ["x (G19)", "y (G18)", "z (G17)"][*normal]).collect::<Vec<_>>().join(" or ");
    let problem = format!(
        "is for a tool along {meant} of W, and the tool of machine {machine}, from its tip to the spindle, stands along ({x}, {y}, {z}) there, \
         {least:.1} degrees from it: expected another home or platform.tool_axis of the machine, or tool_axis = [{x:?}, {y:?}, {z:?}] in [gcode] \
         of the process if the tool is to cut so"
    );
    Err(Error::argument(name, problem))
}

/// Returns the axes of W along which the tool may stand for feed moves in planes with these normals: z if any is in G17, and z as well where
/// all are in one other, since mills with an upright spindle cut such arcs, too.
fn normals(feed: [bool; 3]) -> Vec<usize> {
    let others = (0..2).filter(|normal| feed[*normal] && !feed[2]);
    others.chain([2]).collect()
}

/// Returns the direction of the tool from its tip to the spindle in W, a unit vector, with all rotary drives that the program commands at 0; `None` where
/// it says how the tool stands.
fn tool_axis(program: &GcodeProgram, process: &Process) -> Option<Vector3<f64>> {
    let Process { machine, placement, .. } = process;
    let placed = match program.commanded_rotary() {
        [] if program.has_orientations() => return None,
        // Drives that could be any of several are refused with the path.
        [] => placement.place(machine.with_resting_drives(false).as_ref().unwrap_or(machine)),
        _ => {
            let rotary = machine.rotary_drives();
            let placed = placement.on_machine(&rotary.platform.rotation, &machine.tool());
            let placed = match rotary.drives.iter().any(|drive| !drive.carries) {
                true => placed.with_platform_rotation(&rotary.platform.rotation),
                false => placed,
            };
            placed.on_carrier(&rotary.carrier)
        }
    };
    Some(-placed.tool_axes().column(2).into_owned())
}
