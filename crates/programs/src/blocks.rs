//! Demands of a G-code program on a control, block by block, before and after compensation.

use serde::Serialize;

use crate::gcode::{GcodeError, GcodeProgram};

/// Demands on a control of the lines and arcs that are driven with the feed.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Blocks {
    /// Number of lines of the program.
    pub lines: usize,
    /// Number of lines and arcs driven with the feed.
    pub moves: usize,
    /// Blocks per second at the programmed feed: the inverse time of each move that has a feed.
    pub per_second: Option<Percentiles>,
    /// Angles between neighbouring moves, degrees.
    pub turns_deg: Option<Percentiles>,
}

/// Median, 95th percentile and maximum of some values.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Percentiles {
    /// Median.
    pub p50: f64,
    /// 95th percentile.
    pub p95: f64,
    /// The largest.
    pub max: f64,
}

/// Demands of a program before and after compensation.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BlocksBeforeAfter {
    /// Before compensation.
    pub before: Blocks,
    /// As written.
    #[serde(rename = "written")]
    pub after: Blocks,
}

impl Blocks {
    /// Returns the demands of `program`.
    ///
    /// # Errors
    /// The program cannot be followed.
    pub fn of(program: &GcodeProgram) -> Result<Self, GcodeError> {
        let (mut moves, mut per_second, mut turns_deg) = (0, Vec::new(), Vec::new());
        program.each_move(|one| {
            moves += 1;
            per_second.extend(one.seconds.map(f64::recip));
            turns_deg.extend(one.turn_rad.map(f64::to_degrees));
        })?;
        let lines = program.line_count();
        Ok(Self { lines, moves, per_second: Percentiles::of(per_second), turns_deg: Percentiles::of(turns_deg) })
    }
}

impl Percentiles {
    /// Returns the percentiles of `values`, each one of the values; `None` if there are none.
    pub fn of(mut values: Vec<f64>) -> Option<Self> {
        values.sort_by(f64::total_cmp);
        let at = |percent: usize| values.get((values.len() * percent).div_ceil(100).saturating_sub(1)).copied();
        Some(Self { p50: at(50)?, p95: at(95)?, max: *values.last()? })
    }
}
