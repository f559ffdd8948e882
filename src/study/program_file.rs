//! A program in a file, whatever its format: read, followed, written back.

use std::path::Path;

use nalgebra::Vector3;

use crate::{
    input::error::Result,
    process::file::Decimals,
    toolpath::{
        Sampling, Toolpath,
        gcode::{GcodeOptions, Program},
        polyline::Polyline,
    },
};

/// A program as it was read.
#[derive(Debug, Clone)]
pub enum ProgramFile {
    /// Points in a CSV file.
    Polyline(Polyline),
    /// A G-code program.
    Gcode(Box<Program>),
}

impl ProgramFile {
    /// Reads `file`: a polyline if its name ends in `.csv`, G-code otherwise.
    ///
    /// # Errors
    /// A file that cannot be read or is not of the expected form.
    pub fn read(file: &Path, options: &GcodeOptions) -> Result<Self> {
        Self::parse(crate::input::file::read(file)?, file, options)
    }

    /// The same, G-code written out as the motion it makes: what it calls is sought beside it.
    ///
    /// # Errors
    /// As [`ProgramFile::read`], and what cannot be written out.
    pub fn read_expanded(file: &Path, options: &GcodeOptions) -> Result<Self> {
        if is_csv(file) {
            return Self::read(file, options);
        }
        let folder = file.parent().unwrap_or(Path::new(""));
        let beside = |name: &str| crate::input::file::read(&folder.join(name)).ok();
        let bytes = crate::input::file::read(file)?;
        let program = Program::parse_expanded(&bytes, &file.display().to_string(), options, &beside)?;
        Ok(ProgramFile::Gcode(Box::new(program)))
    }

    /// The program that `bytes` of a `file` are, as [`ProgramFile::read`].
    ///
    /// # Errors
    /// Bytes that are not of the expected form.
    pub fn parse(bytes: Vec<u8>, file: &Path, options: &GcodeOptions) -> Result<Self> {
        let name = file.display().to_string();
        Ok(match is_csv(file) {
            true => ProgramFile::Polyline(Polyline::read(bytes, &name)?),
            false => ProgramFile::Gcode(Box::new(Program::parse(bytes, &name, options)?)),
        })
    }

    /// Its points in the workpiece frame; lines and arcs are split as `sampling` says.
    ///
    /// # Errors
    /// Too many points, or a program that cannot be followed.
    pub fn toolpath(&self, sampling: Sampling) -> Result<Toolpath> {
        match self {
            ProgramFile::Polyline(polyline) => Ok(polyline.sampled(sampling)?),
            ProgramFile::Gcode(program) => Ok(program.toolpath(sampling)?),
        }
    }

    /// As [`ProgramFile::toolpath`], of a program that may have [`Program::MAX_POINTS`] points.
    ///
    /// # Errors
    /// As [`ProgramFile::toolpath`].
    pub fn long_toolpath(&self, sampling: Sampling) -> Result<Toolpath> {
        match self {
            ProgramFile::Polyline(_) => self.toolpath(sampling),
            ProgramFile::Gcode(program) => Ok(program.toolpath_up_to(sampling, Program::MAX_POINTS)?),
        }
    }

    /// Line of the file that a point's move stands in, from 1, where it is known.
    pub fn line_of(&self, segment: usize) -> Option<usize> {
        match self {
            ProgramFile::Polyline(polyline) => polyline.line_of(segment),
            ProgramFile::Gcode(program) => program.line_of(segment),
        }
    }

    /// Whether a point's move is a hole of a cycle.
    pub fn is_hole(&self, segment: usize) -> bool {
        match self {
            ProgramFile::Polyline(_) => false,
            ProgramFile::Gcode(program) => program.is_hole(segment),
        }
    }

    /// What stands in that line; a byte that is no letter of UTF-8 is shown as such.
    pub fn text_of(&self, segment: usize) -> Option<String> {
        let bytes = match self {
            ProgramFile::Polyline(polyline) => polyline.content_of(segment)?,
            ProgramFile::Gcode(program) => program.content_of(segment)?,
        };
        Some(String::from_utf8_lossy(bytes).trim().to_string())
    }

    /// The same program through `positions` (workpiece frame, mm, one per point of `path`), and the positions read back
    /// from what was written, rounding included.
    ///
    /// # Errors
    /// Positions that are no positions, or a written program that does not read back.
    pub fn rewritten(
        &self,
        path: &Toolpath,
        positions: &[Vector3<f64>],
        decimals: Decimals,
    ) -> Result<(Vec<u8>, Vec<Vector3<f64>>)> {
        match self {
            ProgramFile::Polyline(polyline) => {
                let rewritten = polyline.rewrite_sampled(path, positions, decimals.format(polyline.own_format())?)?;
                let back = rewritten.read_back()?.positions_mm();
                Ok((rewritten.into_bytes(), back))
            }
            ProgramFile::Gcode(program) => {
                let rewritten = program.rewrite(path, positions, decimals.format(program.own_format())?)?;
                let back = rewritten.read_back_mm()?;
                Ok((rewritten.into_bytes(), back))
            }
        }
    }
}

fn is_csv(file: &Path) -> bool {
    file.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("csv"))
}
