//! Errors of a bounded correction: limits that make no sense or exclude one another.

use super::{super::outcome::CompensationStatus, limits::LimitKind};

/// Limits that make no sense, exclude one another, or ask for more than the machine can do. Points are counted from 0.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum BoundedError {
    /// A list of limits of the wrong length.
    #[error("{limit}: {got} values for {expected} drives")]
    Count {
        /// Which limit.
        limit: LimitKind,
        /// Number of values.
        got: usize,
        /// Number of drives.
        expected: usize,
    },
    /// A limit that is not one.
    #[error("{limit} of drive {drive}: expected {expected}, got {value}")]
    Value {
        /// Which limit.
        limit: LimitKind,
        /// Name of the drive.
        drive: String,
        /// What was given.
        value: String,
        /// What makes sense.
        expected: &'static str,
    },
    /// The nominal position is farther outside the travel than the drive may be corrected.
    #[error(
        "drive {drive} at point {point}: ρ = {nominal:.3} {unit} must change by {needed:.3} {unit} into its travel of \
         {:.3} to {:.3} {unit}, but the limit on the correction is {limit:.3} {unit}", travel.0, travel.1
    )]
    Travel {
        /// Name of the drive.
        drive: String,
        /// Index of the point.
        point: usize,
        /// ρ of the nominal inverse kinematics.
        nominal: f64,
        /// Smallest and largest ρ.
        travel: (f64, f64),
        /// Least |Δρ| that brings ρ into the travel.
        needed: f64,
        /// Largest |Δρ| allowed.
        limit: f64,
        /// mm or rad.
        unit: &'static str,
    },
    /// The travel demands more change of the correction along the path than is allowed.
    #[error(
        "drive {drive} from point {from} to {to}: its travel and the limit on its correction make Δρ change by \
         {needed:.4} {unit}, but the limit on the change from point to point allows {:.4} {unit} ({} × {limit:.4} {unit})",
        (to - from) as f64 * limit, to - from
    )]
    Change {
        /// Name of the drive.
        drive: String,
        /// Index of the point at which one end of the correction is bounded.
        from: usize,
        /// Index of the point at which the other is.
        to: usize,
        /// Least change of Δρ between them.
        needed: f64,
        /// Largest change per point.
        limit: f64,
        /// mm or rad.
        unit: &'static str,
    },
    /// A drive's force stays above its limit whatever the allowed corrections.
    #[error(
        "drive {drive} at point {point}: its force cannot be brought below {least:.3} {unit}, the force limit is \
         {limit:.3} {unit}{}",
        conflict_note(conflicts)
    )]
    Force {
        /// Name of the drive.
        drive: String,
        /// Index of the point.
        point: usize,
        /// Least |τ| found.
        least: f64,
        /// Largest |τ| allowed.
        limit: f64,
        /// N or N·mm.
        unit: &'static str,
        /// Limits any one of which, taken away, would let the force limits be kept, as far as linear sensitivities tell.
        conflicts: Vec<LimitKind>,
    },
    /// No equilibrium was found at the corrections from which the search starts.
    #[error("point {point}: no start for the search: {}", status.label())]
    Start {
        /// Index of the point.
        point: usize,
        /// What went wrong there.
        status: CompensationStatus,
    },
    /// The convex solver gave up.
    #[error("the convex solver ended with {status}")]
    Convex {
        /// Its own word.
        status: String,
    },
}

impl From<BoundedError> for crate::input::error::Error {
    fn from(fault: BoundedError) -> Self {
        Self::Argument { argument: "limits".into(), problem: fault.to_string() }
    }
}

/// Note on the limits that conflict with a force limit.
fn conflict_note(conflicts: &[LimitKind]) -> String {
    match conflicts {
        [] => "; no other limit alone is the reason".into(),
        _ => {
            let names: Vec<String> = conflicts.iter().map(|kind| format!("the {kind}")).collect();
            format!("; the force limit could be kept without {}", names.join(" or without "))
        }
    }
}
