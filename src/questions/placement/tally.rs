//! What is known of a path after some of its points.
//!
//! Every number can only get worse as points are added: largest values grow, least values fall, and sums over the path
//! are taken with each point's share of the whole path, not of the points seen. What is known of a part of the path is
//! therefore a bound on the whole; see [`super::sweep`]. Shares add up without rounding, so a path all of whose points are
//! out of tolerance is so by exactly its share.

use serde::{Deserialize, Serialize};

use super::metric::{Metric, Metrics};

/// What one point of a path shows, or the worst that several do.
#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize)]
pub(super) struct Seen {
    /// Distance from the path at the nominal command, mm.
    pub deflection: f64,
    /// Largest |Δρ|, mm or degrees; of slides, if there are slides and hinges.
    pub correction: f64,
    /// Largest |τ|, N or N·mm; of slides, if there are slides and hinges.
    pub force: f64,
    /// Largest |Δρ|, degrees, and |τ|, N·mm, of hinges beside slides.
    pub hinges: Option<[f64; 2]>,
    /// Smallest share of a force limit left.
    pub margin: Option<f64>,
    /// Superposition error, mm.
    pub superposition_error: f64,
    /// Parts of the deflection, mm: across the direction of motion, and normal to the wall.
    pub across: [f64; 2],
    /// Smallest eigenvalue of the loaded stiffness, N/mm.
    pub stability: Option<f64>,
    /// Whether an exact correction was sought and not found.
    pub is_uncorrected: bool,
}

/// Which numbers are computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Needs {
    /// The exact correction.
    pub correction: bool,
    /// The sources one by one.
    pub superposition_error: bool,
    /// Eigenvalues of the stiffness.
    pub stability: bool,
    /// The correction within limits.
    pub bounded: bool,
    /// The parts of the deflection across the direction of motion.
    pub across: bool,
}

impl Needs {
    /// What `metrics` need.
    pub fn of(metrics: &[Metric]) -> Self {
        let any = |wanted: &[Metric]| metrics.iter().any(|metric| wanted.contains(metric));
        Self {
            correction: any(&[
                Metric::WorstCorrection,
                Metric::WorstDriveForce,
                Metric::WorstHingeCorrection,
                Metric::WorstHingeTorque,
                Metric::ForceMargin,
            ]),
            superposition_error: any(&[Metric::SuperpositionError]),
            stability: any(&[Metric::StabilityMargin]),
            bounded: metrics.iter().any(|metric| metric.is_bounded()),
            across: metrics.iter().any(|metric| metric.is_across()),
        }
    }
}

/// Sums and extremes over the points seen.
#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize)]
pub(super) struct Tally {
    worst: Seen,
    /// Σ share · deflection².
    squares: f64,
    /// Share of the path out of tolerance.
    outside: f64,
    /// Σ share · part² of the parts across.
    across_squares: [f64; 2],
}

fn least(a: Option<f64>, b: Option<f64>) -> Option<f64> {
    match (a, b) {
        (Some(a), Some(b)) => Some(a.min(b)),
        (a, b) => a.or(b),
    }
}

fn most(a: Option<[f64; 2]>, b: Option<[f64; 2]>) -> Option<[f64; 2]> {
    match (a, b) {
        (Some(a), Some(b)) => Some([a[0].max(b[0]), a[1].max(b[1])]),
        (a, b) => a.or(b),
    }
}

impl Seen {
    /// The worse of both, number by number.
    fn worse(&self, other: &Self) -> Self {
        Self {
            deflection: self.deflection.max(other.deflection),
            correction: self.correction.max(other.correction),
            force: self.force.max(other.force),
            hinges: most(self.hinges, other.hinges),
            margin: least(self.margin, other.margin),
            superposition_error: self.superposition_error.max(other.superposition_error),
            across: [0, 1].map(|k| self.across[k].max(other.across[k])),
            stability: least(self.stability, other.stability),
            // What a correction that one of them lacks shows says nothing of both.
            is_uncorrected: self.is_uncorrected || other.is_uncorrected,
        }
    }
}

