//! Extremes and sums over some points of a path, from which the metrics follow.
//!
//! Every number can only get worse as points are added: largest values grow, least values fall, and sums are taken with each point's share
//! of the whole path, not of the points so far. The values of a part of the path are therefore bounds on those of the whole; see
//! [`super::sweep`]. Shares add up without rounding, so a path all of whose points are out of tolerance is so by exactly its share.

use serde::{Deserialize, Serialize};

use super::metric::{Metric, Metrics};

/// Numbers at one point of a path, or the worst of several points.
#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize)]
pub(super) struct PointValues {
    /// Distance from the path at the nominal command, mm.
    pub deflection: f64,
    /// Half the interval in which open backlash and friction leave the tool there, mm.
    pub open: f64,
    /// Whether that is not known.
    pub is_open_unknown: bool,
    /// Largest |Δρ|, mm or degrees; of prismatic joints where the machine has prismatic and revolute joints.
    pub correction: f64,
    /// Largest |τ|, N or N·mm; of prismatic joints where the machine has prismatic and revolute joints.
    pub force: f64,
    /// Largest |Δρ|, degrees, and |τ|, N·mm, of revolute joints where the machine has prismatic joints, too.
    pub revolute: Option<[f64; 2]>,
    /// Smallest remaining share of a drive's force limit.
    pub margin: Option<f64>,
    /// Superposition error, mm.
    pub superposition_error: f64,
    /// Parts of the deflection, mm: across the direction of motion, and normal to the wall.
    pub across: [f64; 2],
    /// Smallest eigenvalue of the loaded stiffness, N/mm.
    pub stability: Option<f64>,
    /// Whether the exact correction was sought and not found.
    pub is_uncorrected: bool,
}

/// Which numbers an evaluation computes, beside the deflection.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Needs {
    /// The exact correction.
    pub correction: bool,
    /// The superposition error, which needs each source alone.
    pub superposition_error: bool,
    /// Eigenvalues of the loaded stiffness.
    pub stability: bool,
    /// The correction within limits.
    pub bounded: bool,
    /// The parts of the deflection across the direction of motion.
    pub across: bool,
    /// Metrics of a distribution.
    pub uncertain: bool,
    /// The least distance of bodies.
    pub clearance: bool,
}

impl Needs {
    /// Returns which numbers must be computed for `metrics`.
    pub fn of(metrics: &[Metric]) -> Self {
        let any = |group: &[Metric]| metrics.iter().any(|metric| group.contains(metric));
        Self {
            correction: any(&[
                Metric::WorstCorrection,
                Metric::WorstDriveForce,
                Metric::WorstRotaryCorrection,
                Metric::WorstRotaryTorque,
                Metric::ForceMargin,
            ]),
            superposition_error: any(&[Metric::SuperpositionError]),
            stability: any(&[Metric::StabilityMargin]),
            bounded: metrics.iter().any(|metric| metric.is_bounded()),
            across: metrics.iter().any(|metric| metric.is_across()),
            uncertain: metrics.iter().any(|metric| metric.is_uncertain()),
            clearance: any(&[Metric::LeastClearance]),
        }
    }
}

/// Sums and extremes over the points added so far.
#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize)]
pub(super) struct Tally {
    worst: PointValues,
    /// Σ share · deflection².
    squares: f64,
    /// Share of the path out of tolerance.
    outside: f64,
    /// Σ share · part² of the parts of the deflection across the motion.
    across_squares: [f64; 2],
}

/// Returns the `worse` of two values; the other one where one is `None`.
fn of_known<T>(a: Option<T>, b: Option<T>, worse: impl Fn(T, T) -> T) -> Option<T> {
    a.into_iter().chain(b).reduce(worse)
}

impl PointValues {
    /// Returns these numbers where `open`, mm, is half an interval in which the tool stands; `None` where it is not known.
    pub fn with_open(self, open: Option<f64>) -> Self {
        let is_open_unknown = self.is_open_unknown || open.is_none();
        Self { open: self.open.max(open.unwrap_or_default()), is_open_unknown, ..self }
    }

    /// Returns the worse of each number of both.
    fn worse_of(&self, other: &Self) -> Self {
        Self {
            deflection: self.deflection.max(other.deflection),
            open: self.open.max(other.open),
            is_open_unknown: self.is_open_unknown || other.is_open_unknown,
            correction: self.correction.max(other.correction),
            force: self.force.max(other.force),
            revolute: of_known(self.revolute, other.revolute, |a, b| [0, 1].map(|k| f64::max(a[k], b[k]))),
            margin: of_known(self.margin, other.margin, f64::min),
            superposition_error: self.superposition_error.max(other.superposition_error),
            across: [0, 1].map(|k| self.across[k].max(other.across[k])),
            stability: of_known(self.stability, other.stability, f64::min),
            // What a correction that one of them lacks shows says nothing of both.
            is_uncorrected: self.is_uncorrected || other.is_uncorrected,
        }
    }
}

