//! Programs in files, read as a process says, and checked for its machine.

use std::path::Path;

#[cfg(not(target_family = "wasm"))]
use super::robot_file;
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
                robot_file::check_tool(program, self)?;
                robot_file::check_arm(program, self)?;
            }
        }
        Ok(program)
    }
}

/// Returns the inputs on which results depend that are computed from `program`, read from the file called `name`.
pub fn program_inputs(program: &ProgramFile, name: &str) -> Inputs {
    let inputs = program.texts(name).map(|(name, bytes)| Inputs::of(name, String::from_utf8_lossy(bytes)));
    inputs.fold(Inputs::default(), Inputs::and)
}
