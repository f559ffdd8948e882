//! Expanded robot programs: where each of their parts comes from.

use std::ops::Range;

use crate::{
    model::robot::RobotError,
    read::robot::{LocatedFault, RobotProgram},
};

/// A part of an expanded program.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Chunk {
    pub at: Range<usize>,
    /// The bytes of the program as posted that it comes from.
    pub origin: Range<usize>,
    /// Whether it is a statement that is run, not what is copied around them.
    pub is_run: bool,
}

/// Origin of an expanded program.
#[derive(Clone, Debug)]
pub(crate) struct RobotExpansion {
    /// In the order in which they stand.
    pub chunks: Vec<Chunk>,
    /// The program as posted.
    pub source: Vec<u8>,
    /// Where its lines end.
    line_ends: Vec<usize>,
    /// Numbers of lines of the program as posted, and of the expanded one.
    pub lines: [usize; 2],
    /// Whether a rewritten program gets its calls back where it can.
    pub keeps_calls: bool,
}

impl RobotExpansion {
    /// Creates the origin of an expanded program: of its `chunks` in `source`.
    pub fn new(source: Vec<u8>, chunks: Vec<Chunk>, lines: [usize; 2], keeps_calls: bool) -> Self {
        // \r\n is one ending.
        let is_end = |at: &usize| source[*at] == b'\n' || source[*at] == b'\r' && source.get(at + 1) != Some(&b'\n');
        let line_ends = (0..source.len()).filter(is_end).collect();
        Self { chunks, source, line_ends, lines, keeps_calls }
    }

    /// Returns the line, from 1, of byte `at` of the program as posted.
    pub fn posted_line(&self, at: usize) -> usize {
        1 + self.line_ends.partition_point(|end| *end < at)
    }

    /// Returns the line, from 1, that byte `at` of the expanded program comes from.
    pub fn line_of(&self, at: usize) -> usize {
        let next = self.chunks.partition_point(|chunk| chunk.at.start <= at);
        let origin = next.checked_sub(1).map_or(0, |chunk| {
            let Chunk { at: here, origin, .. } = &self.chunks[chunk];
            (origin.start + (at - here.start)).min(origin.end)
        });
        self.posted_line(origin)
    }
}

impl RobotProgram {
    /// Converts a refusal to an error with the file and the line that it comes from.
    pub(crate) fn locate(&self, refusal: LocatedFault) -> RobotError {
        let line = self.expansion.as_ref().map_or(refusal.line, |expansion| expansion.line_of(refusal.at.start));
        RobotError { line, ..refusal.locate(&self.name, &self.source) }
    }

    /// The program's bytes as posted.
    pub(crate) fn file_bytes(&self) -> &[u8] {
        self.expansion.as_ref().map_or(&self.source, |expansion| &expansion.source)
    }
}
