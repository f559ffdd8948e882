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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_are_values() {
        let spread = |values: &[f64]| Spread::of(values.to_vec());
        assert_eq!(spread(&[]), None);
        assert_eq!(spread(&[2.0]), Some(Spread { p50: 2.0, p95: 2.0, max: 2.0 }));
        let hundred: Vec<f64> = (1..=100).rev().map(f64::from).collect();
        assert_eq!(spread(&hundred), Some(Spread { p50: 50.0, p95: 95.0, max: 100.0 }));
    }

    #[test]
    fn a_square_turns_by_right_angles_at_the_rate_of_its_sides() {
        let program = "G21 G90\nG0 X0 Y0 Z0\nG1 X10 F600\nY10\nX0\nY0 F1200\nG0 Z5\n";
        let blocks = Blocks::of(&Program::parse(program, "square.nc", &Default::default()).unwrap()).unwrap();
        assert_eq!((blocks.lines, blocks.moves), (7, 4));
        assert_eq!(blocks.per_second, Some(Spread { p50: 1.0, p95: 2.0, max: 2.0 }));
        let turns = blocks.turns_deg.unwrap();
        assert!((turns.p50 - 90.0).abs() < 1e-9 && (turns.max - 90.0).abs() < 1e-9, "{turns:?}");
    }
}
