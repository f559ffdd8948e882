//! How rows end: with an answer, or why they have none.

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

/// Statuses of points; their place is their number in images. New ones go to the end.
#[cfg(feature = "report")]
pub(crate) const STATUSES: [&str; 15] = [
    SOLVED,
    "unreachable",
    "unstable",
    "buckled",
    "singular",
    "not_converged",
    "slow",
    "diverged",
    "uncontrollable",
    "bad_step_length",
    "applied",
    "reached",
    "below_to_limit",
    "no_equilibrium",
    "snap_through",
];

/// Whether a row with this `status` was found out; pages mark the others.
#[cfg(feature = "report")]
pub(crate) fn is_found(status: &str) -> bool {
    [SOLVED, "converged"].contains(&status)
}

/// Whether a row with this `status` is what was asked for: found out, or applied as it was given.
#[cfg(feature = "report")]
pub(crate) fn is_answer(status: &str) -> bool {
    is_found(status) || status == "applied"
}

/// Word for tables of what was solved or not.
pub fn status_of<T>(answer: &Result<T, Failure>) -> &str {
    answer.as_ref().map_or_else(|failure| &*failure.status, |_| SOLVED)
}

impl From<Unreachable> for Failure {
    fn from(unreachable: Unreachable) -> Self {
        Failure { status: "unreachable".into(), reason: unreachable.to_string() }
    }
}
