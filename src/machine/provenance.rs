//! Where the numbers of a machine come from, and how far they may be trusted.

use serde::Deserialize;

/// How far a number may be trusted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Grade {
    /// In a paper or a standard.
    Published,
    /// In a maker's data sheet.
    DataSheet,
    /// Found so that the model meets other numbers.
    Identified,
    /// Taken because it is likely.
    Assumed,
}

impl Grade {
    /// The grade as machine files write it.
    pub fn label(self) -> &'static str {
        match self {
            Self::Published => "published",
            Self::DataSheet => "data_sheet",
            Self::Identified => "identified",
            Self::Assumed => "assumed",
        }
    }
}

/// Some of a machine's numbers and where they come from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Provenance {
    /// Which numbers.
    pub what: String,
    /// How far they may be trusted.
    pub grade: Grade,
    /// Who says so.
    pub source: String,
}
