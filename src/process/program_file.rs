//! Programs in files, read as a process says, and checked for its machine.

use std::path::Path;

#[cfg(not(target_family = "wasm"))]
use crate::{
    input::error::Error,
    toolpath::{
        NumberFormat, PathPoint, Toolpath,
        robot::{Language, RobotProgram},
    },
};
use crate::{
    input::{Folder, Inputs, error::Result},
    process::file::Process,
    toolpath::{ProgramFile, ProgramOptions, gcode::SiblingFiles},
};

impl Process {
    /// Reads the program in `file` as [`ProgramFile::parse`] does. Called files, and the `.dat` of a `.src`, are sought beside it.
    ///
    /// # Errors
    /// A file that cannot be read, is not of the expected form, or does not fit the machine.
    pub fn read_program(&self, file: &Path) -> Result<ProgramFile> {
        let name = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
        match file.parent() {
            Some(folder) if file.ends_with(&name) => self.program_in_folder(&Folder::from(folder), &name),
            _ => self.parse_program(crate::input::file::read(file)?, file),
        }
    }

    /// Reads the program called `name` in `folder`, as [`Process::read_program`].
    ///
    /// # Errors
    /// As there.
    pub fn program_in_folder(&self, folder: &Folder, name: &str) -> Result<ProgramFile> {
        let around = folder.of(name);
        // Other folders are no part of what pages are made of.
        let outside = around.unrecorded();
        let beside = |name: &str| {
            let folder = if name.starts_with("..") { &outside } else { &around };
            folder.has_file(name).then(|| folder.bytes(name).ok()).flatten()
        };
        let program = self.parse_beside(folder.bytes(name)?, &folder.path(name), &beside)?;
        // Pages get it as it was written out.
        if let Some(written_out) = program.written_out() {
            folder.record(name, written_out);
        }
        #[cfg(not(target_family = "wasm"))]
        if folder.is_recording() && self.is_kept_as_points(&program) {
            folder.record(name, &self.points_as_csv(&program)?);
        }
        Ok(program)
    }

    /// Reads the program `bytes` of a `file` without other files beside it, as [`Process::read_program`].
    ///
    /// # Errors
    /// As there.
    pub fn parse_program(&self, bytes: Vec<u8>, file: &Path) -> Result<ProgramFile> {
        self.parse_beside(bytes, file, &|_| None)
    }

    /// Reads the program `bytes` of a `file`; `beside` gives the bytes of files beside it.
    fn parse_beside(&self, bytes: Vec<u8>, file: &Path, beside: &SiblingFiles<'_>) -> Result<ProgramFile> {
        let options = ProgramOptions {
            gcode: self.gcode.clone(),
            #[cfg(not(target_family = "wasm"))]
            robot: self.robot_program.clone(),
        };
        let program = ProgramFile::parse(bytes, file, &options, beside)?;
        match &program {
            ProgramFile::Polyline(_) => {}
            ProgramFile::Gcode(program) => super::tool_direction::check(program, self, &file.display().to_string())?,
            #[cfg(not(target_family = "wasm"))]
            ProgramFile::Robot(program) => {
                check_tool(program, self)?;
                check_arm(program, self)?;
            }
        }
        Ok(program)
    }

    /// Returns whether pages, which cannot follow `program`, get its points instead; these contain all that matters.
    #[cfg(not(target_family = "wasm"))]
    fn is_kept_as_points(&self, program: &ProgramFile) -> bool {
        match program {
            ProgramFile::Polyline(_) => false,
            ProgramFile::Gcode(program) => {
                program.has_orientations() && !self.gcode.rotary.is_empty() && self.own_forces.is_empty()
            }
            ProgramFile::Robot(_) => true,
        }
    }

    /// Returns the points of a program's path as a polyline file.
    #[cfg(not(target_family = "wasm"))]
    fn points_as_csv(&self, program: &ProgramFile) -> Result<Vec<u8>> {
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

/// Returns the inputs on which results depend that are computed from `program`, read from the file called `name`.
pub fn program_inputs(program: &ProgramFile, name: &str) -> Inputs {
    let inputs = program.texts(name).map(|(name, bytes)| Inputs::of(name, String::from_utf8_lossy(bytes)));
    inputs.fold(Inputs::default(), Inputs::and)
}

/// Largest difference between equal tool tips, mm.
#[cfg(not(target_family = "wasm"))]
const SAME_TIP_MM: f64 = 0.01;

/// Checks that a tool that `program` defines is that of the machine.
#[cfg(not(target_family = "wasm"))]
fn check_tool(program: &RobotProgram, process: &Process) -> Result<()> {
    let refuse = |problem: String| Err(Error::argument(program.name(), problem));
    let stands = process.tool_stands.as_ref().map(|(tip, _)| *tip);
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
#[cfg(not(target_family = "wasm"))]
fn check_arm(program: &RobotProgram, process: &Process) -> Result<()> {
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
