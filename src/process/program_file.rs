//! Programs in files of any format: reads and follows them.

use std::path::Path;

#[cfg(not(target_family = "wasm"))]
use crate::toolpath::{
    NumberFormat, PathPoint,
    robot::{Language, RobotProgram},
};
use crate::{
    input::{
        Folder, Inputs,
        error::{Error, Result},
    },
    process::file::Process,
    toolpath::{
        Sampling, Toolpath,
        gcode::{Expand, Program, SiblingFiles},
        polyline::Polyline,
    },
};

/// A program as it was read.
#[derive(Debug, Clone)]
pub enum ProgramFile {
    /// Points in a CSV file.
    Polyline(Box<Polyline>),
    /// A G-code program.
    Gcode(Box<Program>),
    /// A program of a robot, or an APT program. Pages get it as points.
    #[cfg(not(target_family = "wasm"))]
    Robot(Box<RobotProgram>),
}

impl ProgramFile {
    /// Reads `file`: a polyline if its name ends in `.csv`, a robot or APT program if [`Language::detect`] knows it, else G-code, written
    /// out first where `process` says so. Called files, and the `.dat` of a `.src`, are sought beside it.
    ///
    /// # Errors
    /// A file that cannot be read or is not of the expected form.
    pub fn read(file: &Path, process: &Process) -> Result<Self> {
        let name = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
        match file.parent() {
            Some(folder) if file.ends_with(&name) => Self::in_folder(&Folder::from(folder), &name, process),
            _ => Self::parse(crate::input::file::read(file)?, file, process),
        }
    }

    /// Reads the file called `name` in `folder`, as [`ProgramFile::read`].
    ///
    /// # Errors
    /// As [`ProgramFile::read`].
    pub fn in_folder(folder: &Folder, name: &str, process: &Process) -> Result<Self> {
        let around = folder.of(name);
        // Other folders are no part of what pages are made of.
        let outside = around.unrecorded();
        let beside = |name: &str| {
            let folder = if name.starts_with("..") { &outside } else { &around };
            folder.has_file(name).then(|| folder.bytes(name).ok()).flatten()
        };
        let program = Self::parse_beside(folder.bytes(name)?, &folder.path(name), process, &beside)?;
        // Pages get it as it was written out.
        if let Some(written_out) = program.written_out() {
            folder.record(name, written_out);
        }
        #[cfg(not(target_family = "wasm"))]
        if folder.is_recording() && program.is_kept_as_points(process) {
            folder.record(name, &points_as_csv(&program, process)?);
        }
        Ok(program)
    }

    /// Reads the program `bytes` of a `file` without other files beside it, as [`ProgramFile::read`].
    ///
    /// # Errors
    /// Bytes that are not of the expected form.
    pub fn parse(bytes: Vec<u8>, file: &Path, process: &Process) -> Result<Self> {
        Self::parse_beside(bytes, file, process, &|_| None)
    }

    /// Reads the program `bytes` of a `file`; `beside` gives the bytes of files beside it.
    fn parse_beside(bytes: Vec<u8>, file: &Path, process: &Process, beside: &SiblingFiles<'_>) -> Result<Self> {
        let (name, options) = (file.display().to_string(), &process.gcode);
        if is_csv(file) || bytes.starts_with(POINTS) {
            return Ok(ProgramFile::Polyline(Box::new(Polyline::read(bytes, &name)?)));
        }
        #[cfg(not(target_family = "wasm"))]
        if let Some(language) = Language::detect(file, &bytes) {
            if process.tool_stands.is_some() && language != Language::Rapid {
                let problem = "is not followed with a tool that stands ([tool] of the process): expected RAPID";
                let problem = format!("{} {problem}", language.name());
                return Err(Error::argument(name, problem));
            }
            let data = Self::dat_file_name(&file.file_name().unwrap_or_default().to_string_lossy());
            // Each is sought by these names, the first of which is taken.
            let sought = match language {
                Language::Krl => vec![vec![data], config_names()],
                Language::Ls => vec![vec!["sysframe.va".to_owned(), "SYSFRAME.VA".to_owned()]],
                _ => Vec::new(),
            };
            let find = |names: Vec<String>| names.into_iter().find_map(|name| Some((beside(&name)?, name)));
            let found = sought.into_iter().filter_map(find).map(|(bytes, name)| (name, bytes));
            let program = robot_program(bytes, &name, language, found.collect(), process)?;
            check_tool(&program, process)?;
            check_arm(&program, process)?;
            return Ok(ProgramFile::Robot(Box::new(program)));
        }
        // What pages have was written out before.
        let expand = if cfg!(target_family = "wasm") { Expand::Never } else { options.expand };
        let program = match expand {
            Expand::Never => Program::parse(bytes, &name, options),
            Expand::Always => Program::parse_expanded(bytes, &name, options, beside),
            Expand::WhereNeeded => Program::parse_or_give_back(bytes, &name, options).or_else(|given_back| {
                let (refused, bytes) = *given_back;
                if !refused.fault.is_solved_by_expansion() {
                    return Err(refused);
                }
                Program::parse_with_calls(bytes, &name, options, beside)
            }),
        };
        let program = program?;
        super::tool_direction::check(&program, process, &name)?;
        Ok(ProgramFile::Gcode(Box::new(program)))
    }

