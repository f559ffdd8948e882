//! Expanded programs: which line of which file each of their lines comes from.

use crate::{
    model::gcode::{Dialect, GcodeError},
    read::gcode::lines::Lines,
};

/// Origins of the lines of an expanded program.
#[derive(Clone, Debug)]
pub(crate) struct Expansion {
    /// Origin of each line.
    pub origins: Vec<Origin>,
    /// The files; the program's own comes first.
    pub(crate) files: Vec<CalledFile>,
    /// Number of lines of the program as written.
    pub lines: usize,
    /// Index of the comment line that says what it is.
    pub(crate) header: usize,
    /// Whether a rewritten program gets its calls back where it can.
    pub(crate) keeps_calls: bool,
    /// Most decimals of a coordinate that is written as a number, not computed.
    pub(crate) decimals: usize,
}

/// A file that is run, or called.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CalledFile {
    /// Its name: as given, or as it is called beside the program.
    pub name: String,
    /// Its bytes.
    pub bytes: Vec<u8>,
}

impl Expansion {
    /// Bytes of the program's own file.
    pub fn file_bytes(&self) -> &[u8] {
        &self.files[0].bytes
    }

    /// Returns the line (from 1) of its file that line `line` (from 1) of the expansion comes from.
    pub fn line_of(&self, line: usize) -> usize {
        self.origin(line).line + 1
    }

    /// Returns the number of the file that line `line` (from 1) comes from; 0 is the program's own.
    pub fn file_of(&self, line: usize) -> usize {
        self.origin(line).file
    }

    /// Names of the called files, from number 1 on.
    pub fn called_files(&self) -> impl Iterator<Item = &str> {
        self.files.iter().skip(1).map(|file| file.name.as_str())
    }

    /// Returns the name of the file of `at`; `None` if it is the program's own.
    pub(crate) fn called_name(&self, at: Origin) -> Option<&str> {
        (at.file > 0).then(|| self.files[at.file].name.as_str())
    }

    /// Returns `error` with the file and line that its line comes from.
    pub fn relocate(&self, error: GcodeError) -> GcodeError {
        let Origin { file, line } = self.origin(error.line);
        GcodeError { file: self.files[file].name.clone(), line: line + 1, ..error }
    }

    /// Replaces the lines by others, each given as the index (from 0) of the line that it comes from.
    pub fn compose(&mut self, lines: &[usize]) {
        self.origins = lines.iter().map(|line| self.origins.get(*line).copied().unwrap_or_default()).collect();
    }

    /// Adds a comment to `bytes`, the expanded program, that says what they are.
    pub fn add_header(&mut self, bytes: &mut Vec<u8>, dialect: Dialect) {
        let (header, line) = dialect.header(bytes, self.origins.len() + 1, self.lines);
        let at = line.checked_sub(1).map_or(0, |before| Lines::split(bytes).ending(before).end);
        bytes.splice(at..at, header.into_bytes());
        *bytes = dialect.renumbered(b"", std::mem::take(bytes));
        self.header = line;
        self.origins.insert(line, Origin::default());
    }

    /// Returns the file and line that line `line` (from 1) comes from.
    pub(crate) fn origin(&self, line: usize) -> Origin {
        self.origins.get(line.saturating_sub(1)).copied().unwrap_or_default()
    }
}

/// File and line that a line comes from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Origin {
    pub file: usize,
    /// From 0.
    pub line: usize,
}
