//! Why a point has no answer.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};

use crate::machine::Unreachable;

/// Why a point has no answer.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Failure {
    /// Word for tables.
    pub status: Cow<'static, str>,
    /// In words, with numbers.
    pub reason: String,
}

/// Word for tables of something that was solved.
pub const SOLVED: &str = "solved";

/// Word for tables of what was solved or not.
pub fn status_of<T>(answer: &Result<T, Failure>) -> &str {
    answer.as_ref().map_or_else(|failure| &*failure.status, |_| SOLVED)
}

impl From<Unreachable> for Failure {
    fn from(unreachable: Unreachable) -> Self {
        Failure { status: "unreachable".into(), reason: unreachable.to_string() }
    }
}