    /// Returns whether pages, which cannot follow the program, get its points instead; these contain all that matters.
    #[cfg(not(target_family = "wasm"))]
    fn is_kept_as_points(&self, process: &Process) -> bool {
        match self {
            ProgramFile::Polyline(_) => false,
            ProgramFile::Gcode(program) => {
                program.has_orientations() && !process.gcode.rotary.is_empty() && process.own_forces.is_empty()
            }
            ProgramFile::Robot(_) => true,
        }
    }

    /// Returns the inputs on which results depend: the file called `name`, the written-out program, and files beside it.
    pub fn inputs(&self, name: &str) -> Inputs {
        let bytes = match self {
            ProgramFile::Polyline(polyline) => polyline.source(),
            ProgramFile::Gcode(program) => program.file_bytes(),
            #[cfg(not(target_family = "wasm"))]
            ProgramFile::Robot(program) => program.file_bytes(),
        };
        let texts = [(name, Some(bytes)), (name, self.written_out())];
        let texts = texts.into_iter().filter_map(|(name, bytes)| Some((name, bytes?))).chain(self.files_beside());
        let inputs = texts.map(|(name, bytes)| Inputs::of(name, String::from_utf8_lossy(bytes)));
        inputs.fold(Inputs::default(), Inputs::and)
    }

    /// Returns the written-out program, if it was written out.
    fn written_out(&self) -> Option<&[u8]> {
        match self {
            ProgramFile::Gcode(program) if program.notes().written_out.is_some() => Some(program.source()),
            _ => None,
        }
    }

    /// Returns the name of the `.dat` beside the KRL program called `name`.
    pub(crate) fn dat_file_name(name: &str) -> String {
        Path::new(name).with_extension("dat").to_string_lossy().into_owned()
    }

    /// Returns names and bytes of the files beside a robot program from which it has points and frames.
    fn files_beside(&self) -> Vec<(&str, &[u8])> {
        match self {
            #[cfg(not(target_family = "wasm"))]
            ProgramFile::Robot(program) => program.beside().collect(),
            _ => Vec::new(),
        }
    }

    /// Returns its path in the workpiece frame; lines and arcs are split as `sampling` says.
    ///
    /// # Errors
    /// Too many points, or a program that cannot be followed.
    pub fn toolpath(&self, sampling: Sampling) -> Result<Toolpath> {
        match self {
            ProgramFile::Polyline(polyline) => Ok(polyline.sampled(sampling)?),
            ProgramFile::Gcode(program) => Ok(program.toolpath(sampling)?),
            #[cfg(not(target_family = "wasm"))]
            ProgramFile::Robot(program) => Ok(program.toolpath(sampling)?),
        }
    }

    /// Returns its path like [`ProgramFile::toolpath`], with up to [`Program::MAX_POINTS`] points.
    ///
    /// # Errors
    /// As [`ProgramFile::toolpath`].
    pub fn long_toolpath(&self, sampling: Sampling) -> Result<Toolpath> {
        match self {
            ProgramFile::Polyline(_) => self.toolpath(sampling),
            ProgramFile::Gcode(program) => Ok(program.toolpath_up_to(sampling, Program::MAX_POINTS)?),
            #[cfg(not(target_family = "wasm"))]
            ProgramFile::Robot(program) => Ok(program.toolpath_up_to(sampling, Program::MAX_POINTS)?),
        }
    }

    /// Returns the line of the file, from 1, with the move number `segment`, where it is known.
    pub fn line_of(&self, segment: usize) -> Option<usize> {
        match self {
            ProgramFile::Polyline(polyline) => polyline.line_of(segment),
            ProgramFile::Gcode(program) => program.line_of(segment),
            #[cfg(not(target_family = "wasm"))]
            ProgramFile::Robot(program) => program.line_of(segment),
        }
    }

