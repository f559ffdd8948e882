//! Programs in files of any format: read and followed.

use std::path::Path;

#[cfg(not(target_family = "wasm"))]
use kinetostat_input::error::Error;
use kinetostat_input::error::Result;

#[cfg(not(target_family = "wasm"))]
use crate::robot::{Language, RobotOptions, RobotProgram};
use crate::{
    NumberFormat, Sampling, Toolpath,
    gcode::{Expand, GcodeOptions, GcodeProgram, SiblingFiles},
    polyline::Polyline,
};

/// What programs do not say themselves.
#[derive(Debug, Clone, Default)]
pub struct ProgramOptions {
    /// What a G-code program does not say; its [`Expand`] is that of robot programs as well.
    pub gcode: GcodeOptions,
    /// What a program of a robot or an APT program does not say.
    #[cfg(not(target_family = "wasm"))]
    pub robot: RobotOptions,
}

/// A program as it was read.
#[derive(Debug, Clone)]
pub enum ProgramFile {
    /// Points in a CSV file.
    Polyline(Box<Polyline>),
    /// A G-code program.
    Gcode(Box<GcodeProgram>),
    /// A program of a robot, or an APT program. Pages get it as points.
    #[cfg(not(target_family = "wasm"))]
    Robot(Box<RobotProgram>),
}

impl ProgramFile {
    /// Reads the program `bytes` of a `file`: a polyline if its name ends in `.csv`, a robot or APT program if [`Language::detect`] knows it, else
    /// G-code, written out first where the options say so. `beside` gives the bytes of files beside it: those that it calls, and the `.dat` of
    /// a `.src`.
    ///
    /// # Errors
    /// Bytes that are not of the expected form.
    pub fn parse(bytes: Vec<u8>, file: &Path, options: &ProgramOptions, beside: &SiblingFiles<'_>) -> Result<Self> {
        let name = file.display().to_string();
        if is_csv(file) || bytes.starts_with(POINTS) {
            return Ok(ProgramFile::Polyline(Box::new(Polyline::read(bytes, &name)?)));
        }
        #[cfg(not(target_family = "wasm"))]
        if let Some(language) = Language::detect(file, &bytes) {
            if options.robot.is_tool_stationary && language != Language::Rapid {
                let problem = "is not followed with a stationary tool ([tool] of the process): expected RAPID";
                let problem = format!("{} {problem}", language.name());
                return Err(Error::argument(name, problem));
            }
            let data = Path::new(file.file_name().unwrap_or_default()).with_extension("dat");
            // Each is sought by these names, the first of which is taken.
            let sought = match language {
                Language::Krl => vec![vec![data.to_string_lossy().into_owned()], config_names()],
                Language::Ls => vec![vec!["sysframe.va".to_owned(), "SYSFRAME.VA".to_owned()]],
                _ => Vec::new(),
            };
            let find = |names: Vec<String>| names.into_iter().find_map(|name| Some((beside(&name)?, name)));
            let found = sought.into_iter().filter_map(find).map(|(bytes, name)| (name, bytes));
            let program = robot_program(bytes, &name, language, found.collect(), options)?;
            return Ok(ProgramFile::Robot(Box::new(program)));
        }
        // What pages have was written out before.
        let expand = if cfg!(target_family = "wasm") { Expand::Never } else { options.gcode.expand };
        let program = match expand {
            Expand::Never => GcodeProgram::parse(bytes, &name, &options.gcode),
            Expand::Always => GcodeProgram::parse_expanded(bytes, &name, &options.gcode, beside),
            Expand::WhereNeeded => {
                GcodeProgram::parse_or_give_back(bytes, &name, &options.gcode).or_else(|given_back| {
                    let (refused, bytes) = *given_back;
                    if !refused.fault.may_vanish_on_expansion() {
                        return Err(refused);
                    }
                    GcodeProgram::parse_with_calls(bytes, &name, &options.gcode, beside)
                })
            }
        };
        Ok(ProgramFile::Gcode(Box::new(program?)))
    }

