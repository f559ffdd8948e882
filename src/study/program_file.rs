//! A program in a file, whatever its format: read, followed, written back.

use std::path::Path;

use nalgebra::Vector3;

use crate::{
    input::{Folder, Inputs, error::Result},
    process::file::Process,
    study::blocks::{Blocks, BlocksBeforeAfter},
    toolpath::{
        Sampling, Toolpath,
        gcode::{Beside, Calls, Expand, Fault, GcodeOptions, Program},
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
    /// Reads `file`: a polyline if its name ends in `.csv`, G-code otherwise, written out first where `options` say so. What it
    /// calls is sought beside it.
    ///
    /// # Errors
    /// A file that cannot be read or is not of the expected form.
    pub fn read(file: &Path, options: &GcodeOptions) -> Result<Self> {
        let name = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
        match file.parent() {
            Some(folder) if file.ends_with(&name) => Self::in_folder(&Folder::from(folder), &name, options),
            _ => Self::parse(crate::input::file::read(file)?, file, options),
        }
    }

    /// The same of the file called `name` in `folder`.
    ///
    /// # Errors
    /// As [`ProgramFile::read`].
    pub fn in_folder(folder: &Folder, name: &str, options: &GcodeOptions) -> Result<Self> {
        let around = folder.of(name);
        let beside = |name: &str| around.has(name).then(|| around.bytes(name).ok()).flatten();
        let program = Self::parse_beside(folder.bytes(name)?, &folder.path(name), options, &beside)?;
        // Pages get it as it was written out.
        if let Some(written_out) = program.written_out() {
            folder.note(name, written_out);
        }
        Ok(program)
    }

    /// The program that `bytes` of a `file` are, as [`ProgramFile::read`], with nothing beside it.
    ///
    /// # Errors
    /// Bytes that are not of the expected form.
    pub fn parse(bytes: Vec<u8>, file: &Path, options: &GcodeOptions) -> Result<Self> {
        Self::parse_beside(bytes, file, options, &|_| None)
    }

    fn parse_beside(bytes: Vec<u8>, file: &Path, options: &GcodeOptions, beside: &Beside<'_>) -> Result<Self> {
        let name = file.display().to_string();
        if is_csv(file) {
            return Ok(ProgramFile::Polyline(Polyline::read(bytes, &name)?));
        }
        // What pages have was written out before.
        let expand = if cfg!(target_family = "wasm") { Expand::Never } else { options.expand };
        let program = match expand {
            Expand::Never => Program::parse(bytes, &name, options),
            Expand::Always => Program::parse_expanded(bytes, &name, options, beside),
            Expand::WhereNeeded => Program::parse_or_give_back(bytes, &name, options).or_else(|given_back| {
                let (refused, bytes) = *given_back;
                if !refused.fault.is_met_by_expanding() {
                    return Err(refused);
                }
                let written_out = Program::parse_with_calls(bytes, &name, options, beside);
                written_out.map_err(|fault| if fault.fault == Fault::NotWrittenOut { refused } else { fault })
            }),
        };
        Ok(ProgramFile::Gcode(Box::new(program?)))
    }

    /// What results along it depend on: its file, called `name`, and what it was written out as, for what it calls beside it counts.
    pub(crate) fn inputs(&self, name: &str) -> Inputs {
        let bytes = match self {
            ProgramFile::Polyline(polyline) => polyline.source(),
            ProgramFile::Gcode(program) => program.file_bytes(),
        };
        let texts = [Some(bytes), self.written_out()];
        let inputs = texts.into_iter().flatten().map(|bytes| Inputs::of(name, String::from_utf8_lossy(bytes)));
        inputs.fold(Inputs::default(), Inputs::and)
    }

    /// The program written out, if it was.
    fn written_out(&self) -> Option<&[u8]> {
        match self {
            ProgramFile::Gcode(program) if program.notes().written_out.is_some() => Some(program.source()),
            _ => None,
        }
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

    /// The number of the file that this line is in: 0 is the program's own, then come [`ProgramFile::called_files`].
    pub fn file_of(&self, segment: usize) -> usize {
        match self {
            ProgramFile::Polyline(_) => 0,
            ProgramFile::Gcode(program) => program.file_of(segment),
        }
    }

    /// The names of the files beside the program that it calls.
    pub fn called_files(&self) -> Vec<String> {
        match self {
            ProgramFile::Polyline(_) => Vec::new(),
            ProgramFile::Gcode(program) => program.called_files().map(String::from).collect(),
        }
    }

    /// The line in words: "line 7", or "O100.nc line 7" of a file that the program calls.
    pub fn place_of(&self, segment: usize) -> Option<String> {
        let line = self.line_of(segment)?;
        Some(place_in_words(&self.called_files(), self.file_of(segment), line))
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

    /// The same program through `positions` (workpiece frame, mm, one per point of `path`), written as `process` says, and what
    /// reading it gives.
    ///
    /// # Errors
    /// Positions that are no positions, or a written program that does not read back.
    pub fn rewritten(&self, path: &Toolpath, positions: &[Vector3<f64>], process: &Process) -> Result<Rewritten> {
        match self {
            ProgramFile::Polyline(polyline) => {
                let format = process.decimals.format(polyline.own_format())?;
                let rewritten = polyline.rewrite_sampled(path, positions, format)?;
                let back = rewritten.read_back()?.positions_mm();
                Ok(Rewritten { bytes: rewritten.into_bytes(), back, blocks: None, calls: None })
            }
            ProgramFile::Gcode(program) => {
                let rewritten = program.rewrite(path, positions, process.writing(program.own_format())?)?;
                let written = rewritten.read()?;
                let back = rewritten.positions_of(&written)?;
                let blocks = BlocksBeforeAfter { before: Blocks::of(program)?, after: Blocks::of(&written)? };
                let calls = program.calls_of(&rewritten);
                Ok(Rewritten { bytes: rewritten.into_bytes(), back, blocks: Some(blocks), calls })
            }
        }
    }
}

/// A program that has been written and read.
#[derive(Debug, Clone)]
pub struct Rewritten {
    /// Its bytes.
    pub bytes: Vec<u8>,
    /// Where it passes each point, workpiece frame, mm, rounding included.
    pub back: Vec<Vector3<f64>>,
    /// What its blocks and those of the program as it was ask of a control; `None` for polylines.
    pub blocks: Option<BlocksBeforeAfter>,
    /// What becomes of its calls, if it has any; `bytes` are written out.
    pub calls: Option<Calls>,
}

/// `line` of the file of this number, where the files that a program calls are `called`.
pub(crate) fn place_in_words(called: &[String], file: usize, line: usize) -> String {
    match file.checked_sub(1).and_then(|file| called.get(file)) {
        Some(file) => format!("{file} line {line}"),
        None => format!("line {line}"),
    }
}

fn is_csv(file: &Path) -> bool {
    file.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("csv"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_program_calls_counts_as_an_input() {
        let inputs = |sub: &str| {
            let files = [("part.nc", "O1\nG0 X0 Y0 Z0\nM98 P100\nM30\n"), ("O100.nc", sub)];
            let folder = Folder::in_memory(files.map(|(name, text)| (name.into(), text.into())));
            ProgramFile::in_folder(&folder, "part.nc", &GcodeOptions::default()).unwrap().inputs("part.nc")
        };
        let texts = |inputs: &Inputs| inputs.texts().map(|(_, text)| text.to_owned()).collect::<Vec<_>>();
        let (five, six) = (inputs("O100\nG1 X5\nM99\n"), inputs("O100\nG1 X6\nM99\n"));
        assert_eq!(texts(&five)[0], "O1\nG0 X0 Y0 Z0\nM98 P100\nM30\n");
        assert!(texts(&five)[1].ends_with("G0 X0 Y0 Z0\nG1 X5\nM30\n"), "{:?}", texts(&five));
        assert_eq!(texts(&five)[0], texts(&six)[0]);
        assert_ne!(five, six);
    }
}
