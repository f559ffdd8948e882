//! A program written out as the motion it makes: calls, loops and jumps followed, expressions evaluated, before anything is
//! interpreted. What depends on the state of the machine is refused.

mod calls;
mod expression;
mod flow;
mod jumps;
mod line;
mod run;
mod variables;

use crate::toolpath::gcode::{BlockDelete, error::GcodeError};

/// Gives the bytes of a file beside the program, if there is one of this name.
pub type Beside<'a> = dyn Fn(&str) -> Option<Vec<u8>> + 'a;

/// Where the lines of a program that was written out come from.
#[derive(Clone, Debug)]
pub(super) struct WrittenOut {
    /// Of each of its lines.
    pub origins: Vec<Origin>,
    /// The names of the files, the program's own first.
    files: Vec<String>,
    /// How many lines the program has.
    pub lines: usize,
}

impl WrittenOut {
    /// The line, from 1, that `line` (from 1) comes from.
    pub fn line_of(&self, line: usize) -> usize {
        self.origin(line).line + 1
    }

    /// `error` where it comes from.
    pub fn located(&self, error: GcodeError) -> GcodeError {
        let Origin { file, line } = self.origin(error.line);
        GcodeError { file: self.files[file].clone(), line: line + 1, ..error }
    }

    fn origin(&self, line: usize) -> Origin {
        self.origins.get(line.saturating_sub(1)).copied().unwrap_or_default()
    }
}

/// A line of a source.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Origin {
    pub file: usize,
    /// From 0.
    pub line: usize,
}

/// Writes the program `source`, called `name`, out.
///
/// # Errors
/// What cannot be evaluated, calls of what is not there, and programs that do not come to an end.
pub(super) fn expand(
    source: &[u8],
    name: &str,
    block_delete: BlockDelete,
    beside: &Beside<'_>,
) -> Result<(Vec<u8>, WrittenOut), GcodeError> {
    run::Run::new(source, name, block_delete, beside).all()
}
