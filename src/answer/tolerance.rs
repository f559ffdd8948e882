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

    /// Where it is met, beside a number: in the `share` of a `whole` such as "at … of the points".
    pub fn met(self, share: f64, whole: &str) -> String {
        let Self(tolerance) = self;
        match share {
            0.0 => format!("out of tolerance ({tolerance} mm) everywhere"),
            1.0 => format!("within tolerance ({tolerance} mm) everywhere"),
            _ => format!("within tolerance ({tolerance} mm) {}", whole.replace('…', &percent(share))),
        }
    }

    /// The same as a sentence of what is not compensated.
    pub fn met_without_compensation(self, share: f64, whole: &str) -> String {
        format!("Without compensation the tool is {}.\n", self.met(share, whole))
    }
}

/// The share of a box, a path or of places in which a tolerance is met, of where that is known.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ShareWithin {
    within: f64,
    known: f64,
}

impl ShareWithin {
    /// Takes a place that stands for this `part` of all.
    pub fn add(&mut self, part: f64, is_within: bool) {
        self.known += part;
        self.within += if is_within { part } else { 0.0 };
    }

    /// The share; `None` where nothing is known.
    pub fn get(self) -> Option<f64> {
        (self.known > 0.0).then(|| self.within / self.known)
    }
}
