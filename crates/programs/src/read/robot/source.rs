//! Lines of a robot program, and refusals with their place in it.

use std::ops::Range;

use crate::model::robot::{RobotError, RobotFault};

/// A fault with its line and bytes in the source.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct LocatedFault {
    /// Line, from 1.
    pub line: usize,
    pub at: Range<usize>,
    pub fault: RobotFault,
}

/// Most characters of a statement in a message.
const SHOWN: usize = 80;

impl LocatedFault {
    /// Converts the refusal to an error with the file `name` and the statement from `source`, shortened.
    pub fn locate(self, name: &str, source: &[u8]) -> RobotError {
        let text = String::from_utf8_lossy(source.get(self.at).unwrap_or_default());
        let words: Vec<&str> = text.split_whitespace().collect();
        let mut statement: String = words.join(" ").chars().take(SHOWN + 1).collect();
        if statement.chars().count() > SHOWN {
            statement = statement.chars().take(SHOWN - 1).chain(['…']).collect();
        }
        RobotError { file: name.to_owned(), line: self.line, statement, fault: self.fault }
    }
}

/// An iterator over the lines of a source.
#[derive(Clone, Debug)]
pub(crate) struct LineCursor<'a> {
    source: &'a [u8],
    /// Index of the next line's first byte.
    next: usize,
    /// Number of the last line, from 1.
    pub line: usize,
}

impl<'a> LineCursor<'a> {
    /// Starts at the first line.
    pub fn new(source: &'a [u8]) -> Self {
        Self { source, next: 0, line: 0 }
    }

    /// Moves to the next line and returns its range without its ending; `None` at the end.
    pub fn advance(&mut self) -> Option<Range<usize>> {
        let rest = self.source.get(self.next..).filter(|rest| !rest.is_empty())?;
        let start = self.next;
        let length = rest.iter().position(|byte| matches!(byte, b'\r' | b'\n')).unwrap_or(rest.len());
        let ending = match &rest[length..] {
            [b'\r', b'\n', ..] => 2,
            [_, ..] => 1,
            [] => 0,
        };
        self.next = start + length + ending;
        self.line += 1;
        Some(start..start + length)
    }
}

/// Returns the line ending of a source: that of its first line, or `\n`.
pub(crate) fn line_ending(source: &[u8]) -> &'static [u8] {
    match source.iter().position(|byte| matches!(byte, b'\r' | b'\n')) {
        Some(at) if source[at..].starts_with(b"\r\n") => b"\r\n",
        Some(at) if source[at] == b'\r' => b"\r",
        _ => b"\n",
    }
}

/// Returns the leading blanks of the line that holds byte `at`, and whether only they stand before `at`.
pub(crate) fn indent(source: &[u8], at: usize) -> (&[u8], bool) {
    let start = source[..at].iter().rposition(|byte| matches!(byte, b'\r' | b'\n')).map_or(0, |end| end + 1);
    let blanks = source[start..at].iter().position(|byte| !matches!(byte, b' ' | b'\t')).unwrap_or(at - start);
    (&source[start..start + blanks], start + blanks == at)
}

/// Returns `range` of the source without the blanks at its ends.
pub(crate) fn trimmed(source: &[u8], range: Range<usize>) -> Range<usize> {
    let text = &source[range.clone()];
    let start = range.start + text.len() - text.trim_ascii_start().len();
    start..(range.start + text.trim_ascii_end().len()).max(start)
}