impl Tally {
    /// Adds a point that makes up `share` of the length of all paths.
    pub fn add(&mut self, seen: &Seen, share: f64, tolerance_mm: f64) {
        *self = self.merged(&Self {
            worst: *seen,
            squares: share * seen.deflection * seen.deflection,
            outside: if seen.deflection > tolerance_mm { share } else { 0.0 },
            across_squares: seen.across.map(|part| share * part * part),
        });
    }

    /// Both together.
    pub fn merged(&self, other: &Self) -> Self {
        Self {
            worst: self.worst.worse(&other.worst),
            squares: self.squares + other.squares,
            outside: self.outside + other.outside,
            across_squares: [0, 1].map(|k| self.across_squares[k] + other.across_squares[k]),
        }
    }

    /// The metrics of paths whose points make up `share` of the length of all: values once all points are seen,
    /// and before that the best they can still be.
    pub fn metrics(&self, needs: &Needs, share: f64) -> Metrics {
        let mut metrics = Metrics::default();
        metrics.set(Metric::WorstDeflection, self.worst.deflection);
        metrics.set(Metric::RmsDeflection, (self.squares / share).sqrt());
        metrics.set(Metric::ShareWithin, 1.0 - self.outside / share);
        if needs.correction && !self.worst.is_uncorrected {
            metrics.set(Metric::WorstCorrection, self.worst.correction);
            metrics.set(Metric::WorstDriveForce, self.worst.force);
            if let Some([correction, torque]) = self.worst.hinges {
                metrics.set(Metric::WorstHingeCorrection, correction);
                metrics.set(Metric::WorstHingeTorque, torque);
            }
            if let Some(margin) = self.worst.margin {
                metrics.set(Metric::ForceMargin, margin);
            }
        }
        if needs.across {
            let squares = self.across_squares.map(|squares| (squares / share).sqrt());
            metrics.set(Metric::WorstAcrossPath, self.worst.across[0]);
            metrics.set(Metric::RmsAcrossPath, squares[0]);
            metrics.set(Metric::WorstAcrossSurface, self.worst.across[1]);
            metrics.set(Metric::RmsAcrossSurface, squares[1]);
        }
        if needs.superposition_error {
            metrics.set(Metric::SuperpositionError, self.worst.superposition_error);
        }
        if let Some(stability) = self.worst.stability.filter(|_| needs.stability) {
            metrics.set(Metric::StabilityMargin, stability);
        }
        metrics
    }
}

/// Sums and extremes of the errors that the correction within limits leaves.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Corrected {
    worst: f64,
    /// Σ share · error².
    squares: f64,
    /// Share of the path within tolerance.
    within: f64,
}

impl Corrected {
    /// Nothing is left: the best there can be.
    pub fn perfect() -> Self {
        Self { within: 1.0, ..Self::default() }
    }

    /// Adds a point that makes up `share` of the length of all paths.
    pub fn add(&mut self, error: f64, share: f64, tolerance_mm: f64) {
        let within = if error <= tolerance_mm { share } else { 0.0 };
        *self = self.merged(&Self { worst: error, squares: share * error * error, within });
    }

    /// Both together.
    pub fn merged(&self, other: &Self) -> Self {
        Self {
            worst: self.worst.max(other.worst),
            squares: self.squares + other.squares,
            within: self.within + other.within,
        }
    }

    /// Of paths that make up `share` of the length of all.
    pub fn normalised(&self, share: f64) -> Self {
        Self { worst: self.worst, squares: self.squares / share, within: self.within / share }
    }

    /// Writes the metrics.
    pub fn enter(&self, metrics: &mut Metrics) {
        metrics.set(Metric::WorstResidual, self.worst);
        metrics.set(Metric::RmsResidual, self.squares.sqrt());
        metrics.set(Metric::ShareWithinCorrected, self.within);
    }

    /// Removes the metrics.
    pub fn forget(metrics: &mut Metrics) {
        for metric in Metric::ALL.into_iter().filter(|metric| metric.is_bounded()) {
            metrics.clear(metric);
        }
    }
}
