//! A tolerance: what is said of it, and where it is met.

use crate::files::words::percent;

/// How far the tool may be from where it should be, mm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tolerance(pub f64);

impl Tolerance {
    /// What a length in mm is against it.
    pub fn against(self, length_mm: f64) -> String {
        let Self(tolerance) = self;
        match length_mm <= tolerance {
            true => format!("within the tolerance of {tolerance} mm"),
            false => format!("{:.1} times the tolerance of {tolerance} mm", length_mm / tolerance),
        }
    }

    /// That a picture has a line where it is reached.
    pub fn line(self) -> String {
        format!("; line: tolerance {} mm", self.0)
    }
}

/// The share of a box, a path or of places in which a tolerance is met, of where that is known.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ShareWithin {
    within: f64,
    known: f64,
    unknown: f64,
}

impl ShareWithin {
    /// Takes a place that stands for this `part` of all; `None` where it is not known.
    pub fn add(&mut self, part: f64, is_within: impl Into<Option<bool>>) {
        match is_within.into() {
            None => self.unknown += part,
            Some(is_within) => {
                self.known += part;
                self.within += if is_within { part } else { 0.0 };
            }
        }
    }

    /// Of all of a whole, such a share.
    pub fn of_all(share: f64) -> Self {
        Self { within: share, known: 1.0, unknown: 0.0 }
    }

    /// The share; `None` where nothing is known.
    pub fn get(self) -> Option<f64> {
        (self.known > 0.0).then(|| self.within / self.known)
    }

    /// In which share of a `whole`, such as "at … of the points", the tolerance is met, beside a number; `None` without a tolerance, or where
    /// nothing is known.
    pub fn words(self, tolerance_mm: Option<f64>, whole: &str) -> Option<String> {
        let (tolerance, share) = (tolerance_mm?, self.get()?);
        let solved = if self.unknown == 0.0 { "" } else { ", as far as solved" };
        if share == 0.0 {
            return Some(format!("out of tolerance ({tolerance} mm) everywhere{solved}"));
        }
        let part = if share == 1.0 { "all".into() } else { percent(share) };
        Some(format!("within tolerance ({tolerance} mm) {}{solved}", whole.replace('…', &part)))
    }

    /// The same as a sentence of what is not compensated.
    pub fn sentence(self, tolerance_mm: Option<f64>, whole: &str) -> String {
        let met = self.words(tolerance_mm, whole);
        met.map_or_else(String::new, |met| format!("Without compensation the tool is {met}.\n"))
    }
}