    /// Returns the number of the file with this move: 0 for the program itself, then the [`ProgramFile::called_files`].
    pub fn file_of(&self, segment: usize) -> usize {
        match self {
            ProgramFile::Polyline(_) => 0,
            ProgramFile::Gcode(program) => program.file_of(segment),
            #[cfg(not(target_family = "wasm"))]
            ProgramFile::Robot(_) => 0,
        }
    }

    /// Returns the names of the files beside the program that it calls.
    pub fn called_files(&self) -> Vec<String> {
        match self {
            ProgramFile::Polyline(_) => Vec::new(),
            ProgramFile::Gcode(program) => program.called_files().map(String::from).collect(),
            #[cfg(not(target_family = "wasm"))]
            ProgramFile::Robot(_) => Vec::new(),
        }
    }

    /// Returns the line of a move in words: "line 7", or "O100.nc line 7" of a called file.
    pub fn line_name(&self, segment: usize) -> Option<String> {
        let line = self.line_of(segment)?;
        Some(line_in_words(&self.called_files(), self.file_of(segment), line))
    }

    /// Returns whether a move is a hole of a drilling cycle.
    pub fn is_hole(&self, segment: usize) -> bool {
        match self {
            ProgramFile::Polyline(_) => false,
            ProgramFile::Gcode(program) => program.is_hole(segment),
            #[cfg(not(target_family = "wasm"))]
            ProgramFile::Robot(program) => program.is_hole(segment),
        }
    }

    /// Returns whether it says how the arm stands at its points, and that is followed.
    pub fn says_postures(&self) -> bool {
        match self {
            #[cfg(not(target_family = "wasm"))]
            ProgramFile::Robot(program) => program.says_postures(),
            _ => false,
        }
    }

    /// Returns the text of the line of a move; bytes that are not UTF-8 are replaced.
    pub fn line_text(&self, segment: usize) -> Option<String> {
        let bytes = match self {
            ProgramFile::Polyline(polyline) => polyline.content_of(segment)?,
            ProgramFile::Gcode(program) => program.content_of(segment)?,
            #[cfg(not(target_family = "wasm"))]
            ProgramFile::Robot(program) => program.content_of(segment)?,
        };
        Some(String::from_utf8_lossy(bytes).trim().to_string())
    }
}

/// Returns line `line` of file number `file` in words; `called` are the called files.
pub(crate) fn line_in_words(called: &[String], file: usize, line: usize) -> String {
    match file.checked_sub(1).and_then(|file| called.get(file)) {
        Some(file) => format!("{file} line {line}"),
        None => format!("line {line}"),
    }
}

/// Returns whether the name of `file` ends in `.csv`.
fn is_csv(file: &Path) -> bool {
    file.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("csv"))
}

/// Reads a program of a robot: written out first where `process` says so, or where it cannot be read otherwise.
#[cfg(not(target_family = "wasm"))]
fn robot_program(
    bytes: Vec<u8>,
    name: &str,
    language: Language,
    beside: Vec<(String, Vec<u8>)>,
    process: &Process,
) -> Result<RobotProgram> {
    let options = &process.robot_program;
    match (language, process.gcode.expand) {
        (Language::Rapid | Language::Krl, Expand::Always) => {
            Ok(RobotProgram::parse_expanded(bytes, name, language, beside, options, false)?)
        }
        (Language::Rapid | Language::Krl, Expand::WhereNeeded) => {
            match RobotProgram::parse(bytes.clone(), name, language, beside.clone(), options) {
                Err(refused) if refused.fault.is_solved_by_expansion() => {
                    Ok(RobotProgram::parse_expanded(bytes, name, language, beside, options, true)?)
                }
                read => Ok(read?),
            }
        }
        _ => Ok(RobotProgram::parse(bytes, name, language, beside, options)?),
    }
}

/// Returns the names of the file with the tools and bases of all KRL programs: beside the program, or where a backup has it, which holds the
/// programs in R1/Program and the folders in it.
#[cfg(not(target_family = "wasm"))]
fn config_names() -> Vec<String> {
    let above = (1..=DEEPEST_PROGRAM).map(|depth| format!("{}System/$config.dat", "../".repeat(depth)));
    ["$config.dat", "$CONFIG.DAT"].map(str::to_owned).into_iter().chain(above).collect()
}

/// Most folders between R1 of a backup and a program.
#[cfg(not(target_family = "wasm"))]
const DEEPEST_PROGRAM: usize = 4;

/// First bytes of the points that stand for a robot program in pages.
const POINTS: &[u8] = b"x_mm,y_mm,z_mm";

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

/// Returns the points of a program's path as a polyline file.
#[cfg(not(target_family = "wasm"))]
fn points_as_csv(program: &ProgramFile, process: &Process) -> Result<Vec<u8>> {
    let path = program.toolpath(process.sampling)?;
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
