//! How much a reading counts that lies far off: M-estimators, as weights of a least-squares fit.

use nalgebra::DVector;

use super::spec::LossSpec;

/// Where the losses leave the square, in standard deviations: 95 % as efficient as squares where noise is normal.
const HUBER: f64 = 1.345;
const CAUCHY: f64 = 2.385;
/// Standard deviation of normal noise over the median of its size.
const PER_MEDIAN: f64 = 1.4826;

impl LossSpec {
    /// Word in tables.
    pub fn label(self) -> &'static str {
        match self {
            Self::Squares => "squares",
            Self::Huber => "huber",
            Self::Cauchy => "cauchy",
        }
    }

    /// What a residual of `r` standard deviations costs; half its square near zero.
    pub(super) fn cost(self, r: f64) -> f64 {
        match self {
            Self::Squares => 0.5 * r * r,
            Self::Huber if r.abs() <= HUBER => 0.5 * r * r,
            Self::Huber => HUBER * (r.abs() - 0.5 * HUBER),
            Self::Cauchy => 0.5 * CAUCHY * CAUCHY * (r / CAUCHY).powi(2).ln_1p(),
        }
    }

    /// Weight of its square with the same derivative: `ψ(r)/r`.
    pub(super) fn weight(self, r: f64) -> f64 {
        match self {
            Self::Squares => 1.0,
            Self::Huber => (HUBER / r.abs().max(HUBER)).min(1.0),
            Self::Cauchy => 1.0 / (1.0 + (r / CAUCHY).powi(2)),
        }
    }

    /// `ψ'(r)`.
    fn slope(self, r: f64) -> f64 {
        match self {
            Self::Squares => 1.0,
            Self::Huber => f64::from(u8::from(r.abs() <= HUBER)),
            Self::Cauchy => {
                let share = (r / CAUCHY).powi(2);
                (1.0 - share) / (1.0 + share).powi(2)
            }
        }
    }

    /// Scatter of `residuals` that outliers do not move; of squares, that which makes the fit's own variance.
    pub(super) fn scale(self, residuals: &DVector<f64>, unknowns: usize) -> f64 {
        let free = residuals.len().saturating_sub(unknowns).max(1) as f64;
        match self {
            Self::Squares => (residuals.norm_squared() / free).sqrt(),
            _ => {
                let mut sizes: Vec<f64> = residuals.iter().map(|r| r.abs()).collect();
                sizes.sort_by(f64::total_cmp);
                let few = (residuals.len() as f64 / free).sqrt();
                PER_MEDIAN * few * sizes[sizes.len() / 2]
            }
        }
    }

    /// Variance of an estimate over `(JᵀJ)⁻¹`, in units of the scale's square (Huber 1981, 7.6.4, with its correction for few
    /// readings); `r` are residuals over the scale.
    pub(super) fn inflation(self, r: &DVector<f64>, unknowns: usize) -> f64 {
        if self == Self::Squares {
            return 1.0;
        }
        let (count, sought) = (r.len() as f64, unknowns as f64);
        let mean = r.iter().map(|&r| self.slope(r)).sum::<f64>() / count;
        let spread = r.iter().map(|&r| (self.weight(r) * r).powi(2)).sum::<f64>() / (count - sought).max(1.0);
        let variance = r.iter().map(|&r| (self.slope(r) - mean).powi(2)).sum::<f64>() / count;
        let correction = 1.0 + sought / count * variance / (mean * mean);
        correction * correction * spread / (mean * mean)
    }
}
