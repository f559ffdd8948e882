//! What a reader takes away at a glance: the answer as a sentence, at most three numbers with what they are measured
//! against, and what must be known with them. The first screen of a page and the closing words on the terminal are made of it.

use serde::{Deserialize, Serialize};

use crate::files::words::with_unit;

/// The first screen of an answer.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Headline {
    /// The part of the work that was not solved, and why, if any was not.
    pub unsolved: Option<String>,
    /// The answer as somebody would say it.
    pub sentence: String,
    /// At most three.
    pub numbers: Vec<KeyNumber>,
    /// From how much the answer was computed.
    pub basis: String,
    /// What must be known with the answer, a sentence each.
    pub cautions: Vec<String>,
}

/// A number of the first screen.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct KeyNumber {
    /// As shown, without unit.
    pub value: String,
    /// Its unit, empty if it has none.
    pub unit: String,
    /// What it is, and over what it is taken.
    pub what: String,
    /// What it is measured against: a tolerance, the best, another place.
    pub against: String,
    /// Where it stands in a table, if it does.
    pub found: Option<InTable>,
}

/// The extreme of a column of a table.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct InTable {
    /// CSV file.
    pub file: String,
    /// Columns; of several, the largest size in a row counts.
    pub columns: Vec<String>,
    /// Only rows that have these values in these columns.
    pub rows: Vec<[String; 2]>,
    /// Which of the rows.
    pub extreme: Extreme,
    /// The value, with all digits.
    pub value: f64,
}

/// Which of the rows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Extreme {
    /// The smallest.
    Smallest,
    /// The largest.
    Largest,
}

impl Headline {
    /// An answer in a sentence, computed from `basis`.
    pub fn new(sentence: impl Into<String>, basis: impl Into<String>) -> Self {
        Self { sentence: sentence.into(), basis: basis.into(), ..Self::default() }
    }

    /// With what must be known with it, one sentence a line of `text`.
    #[must_use]
    pub fn with_cautions(mut self, text: &str) -> Self {
        self.cautions.extend(text.lines().filter(|line| !line.trim().is_empty()).map(String::from));
        self
    }

    /// With the numbers there are.
    #[must_use]
    pub fn with_all(mut self, numbers: impl IntoIterator<Item = KeyNumber>) -> Self {
        self.numbers.extend(numbers);
        self
    }

    /// With one number more.
    #[must_use]
    pub fn with(mut self, number: KeyNumber) -> Self {
        self.numbers.push(number);
        self
    }
}

impl KeyNumber {
    /// A number with its unit, such as `1.712 mm`: what it is, and what it is measured against.
    pub fn new(shown: &str, what: impl Into<String>, against: impl Into<String>) -> Self {
        let (value, unit) = match shown.rsplit_once(' ') {
            Some((value, unit)) => (value, unit),
            None => match shown.strip_suffix('°') {
                Some(value) => (value, "°"),
                None => (shown, ""),
            },
        };
        Self { value: value.into(), unit: unit.into(), what: what.into(), against: against.into(), found: None }
    }

    /// As it stands in a table.
    #[must_use]
    pub fn found(mut self, found: InTable) -> Self {
        self.found = Some(found);
        self
    }

    /// With its unit.
    pub fn shown(&self) -> String {
        with_unit(&self.value, &self.unit)
    }
}

impl InTable {
    /// The `extreme` of `columns` in `file` over the rows that have `rows`.
    pub fn new<C: Into<String>>(
        file: &str,
        columns: impl IntoIterator<Item = C>,
        rows: &[[&str; 2]],
        extreme: Extreme,
        value: f64,
    ) -> Self {
        Self {
            file: file.into(),
            columns: columns.into_iter().map(Into::into).collect(),
            rows: rows.iter().map(|pair| pair.map(String::from)).collect(),
            extreme,
            value,
        }
    }
}
