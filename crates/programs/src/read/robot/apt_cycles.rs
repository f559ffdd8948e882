//! Drilling cycles of APT: `CYCLE/DRILL,FEDTO,…`, in force for each GOTO until `CYCLE/OFF`.
//!
//! Lengths count from the point of the GOTO along the tool axis: FEDTO (NX writes it negative) or DEPTH down to the bottom, RAPTO or CLEAR up
//! to where the feed begins, RTRCTO up to where the tool comes back, to RAPTO without it (ISO 4343; SolidWorks CAM, NX, Creo). Depths
//! without a name, which every post-processor orders in its own way, are refused.

use crate::{
    model::robot::{Drilling, INCH_MM, RobotFault},
    read::robot::apt::{FeedUnit, Reader},
};

/// A cycle with its feed, if it gives one.
type Cycle = (Drilling, Option<(f64, FeedUnit)>);

impl Reader<'_> {
    /// Returns the cycle that the `words` behind `CYCLE/` put in force. `Err` for a kind or a word that is not followed.
    pub(crate) fn read_cycle(&self, words: &[String]) -> Result<Cycle, RobotFault> {
        let expected = RobotFault::Form {
            expected: "DRILL, DEEP, BRKCHP, FACE, REAM, BORE or TAP with FEDTO or DEPTH, RAPTO or CLEAR, and RTRCTO, each before its number",
        };
        let mut words = words.iter().map(String::as_str).peekable();
        if !words.next().is_some_and(|kind| KINDS.contains(&kind)) {
            return Err(expected);
        }
        if words.peek().is_some_and(|word| matches!(*word, "DEEP" | "BRKCHP")) {
            words.next();
        }
        let (mut depth, mut clear, mut back, mut feed) = (None, None, None, None);
        while let Some(word) = words.next() {
            let number = words.next().and_then(|number| number.parse::<f64>().ok()).filter(|number| number.is_finite());
            let Some(number) = number else { return Err(expected) };
            let is_new = match word {
                "FEDTO" | "DEPTH" => depth.replace(number.abs()).is_none(),
                "RAPTO" | "CLEAR" => clear.replace(number).is_none(),
                "RTRCTO" => back.replace(number).is_none(),
                "MMPM" => feed.replace((number, FeedUnit::PerMinute(1.0))).is_none(),
                "IPM" => feed.replace((number, FeedUnit::PerMinute(INCH_MM))).is_none(),
                "MMPR" => feed.replace((number, FeedUnit::PerTurn(1.0))).is_none(),
                "IPR" => feed.replace((number, FeedUnit::PerTurn(INCH_MM))).is_none(),
                // How deep a peck goes and how long a dwell lasts is on the way.
                "DWELL" | "STEP" | "INCR" | "1STPECK" | "SUBPECK" => true,
                _ => false,
            };
            if !is_new {
                return Err(expected);
            }
        }
        let mm = |length: f64| length * self.unit_mm;
        match (depth.map(mm), clear.map(mm), back.map(mm)) {
            (Some(depth_mm), Some(clear_mm), back_mm) if depth_mm > 0.0 && clear_mm >= 0.0 => {
                let back_mm = back_mm.unwrap_or(clear_mm).max(clear_mm);
                Ok((Drilling { depth_mm, clear_mm, back_mm }, feed))
            }
            _ => Err(expected),
        }
    }
}

/// Kinds of cycles that go into a hole along its axis and out again.
const KINDS: [&str; 8] = ["DRILL", "DEEP", "DEEP2", "BRKCHP", "FACE", "REAM", "BORE", "TAP"];
