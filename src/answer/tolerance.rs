//! Position tolerance of the tool: its wording, and the share of a workspace or path that is within it.

use crate::files::words::percent;

/// Largest allowed distance of the tool from its target, mm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tolerance(pub f64);

impl Tolerance {
    /// Compares a length in mm with the tolerance, in words, such as "within the tolerance of 0.1 mm".
    pub fn against(self, length_mm: f64) -> String {
        let Self(tolerance) = self;
        match length_mm <= tolerance {
            true => format!("within the tolerance of {tolerance} mm"),
            false => format!("{:.1} times the tolerance of {tolerance} mm", length_mm / tolerance),
        }
    }

    /// Returns the end of a caption that says that a map is hatched beyond the tolerance.
    pub fn hatched(self) -> String {
        format!("; hatched: out of tolerance ({} mm)", self.0)
    }
}

/// Share of a box, a path or a number of places in which a tolerance is met, of the part where that is known.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ShareWithin {
    within: f64,
    known: f64,
    unknown: f64,
}

impl ShareWithin {
    /// Adds a `part` of the whole, and whether the tolerance is met there; `None` where that is not known.
    pub fn add(&mut self, part: f64, is_within: impl Into<Option<bool>>) {
        match is_within.into() {
            None => self.unknown += part,
            Some(is_within) => {
                self.known += part;
                self.within += if is_within { part } else { 0.0 };
            }
        }
    }

    /// Returns the share `share` of a whole of which all is known.
    pub fn of_all(share: f64) -> Self {
        Self { within: share, known: 1.0, unknown: 0.0 }
    }

    /// Returns the share of the known part within the tolerance; `None` where nothing is known.
    pub fn get(self) -> Option<f64> {
        (self.known > 0.0).then(|| self.within / self.known)
    }

    /// Returns in which share of a `whole`, such as "at … of the points", the tolerance is met; `None` without tolerance or known part.
    pub fn text(self, tolerance_mm: Option<f64>, whole: &str) -> Option<String> {
        self.share_text(&format!("tolerance ({} mm)", tolerance_mm?), whole)
    }

    /// Returns in which share of a `whole` what is `held_to` is met; `None` where nothing is known.
    fn share_text(self, held_to: &str, whole: &str) -> Option<String> {
        let share = self.get()?;
        let solved = if self.unknown == 0.0 { "" } else { ", as far as solved" };
        if share == 0.0 {
            return Some(format!("out of {held_to} everywhere{solved}"));
        }
        let part = if share == 1.0 { "all".into() } else { percent(share) };
        Some(format!("within {held_to} {}{solved}", whole.replace('…', &part)))
    }

    /// Holds the worst length of the whole, mm, against the tolerance, and says in which share it is met: "3.4 times the tolerance of 0.5 mm, within
    /// it in 1.6 % of the box"; [`text`](Self::text) where it is met everywhere, `None` without tolerance or known part.
    pub fn against(self, tolerance_mm: Option<f64>, worst_mm: f64, whole: &str) -> Option<String> {
        match worst_mm <= tolerance_mm? {
            true => self.text(tolerance_mm, whole),
            false => Some(format!("{}, {}", Tolerance(tolerance_mm?).against(worst_mm), self.share_text("it", whole)?)),
        }
    }

    /// Returns [`text`](Self::text) as a sentence about the tool without compensation; empty where there are none.
    pub fn sentence(self, tolerance_mm: Option<f64>, whole: &str) -> String {
        let share = self.text(tolerance_mm, whole);
        share.map_or_else(String::new, |share| format!("Without compensation the tool is {share}.\n"))
    }
}
