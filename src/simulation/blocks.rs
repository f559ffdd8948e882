//! What a G-code program asks of a control, block after block, before and as it is written.

use serde::Serialize;

use crate::toolpath::gcode::{GcodeError, Move, Program};

/// What the lines and arcs of a program that are driven with the feed ask of a control.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Blocks {
    /// Lines of the program.
    pub lines: usize,
    /// Lines and arcs that are driven with the feed.
    pub moves: usize,
    /// Blocks per second that the control must read at the programmed feed: one over the time of each move that has a feed.
    pub per_second: Option<Spread>,
    /// Angles between neighbouring moves, degrees.
    pub turns_deg: Option<Spread>,
}

/// The middle, the 95th percentile and the largest of some values.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Spread {
    /// Half of the values are at most this.
    pub p50: f64,
    /// 95 of 100 values are at most this.
    pub p95: f64,
    /// The largest.
    pub max: f64,
}

/// Blocks of a program and of what was written for it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BlocksBeforeAfter {
    /// As it was.
    pub before: Blocks,
    /// As it was written.
    #[serde(rename = "written")]
    pub after: Blocks,
}

impl Blocks {
    /// Those of `program`.
    ///
    /// # Errors
    /// When it cannot be followed.
    pub fn of(program: &Program) -> Result<Self, GcodeError> {
        let (mut moves, mut per_second, mut turns_deg) = (0, Vec::new(), Vec::new());
        program.each_move(|one: Move| {
            moves += 1;
            per_second.extend(one.seconds.map(f64::recip));
            turns_deg.extend(one.turn_rad.map(f64::to_degrees));
        })?;
        let lines = program.line_count();
        Ok(Self { lines, moves, per_second: Spread::of(per_second), turns_deg: Spread::of(turns_deg) })
    }
}

impl Spread {
    /// Of `values`; `None` if there are none. A percentile is the least value that as many are not above.
    pub fn of(mut values: Vec<f64>) -> Option<Self> {
        values.sort_by(f64::total_cmp);
        let at = |percent: usize| values.get((values.len() * percent).div_ceil(100).saturating_sub(1)).copied();
        Some(Self { p50: at(50)?, p95: at(95)?, max: *values.last()? })
    }
}
