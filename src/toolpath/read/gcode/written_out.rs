//! Where the lines of a program that was written out come from.

use crate::toolpath::{
    model::gcode::{Dialect, GcodeError},
    read::gcode::lines::Lines,
};

/// Where the lines of a program that was written out come from.
#[derive(Clone, Debug)]
pub(crate) struct WrittenOut {
    /// Of each of its lines.
    pub origins: Vec<Origin>,
    /// The files, the program's own first.
    pub(crate) files: Vec<CalledFile>,
    /// How many lines the program has.
    pub lines: usize,
    /// Index of the line that says what it is.
    pub(crate) header: usize,
    /// Whether calls are to stay where they can.
    pub(crate) keeps_calls: bool,
}

/// A file that is run, or called by one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CalledFile {
    /// Its name: as given, or as it is called beside the program.
    pub name: String,
    /// Its bytes.
    pub bytes: Vec<u8>,
}

impl WrittenOut {
    /// Of a program of one file, in which its lines, from 0, are now these.
    pub(crate) fn of_lines(name: &str, bytes: Vec<u8>, lines: &[usize]) -> WrittenOut {
        WrittenOut {
            origins: lines.iter().map(|line| Origin { file: 0, line: *line }).collect(),
            lines: Lines::of(&bytes).len(),
            files: vec![CalledFile { name: name.to_owned(), bytes }],
            header: 0,
            keeps_calls: false,
        }
    }

    pub fn file_bytes(&self) -> &[u8] {
        &self.files[0].bytes
    }

    /// The line, from 1, that `line` (from 1) comes from.
    pub fn line_of(&self, line: usize) -> usize {
        self.origin(line).line + 1
    }

    /// The number of the file that `line` (from 1) comes from: 0 is the program's own.
    pub fn file_of(&self, line: usize) -> usize {
        self.origin(line).file
    }

    /// The names of the files that the program calls, from number 1 on.
    pub fn called_files(&self) -> impl Iterator<Item = &str> {
        self.files.iter().skip(1).map(|file| file.name.as_str())
    }

    /// The name of the file `at` is in, if it is not the program's own.
    pub(crate) fn called(&self, at: Origin) -> Option<&str> {
        (at.file > 0).then(|| self.files[at.file].name.as_str())
    }

    /// `error` where it comes from.
    pub fn located(&self, error: GcodeError) -> GcodeError {
        let Origin { file, line } = self.origin(error.line);
        GcodeError { file: self.files[file].name.clone(), line: line + 1, ..error }
    }

    /// The lines are now those of which `lines` says which they were, from 0.
    pub fn compose_origins(&mut self, lines: &[usize]) {
        self.origins = lines.iter().map(|line| self.origins.get(*line).copied().unwrap_or_default()).collect();
    }

    /// Adds the comment to `bytes`, a program in `dialect`, that says what they are.
    pub fn sign(&mut self, bytes: &mut Vec<u8>, dialect: Dialect) {
        let (header, line) = dialect.header(bytes, self.origins.len() + 1, self.lines);
        let at = line.checked_sub(1).map_or(0, |before| Lines::of(bytes).ending(before).end);
        bytes.splice(at..at, header.into_bytes());
        *bytes = dialect.numbered(b"", std::mem::take(bytes));
        self.header = line;
        self.origins.insert(line, Origin::default());
    }

    pub(crate) fn origin(&self, line: usize) -> Origin {
        self.origins.get(line.saturating_sub(1)).copied().unwrap_or_default()
    }
}

/// A line of a source.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Origin {
    pub file: usize,
    /// From 0.
    pub line: usize,
}
