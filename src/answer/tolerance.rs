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
    pub fn words(self, tolerance_mm: Option<f64>, whole: &str) -> Option<String> {
        let (tolerance, share) = (tolerance_mm?, self.get()?);
        let solved = if self.unknown == 0.0 { "" } else { ", as far as solved" };
        if share == 0.0 {
            return Some(format!("out of tolerance ({tolerance} mm) everywhere{solved}"));
        }
        let part = if share == 1.0 { "all".into() } else { percent(share) };
        Some(format!("within tolerance ({tolerance} mm) {}{solved}", whole.replace('…', &part)))
    }

    /// Returns [`words`](Self::words) as a sentence about the tool without compensation; empty where there are none.
    pub fn sentence(self, tolerance_mm: Option<f64>, whole: &str) -> String {
        let share = self.words(tolerance_mm, whole);
        share.map_or_else(String::new, |share| format!("Without compensation the tool is {share}.\n"))
    }
}
