//! What reports say of a correction in a control where inputs are uncertain.

use serde_json::{Value, json};

use super::field::{FieldSpread, WaySpread};
use crate::{
    files::words::{counted, millimetres, or_dash, position},
    page::headline::{KeyNumber, State, Verdict},
    process::uncertainty::{Draws, Uncertainty},
    questions::spread_report::{self, SpreadCounts, quantile_text, verdict_word},
};

/// A field of corrections, and how sentences name it.
pub(crate) struct Field<'a> {
    /// What was found.
    pub spread: &'a FieldSpread,
    /// What is uncertain.
    pub uncertainty: &'a Uncertainty,
    /// Name of the machine.
    pub machine: &'a str,
    /// What corrects, behind "with": "a table of 5 × 5 × 5 points".
    pub corrector: String,
    /// Largest distance found with nominal numbers, mm.
    pub nominal_mm: f64,
    /// Largest distance that is within tolerance, mm.
    pub tolerance_mm: Option<f64>,
}

/// Formats a probability that is a share of the draws.
pub(crate) fn share_text(share: f64) -> String {
    spread_report::share_text(share, Draws::PER_SCRAMBLE)
}

impl Field<'_> {
    /// The largest distance without correction.
    pub fn plain(&self) -> &WaySpread {
        &self.spread.ways[0]
    }

    /// The largest distance with the correction.
    pub fn corrected(&self) -> &WaySpread {
        &self.spread.ways[1]
    }

    /// Returns the verdict in a few words.
    pub fn state(&self) -> Verdict {
        match self.corrected().largest.within_tolerance.filter(|_| self.tolerance_mm.is_some()) {
            _ if self.is_probably_worse() => Verdict::new(State::Bad, "Probably worse than no correction"),
            Some(share) => spread_report::probable_state(share),
            None => Verdict::new(State::Open, "No tolerance given"),
        }
    }

    /// Returns the verdict: what is left on machines as they may be, then nominally.
    pub fn verdict(&self) -> String {
        let (corrected, plain) = (self.corrected(), &self.plain().largest);
        let (worse, better) = (share_text(corrected.worse), share_text(corrected.better));
        let worse = format!("Probably worse than no correction, with {worse} probability. ");
        let first = if self.is_probably_worse() { &worse } else { "" };
        let condition = spread_report::condition(Some(self.uncertainty));
        let (begin, within) = match (corrected.largest.within_tolerance, self.tolerance_mm) {
            (Some(share), Some(tolerance)) => (
                format!("{}{condition}: with", verdict_word(share)),
                format!("within {tolerance} mm with {} probability, ", share_text(share)),
            ),
            _ => ("With".into(), String::new()),
        };
        format!(
            "{first}{begin} {} the tool of {} stays {within}within {} with 95 % ({} without correction; {} if all numbers were exact), anywhere in the box. It is \
             better than no correction with {better} probability.",
            self.corrector,
            self.machine,
            quantile_text(corrected.largest.p95_mm),
            quantile_text(plain.p95_mm),
            millimetres(self.nominal_mm, 3),
        )
    }

    /// Returns how the distributions were found, and what each way to correct leaves, called by `names` in their order.
    pub fn details(&self, names: &[&str]) -> String {
        let mut text = format!(
            "With {}: each of {} is one machine and one factor of the force for the whole box, solved in full at {} under loads up to the largest, {} in all.\n",
            spread_report::counted_inputs(self.uncertainty),
            counted(Draws::PER_SCRAMBLE, "draw"),
            counted(self.spread.points.len(), "position"),
            counted(self.spread.cases, "case"),
        );
        for (number, (way, name)) in self.spread.ways.iter().zip(names).enumerate() {
            let ([x, y, z], better, worse) = (way.worst_position_mm, share_text(way.better), share_text(way.worse));
            let compared = format!(
                "; by more than 0.5 % smaller than without correction with {better} probability, larger with {worse}"
            );
            text += &format!(
                "Largest distance {name}: at most {} with 95 % probability, {} with 50 %; the largest 95 % quantile of a position is at {}{}.\n",
                quantile_text(way.largest.p95_mm),
                quantile_text(way.largest.median_mm),
                position(x, y, z),
                if number > 0 { &compared } else { "" }
            );
        }
        text
    }

    /// Returns whether the correction is probably worse than none.
    pub fn is_probably_worse(&self) -> bool {
        self.corrected().worse > 0.5
    }

    /// Returns the 95 % quantiles with and without correction as key numbers.
    pub fn numbers(&self) -> [KeyNumber; 2] {
        let number = |way: &WaySpread, how: &str, against: String| {
            let size = or_dash(way.largest.p95_mm, |own| millimetres(own, 3));
            let what = format!("largest distance in the box not exceeded with 95 % probability, {how}");
            KeyNumber::new(&size, what, against)
        };
        let better = format!("better than without correction with {} probability", share_text(self.corrected().better));
        [number(self.corrected(), "with correction", better), number(self.plain(), "without", String::new())]
    }

    /// Returns what is counted of the distributions with the correction at the check positions.
    fn counts(&self) -> SpreadCounts {
        let mut counts = SpreadCounts::default();
        self.spread.points.iter().for_each(|point| counts.add(&point.ways[1]));
        counts
    }

    /// Returns what the distributions rest on, a sentence per line.
    pub fn cautions(&self) -> String {
        spread_report::cautions(Some(self.uncertainty), &self.counts(), "check position", None)
    }

    /// Returns what varies, and the distributions, as JSON.
    pub fn json(&self) -> Value {
        let mut all = spread_report::json(self.uncertainty, &self.counts());
        all["draws"] = json!(Draws::PER_SCRAMBLE);
        all["field"] = json!(self.spread);
        all
    }
}
