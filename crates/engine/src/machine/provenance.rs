//! Where the numbers of a machine come from, and how far they may be trusted.

use serde::{Deserialize, Serialize};

/// How far a number may be trusted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Grade {
    /// In a paper or a standard. Without an interval a stiffness varies by 60 %, an elastic constant by 5 %, a mass by 10 %.
    Published,
    /// In a maker's data sheet. Without an interval a stiffness varies by 30 %, an elastic constant or a mass by 5 %.
    DataSheet,
    /// Found so that the model meets other numbers. Without an interval a stiffness varies by 20 %, an elastic constant or a mass by 10 %.
    Identified,
    /// Taken because it is likely. Without an interval a stiffness varies by 60 %, an elastic constant or a mass by 30 %.
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

/// Source of some of a machine's numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct Provenance {
    /// Which numbers.
    pub what: String,
    /// How far they may be trusted.
    pub grade: Grade,
    /// The source: a paper, data sheet or person.
    pub source: String,
    /// Names of these numbers, or their parts before a dot; empty where only `what` says it.
    pub parameters: Vec<String>,
    /// 95 % interval of the one number named, in the unit of its parameter.
    pub interval: Option<[f64; 2]>,
}

impl Provenance {
    /// Length of the longest of its patterns that name `parameter`; `None` if none does.
    pub(super) fn match_length(&self, parameter: &str) -> Option<usize> {
        let fitting = self.parameters.iter().filter(|pattern| is_named(parameter, pattern));
        fitting.map(String::len).max()
    }
}

/// Whether `pattern` is the name of `parameter`, or its part before one of its dots.
pub(super) fn is_named(parameter: &str, pattern: &str) -> bool {
    parameter.strip_prefix(pattern).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
}
