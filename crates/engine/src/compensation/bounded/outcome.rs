//! Result of a bounded correction.

use nalgebra::Vector3;
use serde::Serialize;

use super::{
    super::outcome::CompensationStatus,
    limits::{LimitKind, Side},
};

/// A corrected path.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BoundedPath {
    /// Result for each task, in order.
    pub points: Vec<BoundedPoint>,
    /// The path as a whole.
    pub summary: BoundedSummary,
}

/// Result for one task.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub enum BoundedPoint {
    /// It takes part in the correction.
    Corrected(CorrectedPoint),
    /// It is left out, for this reason: it cannot be reached, or the loaded machine has no equilibrium there. Limits on
    /// the change of the correction do not apply across it.
    LeftOut(CompensationStatus),
}

impl BoundedPoint {
    /// The correction; `None` if the point is left out.
    pub fn corrected(&self) -> Option<&CorrectedPoint> {
        match self {
            BoundedPoint::Corrected(point) => Some(point),
            BoundedPoint::LeftOut(_) => None,
        }
    }
}

/// A point that takes part, as the nonlinear simulation finds it at the corrected drives.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CorrectedPoint {
    /// Drive positions ρ to command, mm or rad.
    pub drives: Vec<f64>,
    /// Δρ: `drives` less those of the nominal inverse kinematics, mm or rad.
    pub correction: Vec<f64>,
    /// Length ‖e‖₂ of the task error, mm; rotations that the drives control count at the machine's characteristic length.
    pub error: f64,
    /// Position error of the compensated point, O axes, mm.
    pub position_error: Vector3<f64>,
    /// Rotation of the platform from the wanted orientation, rotation vector in O axes, rad.
    pub residual_rotation: Vector3<f64>,
    /// Forces of the drives τ, N or N·mm.
    pub drive_forces: Vec<f64>,
    /// Limits that bind at this point.
    pub binding: Vec<Binding>,
}

/// A limit that binds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Binding {
    /// Index of the drive, machine order.
    pub drive: usize,
    /// Which limit; [`LimitKind::Change`] is the change from the point before.
    pub kind: LimitKind,
    /// Which end of it.
    pub side: Side,
    /// Shadow price: mm by which the objective (rms or worst error) would fall per unit (mm, rad, N, N·mm) by which this
    /// limit were relaxed at this point alone; to first order. Zero where the limit binds without raising the objective.
    pub price: f64,
}

/// Shadow price of a limit that is the same along the whole path.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Price {
    /// Index of the drive, machine order.
    pub drive: usize,
    /// Which limit, both ends together.
    pub kind: LimitKind,
    /// mm by which the objective would fall per unit (mm, rad, N, N·mm) of relaxation along the whole path: sum of [`Binding::price`].
    pub price: f64,
    /// Points at which it binds.
    pub points: usize,
}

/// Root mean square and largest length of the task error over the points, mm.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Errors {
    /// `√(Σ ‖e_k‖² / N)`.
    pub rms: f64,
    /// `max ‖e_k‖`.
    pub worst: f64,
}

impl Errors {
    /// Root mean square and maximum of `lengths`, the lengths of the points' task errors, mm; zero if there are none.
    pub(super) fn from_lengths(lengths: impl Iterator<Item = f64>) -> Self {
        let (mut squares, mut worst, mut count) = (0.0, 0.0f64, 0);
        for length in lengths {
            squares += length * length;
            worst = worst.max(length);
            count += 1;
        }
        Self { rms: if count > 0 { (squares / f64::from(count)).sqrt() } else { 0.0 }, worst }
    }
}

/// How the search for the corrections ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum BoundedStatus {
    /// The unbounded corrections keep all limits and were returned.
    Unbounded,
    /// The nonlinear errors stopped improving at the solution of their own linearisation.
    Converged,
    /// No step toward the solution of the linearisation improved the nonlinear errors, or the convex solver gave up; the
    /// corrections keep all limits, but better ones may exist.
    Stalled,
    /// The iterations were used up while the errors still improved.
    Slow,
    /// No point of the path takes part.
    Empty,
}

impl BoundedStatus {
    /// Word used in tables.
    pub fn label(self) -> &'static str {
        match self {
            BoundedStatus::Unbounded => "unbounded",
            BoundedStatus::Converged => "converged",
            BoundedStatus::Stalled => "stalled",
            BoundedStatus::Slow => "slow",
            BoundedStatus::Empty => "empty",
        }
    }
}

/// A corrected path in a few numbers.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BoundedSummary {
    /// How the search ended.
    pub status: BoundedStatus,
    /// Errors at the nominal command, over the points that have an equilibrium there; zero if there are none.
    pub before: Errors,
    /// Errors at the corrected drives, over the points that take part; zero if there are none.
    pub after: Errors,
    /// Linearisations of the path.
    pub iterations: usize,
    /// Interior-point iterations of the convex solver, over all linearisations.
    pub convex_iterations: usize,
    /// Whether the convex solver reached its full accuracy every time; if not, it was nearly so (10⁻⁶ instead of 10⁻¹⁰
    /// for the root mean square, 10⁻⁵ instead of 10⁻⁸ for the worst error).
    pub is_accurate: bool,
    /// Largest excess of a drive's force over its limit, as a share of the limit; at most
    /// [`BoundedSettings::force_tolerance`](super::BoundedSettings::force_tolerance).
    pub force_excess: f64,
    /// Shadow prices of the limits that bind.
    pub prices: Vec<Price>,
}
