//! A program written out as the motion it makes: calls, loops and jumps followed, expressions evaluated, before anything is
//! interpreted; then cycles as the moves that they are. What depends on the state of the machine is refused.

mod calls;
mod cycles;
mod even;
mod expression;
mod flow;
mod fold;
mod jumps;
mod line;
mod modes;
mod run;
mod variables;

pub use fold::{Calls, Differs, How};

use crate::toolpath::gcode::{Dialect, GcodeOptions, Program, dialect, error::GcodeError, lines::Lines};

/// Gives the bytes of a file beside the program, if there is one of this name.
pub type Beside<'a> = dyn Fn(&str) -> Option<Vec<u8>> + 'a;

/// Where the lines of a program that was written out come from.
#[derive(Clone, Debug)]
pub(super) struct WrittenOut {
    /// Of each of its lines.
    pub origins: Vec<Origin>,
    /// The files, the program's own first.
    files: Vec<CalledFile>,
    /// How many lines the program has.
    pub lines: usize,
    /// Index of the line that says what it is.
    header: usize,
    /// Whether calls are to stay where they can.
    keeps_calls: bool,
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
    fn of_lines(name: &str, bytes: Vec<u8>, lines: &[usize]) -> WrittenOut {
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
    fn called(&self, at: Origin) -> Option<&str> {
        (at.file > 0).then(|| self.files[at.file].name.as_str())
    }

    /// `error` where it comes from.
    pub fn located(&self, error: GcodeError) -> GcodeError {
        let Origin { file, line } = self.origin(error.line);
        GcodeError { file: self.files[file].name.clone(), line: line + 1, ..error }
    }

    /// The lines are now those of which `lines` says which they were, from 0.
    pub fn follow(&mut self, lines: &[usize]) {
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

    fn origin(&self, line: usize) -> Origin {
        self.origins.get(line.saturating_sub(1)).copied().unwrap_or_default()
    }
}

/// A line of a source.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Origin {
    pub file: usize,
    /// From 0.
    pub line: usize,
}

impl Program {
    /// Writes the program out as the motion it makes (calls, loops, jumps and expressions followed, cycles as moves), then
    /// reads that as [`Program::parse`] does. A comment at its top says so. Lines in messages are those of the files they come from;
    /// `beside` gives the files beside the program that it may call.
    ///
    /// # Errors
    /// What cannot be evaluated, and as [`Program::parse`].
    pub fn parse_expanded(
        source: impl Into<Vec<u8>>,
        name: &str,
        options: &GcodeOptions,
        beside: &Beside<'_>,
    ) -> Result<Program, GcodeError> {
        Program::parse_written_out(source.into(), name, options, beside, false)
    }

    /// Follows calls, loops, jumps and expressions as [`Program::parse_expanded`] does, but leaves cycles as they are, and gives what
    /// is rewritten its calls back where it can ([`Program::calls_of`]).
    ///
    /// # Errors
    /// As [`Program::parse_expanded`].
    pub fn parse_with_calls(
        source: impl Into<Vec<u8>>,
        name: &str,
        options: &GcodeOptions,
        beside: &Beside<'_>,
    ) -> Result<Program, GcodeError> {
        Program::parse_written_out(source.into(), name, options, beside, true)
    }

    fn parse_written_out(
        source: Vec<u8>,
        name: &str,
        options: &GcodeOptions,
        beside: &Beside<'_>,
        keeps_calls: bool,
    ) -> Result<Program, GcodeError> {
        let dialect = options.dialect.unwrap_or_else(|| Dialect::of(&source));
        let options = &GcodeOptions { dialect: Some(dialect), ..options.clone() };
        let (mut bytes, mut written_out) = match dialect {
            _ if dialect.is_iso() => run::Run::new(source, name, options, beside).all()?,
            _ => {
                let Some((bytes, lines)) = dialect.without_cycles(&source) else {
                    return Err(dialect::not_written_out(&source, name, dialect));
                };
                (bytes, WrittenOut::of_lines(name, source, &lines))
            }
        };
        if !dialect.is_iso() {
            // Moves have taken the place of its cycles.
        } else if keeps_calls {
            written_out.keeps_calls = true;
        } else {
            let program = Program::parse(bytes, name, options).map_err(|fault| written_out.located(fault))?;
            let without_cycles = program.without_cycles().map_err(|fault| written_out.located(fault))?;
            bytes = without_cycles.map_or(program.source, |(moves, lines)| {
                written_out.follow(&lines);
                moves
            });
        }
        written_out.sign(&mut bytes, dialect);
        let mut program = Program::parse(bytes, name, options).map_err(|fault| written_out.located(fault))?;
        for line in &mut program.notes.not_located {
            *line = written_out.line_of(*line);
        }
        if let Some((_, line)) = &mut program.notes.unit_taken {
            *line = written_out.line_of(*line);
        }
        program.notes.written_out = Some([written_out.lines, written_out.origins.len()]);
        program.written_out = Some(written_out);
        Ok(program)
    }
}
