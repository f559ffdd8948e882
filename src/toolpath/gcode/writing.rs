//! How a program with moved points is to be written.

use crate::toolpath::{NumberFormat, RewriteError};

/// Decimals, and how far from its points a program may be written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Writing {
    /// Decimals of the coordinates.
    pub format: NumberFormat,
    /// How far from a corrected point, mm, the line or arc that stands for it may pass, besides rounding. At 0, a block that one
    /// block does not replace to a unit of the last decimal becomes a line to each of its points.
    pub tolerance_mm: f64,
    /// Whether an arc that is flat may be written with a rise; otherwise it becomes lines where its corrections rise.
    pub helical_arcs: bool,
}

impl Writing {
    /// With `tolerance_mm`, arcs helical where they must be.
    #[must_use]
    pub fn within(tolerance_mm: f64, format: NumberFormat) -> Writing {
        Writing { format, tolerance_mm, helical_arcs: true }
    }

    pub(super) fn checked(self) -> Result<Writing, RewriteError> {
        match self.tolerance_mm.is_finite() && self.tolerance_mm >= 0.0 {
            true => Ok(self),
            false => Err(RewriteError::Tolerance { tolerance_mm: self.tolerance_mm }),
        }
    }
}

/// To a unit of the last decimal, a line to each point of a block that is split.
impl From<NumberFormat> for Writing {
    fn from(format: NumberFormat) -> Writing {
        Writing::within(0.0, format)
    }
}
