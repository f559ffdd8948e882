//! The length unit of a program.

use serde::Deserialize;

/// The length unit of a program's coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Deserialize)]
pub enum LengthUnit {
    /// Millimetres (G21).
    #[default]
    #[serde(rename = "mm")]
    Millimetre,
    /// Inches of 25.4 mm (G20).
    #[serde(rename = "inch")]
    Inch,
}

impl LengthUnit {
    /// How many mm one unit is.
    #[must_use]
    pub fn mm(self) -> f64 {
        match self {
            LengthUnit::Millimetre => 1.0,
            LengthUnit::Inch => 25.4,
        }
    }

    /// Its name: mm or inch.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            LengthUnit::Millimetre => "mm",
            LengthUnit::Inch => "inch",
        }
    }
}
