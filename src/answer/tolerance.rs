//! A tolerance: what is said of it, and where it is kept.

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

    /// Where it is kept, beside a number: `part` is such as "at 12 % of the points".
    pub fn kept(self, part: &str) -> String {
        format!("tolerance {} mm: kept {part}", self.0)
    }

    /// The same as a sentence of what is not compensated.
    pub fn kept_without_compensation(self, part: &str) -> String {
        format!("The tolerance of {} mm is kept, without compensation, {part}.\n", self.0)
    }
}

/// The share of a box, a path or of places in which something is kept, of where that is known.
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
