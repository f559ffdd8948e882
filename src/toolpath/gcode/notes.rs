//! What a reader of a program should know: what was taken for granted, and which lines stay as they are.

use crate::toolpath::gcode::{Dialect, LengthUnit};

/// What the program did not say, and what followed from it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Notes {
    /// The dialect it was read as.
    pub dialect: Dialect,
    /// The unit taken, and the line (from 1) of the first length before any G20 or G21.
    pub unit_taken: Option<(LengthUnit, usize)>,
    /// Lines (from 1) whose motion leads from or to a place that is not known: they are no part of the path.
    pub not_located: Vec<usize>,
    /// Lines that the program has, and that it was written out in.
    pub written_out: Option<[usize; 2]>,
    /// Whether it leads A, B or C anywhere.
    pub(crate) names_rotary: bool,
}