    /// Iterates over the texts on which the path depends, with their names: the file called `name`, the written-out program, and files beside it.
    pub fn texts<'a>(&'a self, name: &'a str) -> impl Iterator<Item = (&'a str, &'a [u8])> {
        let bytes = match self {
            ProgramFile::Polyline(polyline) => polyline.source(),
            ProgramFile::Gcode(program) => program.file_bytes(),
            #[cfg(not(target_family = "wasm"))]
            ProgramFile::Robot(program) => program.file_bytes(),
        };
        let own = [(name, Some(bytes)), (name, self.written_out())];
        own.into_iter().filter_map(|(name, bytes)| Some((name, bytes?))).chain(self.sibling_files())
    }

    /// Returns the format of its coordinates.
    pub fn own_format(&self) -> NumberFormat {
        match self {
            ProgramFile::Polyline(polyline) => polyline.own_format(),
            ProgramFile::Gcode(program) => program.own_format(),
            #[cfg(not(target_family = "wasm"))]
            ProgramFile::Robot(program) => program.own_format(),
        }
    }

    /// Returns the written-out program, if it was written out.
    pub fn written_out(&self) -> Option<&[u8]> {
        match self {
            ProgramFile::Gcode(program) if program.notes().written_out.is_some() => Some(program.source()),
            _ => None,
        }
    }

    /// Returns names and bytes of the data files read with a robot program (`.dat`, `$config.dat`, `sysframe.va`); none of other programs.
    fn sibling_files(&self) -> Vec<(&str, &[u8])> {
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

    /// Returns its path like [`ProgramFile::toolpath`], with up to [`GcodeProgram::MAX_POINTS`] points.
    ///
    /// # Errors
    /// As [`ProgramFile::toolpath`].
    pub fn long_toolpath(&self, sampling: Sampling) -> Result<Toolpath> {
        match self {
            ProgramFile::Polyline(_) => self.toolpath(sampling),
            ProgramFile::Gcode(program) => Ok(program.toolpath_up_to(sampling, GcodeProgram::MAX_POINTS)?),
            #[cfg(not(target_family = "wasm"))]
            ProgramFile::Robot(program) => Ok(program.toolpath_up_to(sampling, GcodeProgram::MAX_POINTS)?),
        }
    }

    /// Returns the line of the file, from 1, with the move number `segment`; `None` if there is no such move.
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

    /// Returns the line of a move in words: "line 7", or "O100.nc line 7" of a called file; `None` if there is no such move.
    pub fn line_name(&self, segment: usize) -> Option<String> {
        let line = self.line_of(segment)?;
        let called = self.called_files();
        let file = self.file_of(segment).checked_sub(1).and_then(|file| called.get(file));
        Some(file.map_or_else(|| format!("line {line}"), |file| format!("{file} line {line}")))
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

    /// Returns the text of the line of a move; bytes that are not UTF-8 are replaced. `None` if there is no such move.
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

/// Returns whether the name of `file` ends in `.csv`.
fn is_csv(file: &Path) -> bool {
    file.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("csv"))
}

/// Reads a program of a robot: written out first where the options say so, or where it cannot be read otherwise.
#[cfg(not(target_family = "wasm"))]
fn robot_program(
    bytes: Vec<u8>,
    name: &str,
    language: Language,
    beside: Vec<(String, Vec<u8>)>,
    options: &ProgramOptions,
) -> Result<RobotProgram> {
    let (robot, expand) = (&options.robot, options.gcode.expand);
    match (language, expand) {
        (Language::Rapid | Language::Krl, Expand::Always) => {
            Ok(RobotProgram::parse_expanded(bytes, name, language, beside, robot, false)?)
        }
        (Language::Rapid | Language::Krl, Expand::WhereNeeded) => {
            match RobotProgram::parse(bytes.clone(), name, language, beside.clone(), robot) {
                Err(refused) if refused.fault.may_vanish_on_expansion() => {
                    Ok(RobotProgram::parse_expanded(bytes, name, language, beside, robot, true)?)
                }
                read => Ok(read?),
            }
        }
        _ => Ok(RobotProgram::parse(bytes, name, language, beside, robot)?),
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