impl Tally {
    /// Adds the numbers of a `point` that makes up `share` of the length of all paths.
    pub fn add(&mut self, point: &PointValues, share: f64, tolerance_mm: f64) {
        *self = self.merged(&Self {
            worst: *point,
            squares: share * point.deflection * point.deflection,
            outside: if point.deflection > tolerance_mm { share } else { 0.0 },
            across_squares: point.across.map(|part| share * part * part),
        });
    }

    /// Returns the tally of both sets of points.
    pub fn merged(&self, other: &Self) -> Self {
        Self {
            worst: self.worst.worse_of(&other.worst),
            squares: self.squares + other.squares,
            outside: self.outside + other.outside,
            across_squares: [0, 1].map(|k| self.across_squares[k] + other.across_squares[k]),
        }
    }

    /// Returns half the widest interval of `all` in which open backlash and friction leave the tool, mm; `None` where it is not known.
    pub fn widest_open_mm(all: &[Self]) -> Option<f64> {
        all.iter()
            .map(|own| Some(own.worst.open).filter(|_| !own.worst.is_open_unknown))
            .try_fold(0.0, |most: f64, own| Some(most.max(own?)))
    }

    /// Returns the metrics of paths that make up `share` of the length of all; before all points are added, the best they can still be.
    pub fn metrics(&self, needs: &Needs, share: f64) -> Metrics {
        let mut metrics = Metrics::default();
        metrics.set(Metric::WorstDeflection, self.worst.deflection);
        metrics.set(Metric::RmsDeflection, (self.squares / share).sqrt());
        metrics.set(Metric::ShareWithin, 1.0 - self.outside / share);
        if needs.correction && !self.worst.is_uncorrected {
            metrics.set(Metric::WorstCorrection, self.worst.correction);
            metrics.set(Metric::WorstDriveForce, self.worst.force);
            if let Some([correction, torque]) = self.worst.revolute {
                metrics.set(Metric::WorstRotaryCorrection, correction);
                metrics.set(Metric::WorstRotaryTorque, torque);
            }
            metrics.set(Metric::ForceMargin, self.worst.margin);
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
        metrics.set(Metric::StabilityMargin, self.worst.stability.filter(|_| needs.stability));
        metrics
    }
}

/// Sums and extremes of the residual errors after the correction within limits: of whole paths, as a part of a path bounds nothing here but
/// [`perfect`](Self::perfect).
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct ResidualTally {
    worst: f64,
    /// Σ share · error².
    squares: f64,
    /// Share of the path within tolerance.
    within: f64,
}

impl ResidualTally {
    /// Returns the tally of a path without residual error, the best possible.
    pub fn perfect() -> Self {
        Self { within: 1.0, ..Self::default() }
    }

    /// Adds a point with the residual `error`, mm, that makes up `share` of the length of all paths.
    pub fn add(&mut self, error: f64, share: f64, tolerance_mm: f64) {
        let within = if error <= tolerance_mm { share } else { 0.0 };
        *self = self.merged(&Self { worst: error, squares: share * error * error, within });
    }

    /// Returns the tally of both sets of points.
    pub fn merged(&self, other: &Self) -> Self {
        Self {
            worst: self.worst.max(other.worst),
            squares: self.squares + other.squares,
            within: self.within + other.within,
        }
    }

    /// Returns the tally with its sums over `share`, the share of these paths in the length of all.
    pub fn normalised(&self, share: f64) -> Self {
        Self { worst: self.worst, squares: self.squares / share, within: self.within / share }
    }

    /// Writes the metrics of the correction within limits into `metrics`; the tally must be normalised.
    pub fn write_into(&self, metrics: &mut Metrics) {
        metrics.set(Metric::WorstResidual, self.worst);
        metrics.set(Metric::RmsResidual, self.squares.sqrt());
        metrics.set(Metric::ShareWithinCorrected, self.within);
    }

    /// Removes the metrics of the correction within limits from `metrics`.
    pub fn remove_from(metrics: &mut Metrics) {
        for metric in Metric::ALL.into_iter().filter(|metric| metric.is_bounded()) {
            metrics.set(metric, None);
        }
    }
}
