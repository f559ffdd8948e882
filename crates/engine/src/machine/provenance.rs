//! Where the numbers of a machine come from, and how far they may be trusted.

use serde::{Deserialize, Serialize};

/// How far a number may be trusted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
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
#[derive(Debug, Clone, PartialEq)]
pub struct Provenance {
    /// Which numbers.
    pub what: String,
    /// How far they may be trusted.
    pub grade: Grade,
    /// Who says so.
    pub source: String,
    /// Names of these numbers, or what the names begin with; empty where only `what` says it.
    pub parameters: Vec<String>,
    /// 95 % interval of the one number named, in the unit of its parameter.
    pub interval: Option<[f64; 2]>,
}

impl Provenance {
    /// How many letters of `parameter` it names: all or its beginning, up to a dot; `None` if it is about others.
    pub(super) fn names(&self, parameter: &str) -> Option<usize> {
        let fitting = self.parameters.iter().filter(|pattern| is_named(parameter, pattern));
        fitting.map(String::len).max()
    }
}

/// Whether `pattern` is the name of a parameter, or its beginning up to a dot.
pub(super) fn is_named(parameter: &str, pattern: &str) -> bool {
    parameter.strip_prefix(pattern).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
}
