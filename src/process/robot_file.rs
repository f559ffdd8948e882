//! Programs of robots, checked for the machine, and those of any control as points, for pages, which follow neither.

use crate::{
    input::error::{Error, Result},
    process::file::Process,
    toolpath::{
        NumberFormat, PathPoint, ProgramFile, Toolpath,
        robot::{Language, RobotProgram},
    },
};

impl Process {
    /// Returns whether pages, which cannot follow `program`, get its points instead; these contain all that matters.
    pub(super) fn is_kept_as_points(&self, program: &ProgramFile) -> bool {
        match program {
            ProgramFile::Polyline(_) => false,
            ProgramFile::Gcode(program) => {
                program.has_orientations() && !self.gcode.rotary.is_empty() && self.own_forces.is_empty()
            }
            ProgramFile::Robot(_) => true,
        }
    }

    /// Returns the points of a program's path as a polyline file.
    pub(super) fn points_as_csv(&self, program: &ProgramFile) -> Result<Vec<u8>> {
        let path = program.toolpath(self.sampling)?;
        let decimals = NumberFormat::new(NumberFormat::MAX_DECIMALS, NumberFormat::default().inch_decimals())?;
        // A column is there if all points have it; where nothing is cut, the feed does not matter.
        let feed = path.points().iter().find_map(|point| point.feed_mm_per_min);
        let with_feed = path.points().iter().map(|point| PathPoint {
            feed_mm_per_min: point.feed_mm_per_min.or(feed.filter(|_| !point.cutting)),
            ..*point
        });
        let path = Toolpath::assemble(with_feed.collect()).with_external_axes(path.external_axes());
        Ok(crate::toolpath::polyline::write(&path, &path.positions_mm(), decimals)?)
    }
}

/// Largest difference between equal tool tips, mm.
const SAME_TIP_MM: f64 = 0.01;

/// Checks that a tool that `program` defines is that of the machine.
pub(super) fn check_tool(program: &RobotProgram, process: &Process) -> Result<()> {
    let refuse = |problem: String| Err(Error::argument(program.name(), problem));
    let stands = process.stationary_tip.as_ref().map(|(tip, _)| *tip);
    let placed = process.placement.origin_mm.norm() + process.placement.roll_pitch_yaw.norm();
    if stands.is_some() && placed > 0.0 {
        let problem = "says itself where the part is, which the robot holds: expected placement.origin_mm = [0.0, 0.0, 0.0] and no angles";
        return refuse(problem.into());
    }
    let Some((tool, tip)) = &program.notes().tool_tip_mm else { return Ok(()) };
    let own = stands.unwrap_or(process.machine.tool_tip);
    if (tip - own).amax() <= SAME_TIP_MM {
        return Ok(());
    }
    let [[x, y, z], [u, v, w]] = [<[f64; 3]>::from(*tip), own.into()];
    let problem = format!(
        "tool {tool} has its tip at ({x}, {y}, {z}) mm of the {}, machine {} at ({u}, {v}, {w}) mm (platform.tool_tip_mm, or \
         tip_mm of [tool] in the process): expected the same",
        if stands.is_some() { "base" } else { "flange" },
        process.machine.name
    );
    refuse(problem)
}

/// Checks that what `program` says of the posture of the arm is known for that of the machine.
pub(super) fn check_arm(program: &RobotProgram, process: &Process) -> Result<()> {
    let (machine, notes) = (&process.machine, program.notes());
    let is_other = machine.arm_angles(&machine.home).is_some() && machine.branch_of(&machine.home).is_none();
    let Some(line) = notes.configured_line.filter(|_| is_other && program.says_postures()) else {
        return Ok(());
    };
    if program.language() == Language::UrScript {
        return Ok(());
    }
    let problem = format!(
        "line {line} says how the arm stands, and what that means is known of arms whose axes 4 to 6 meet in a point, not of {}: expected \
         such a machine, or ignore_configuration = true in [robot_program] of the process",
        machine.name
    );
    Err(Error::argument(program.name(), problem))
}
