//! Statistics of residuals: robust losses (M-estimators), half widths of 95 % intervals, and the largest mean square that noise explains.

use nalgebra::DVector;

use super::spec::LossSpec;

/// Residuals, in standard deviations, at which losses leave the square: 95 % efficiency for normal noise.
const HUBER: f64 = 1.345;
const CAUCHY: f64 = 2.385;
/// Standard deviation of normal noise over the median of its absolute value.
pub(super) const PER_MEDIAN: f64 = 1.4826;

impl LossSpec {
    /// Returns the word for the loss function in tables.
    pub fn label(self) -> &'static str {
        match self {
            Self::Squares => "squares",
            Self::Huber => "huber",
            Self::Cauchy => "cauchy",
        }
    }

    /// Returns the loss of a residual of `r` standard deviations; half its square near zero.
    pub(super) fn cost(self, r: f64) -> f64 {
        match self {
            Self::Squares => 0.5 * r * r,
            Self::Huber if r.abs() <= HUBER => 0.5 * r * r,
            Self::Huber => HUBER * (r.abs() - 0.5 * HUBER),
            Self::Cauchy => 0.5 * CAUCHY * CAUCHY * libm::log1p((r / CAUCHY).powi(2)),
        }
    }

    /// Returns the weight `ψ(r)/r` with which least squares has the derivative of this loss at `r`.
    pub(super) fn weight(self, r: f64) -> f64 {
        match self {
            Self::Squares => 1.0,
            Self::Huber => (HUBER / r.abs().max(HUBER)).min(1.0),
            Self::Cauchy => 1.0 / (1.0 + (r / CAUCHY).powi(2)),
        }
    }

    /// Returns the second derivative `ψ'(r)` of the loss at `r`.
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

    /// Estimates the standard deviation of `residuals`: by the median of their size for robust losses, by their mean square otherwise.
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

    /// Returns the variance of an estimate over `(JᵀJ)⁻¹` (Huber 1981, 7.6.4, corrected for few readings); `r` are residuals over the scale.
    pub(super) fn inflation(self, r: &DVector<f64>, unknowns: usize) -> f64 {
        if self == Self::Squares {
            return 1.0;
        }
        let (count, fitted) = (r.len() as f64, unknowns as f64);
        let mean = r.iter().map(|&r| self.slope(r)).sum::<f64>() / count;
        let spread = r.iter().map(|&r| (self.weight(r) * r).powi(2)).sum::<f64>() / (count - fitted).max(1.0);
        let variance = r.iter().map(|&r| (self.slope(r) - mean).powi(2)).sum::<f64>() / count;
        let correction = 1.0 + fitted / count * variance / (mean * mean);
        correction * correction * spread / (mean * mean)
    }
}

/// 97.5 % quantiles of Student's distribution with 1, 2 and 3 degrees of freedom.
const FEW: [f64; 3] = [12.706_204_74, 4.302_652_73, 3.182_446_31];
/// 97.5 % quantile of the normal distribution.
const NORMAL: f64 = 1.959_963_985;
/// 99 % quantile of the normal distribution.
const ONCE_IN_A_HUNDRED: f64 = 2.326_347_874;

/// Returns half a 95 % interval in standard deviations: the 97.5 % quantile of Student's distribution with `free` degrees of freedom, or of
/// the normal distribution where the standard deviation is known (`None`).
pub fn half_width(free: Option<usize>) -> f64 {
    match free {
        None => NORMAL,
        Some(0) => f64::INFINITY,
        Some(few @ 1..=3) => FEW[few - 1],
        Some(free) => {
            // Cornish and Fisher's expansion.
            let (z, n) = (NORMAL, free as f64);
            let [z3, z5, z7, z9] = [3, 5, 7, 9].map(|power| z.powi(power));
            let terms = [
                (z3 + z) / 4.0,
                (5.0 * z5 + 16.0 * z3 + 3.0 * z) / 96.0,
                (3.0 * z7 + 19.0 * z5 + 17.0 * z3 - 15.0 * z) / 384.0,
                (79.0 * z9 + 776.0 * z7 + 1482.0 * z5 - 1920.0 * z3 - 945.0 * z) / 92160.0,
            ];
            terms.iter().enumerate().fold(z, |sum, (k, term)| sum + term / n.powi(k as i32 + 1))
        }
    }
}

/// Returns the 99 % limit of the mean square of residuals over their noise: of F with `free` and infinitely many degrees of freedom.
pub fn mean_square_limit(free: usize) -> f64 {
    match free {
        0 => f64::INFINITY,
        1 => 6.634_896_60,
        2 => 4.605_170_19,
        free => {
            // Wilson and Hilferty's cube root.
            let spread = 2.0 / (9.0 * free as f64);
            (1.0 - spread + ONCE_IN_A_HUNDRED * spread.sqrt()).powi(3)
        }
    }
}
