//! Status words of result rows: solved, or why not.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};

use crate::{
    compensation::CompensationStatus,
    input::error::Error,
    machine::{Machine, Unreachable},
};

/// Reason why a point has no result.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Failure {
    /// Status word for tables.
    pub status: Cow<'static, str>,
    /// Reason in words, with numbers.
    pub reason: String,
}

impl Failure {
    /// Why a point has no result by the status of its compensation on `machine`.
    pub(crate) fn of(status: &CompensationStatus, machine: &Machine) -> Self {
        Self { status: status.label().into(), reason: status.reason(machine) }
    }

    /// Why there is no machine with values that `error` refuses.
    pub(crate) fn no_machine(error: &Error) -> Self {
        Self { status: "no_equilibrium".into(), reason: error.to_string() }
    }

    /// The same with `words` before its reason, which say of which machine it is; of one that needs none they are empty.
    pub(crate) fn on(self, words: &str) -> Self {
        if words.is_empty() { self } else { Self { reason: format!("{words}: {}", self.reason), ..self } }
    }
}

/// Status word of a solved point.
pub const SOLVED: &str = "solved";

/// Statuses of points; the index of each is its number in images. New ones go to the end.
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

/// Returns whether `status` is that of a solved row; pages mark all others.
#[cfg(feature = "report")]
pub(crate) fn is_solved_status(status: &str) -> bool {
    [SOLVED, "converged"].contains(&status)
}

/// Returns whether `status` is that of a row with a result: solved, or applied as given.
#[cfg(feature = "report")]
pub(crate) fn is_result_status(status: &str) -> bool {
    is_solved_status(status) || status == "applied"
}

/// Returns the status word of a result or failure.
pub fn status_of<T>(answer: &Result<T, Failure>) -> &str {
    answer.as_ref().map_or_else(|failure| &*failure.status, |_| SOLVED)
}

impl From<Unreachable> for Failure {
    /// Returns the failure of a pose that cannot be reached.
    fn from(unreachable: Unreachable) -> Self {
        Failure { status: "unreachable".into(), reason: unreachable.to_string() }
    }
}
