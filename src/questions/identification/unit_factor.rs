//! Common factor of all fitted stiffnesses, which looks like forces or lengths in another unit.

use super::{IdentificationStudy, degrees_of_freedom, fit::Fit, scatter, unknown::Coordinate};

/// A common factor between all fitted stiffnesses and those of the machine file, near that of a mistaken unit.
#[derive(Debug, Clone, PartialEq)]
pub struct UnitFactor {
    /// The common factor, at least 1; its direction is [`is_lower`](Self::is_lower).
    pub factor: f64,
    /// 95 % interval of the factor.
    pub interval: [f64; 2],
    /// Smallest and largest factor of the single stiffnesses.
    pub each: [f64; 2],
    /// Whether the fitted stiffnesses are lower than the file's.
    pub is_lower: bool,
    /// Factor between two units that it matches, and which units those are.
    pub looks_like: (f64, &'static str),
}

/// Factors between units that are taken for one another.
const UNIT_FACTORS: [(f64, &str); 6] = [
    (9.81, "kgf for N"),
    (1000.0, "kN for N, or µm or m for mm"),
    (57.3, "degrees for radians"),
    (25.4, "inches for mm"),
    (4.448, "lbf for N"),
    (175.1, "lbf/in for N/m"),
];
/// Largest gap between the interval and the factor of a unit, as `ln` of a factor.
const NEAR: f64 = 0.03;
/// Largest half width of the interval, as `ln` of a factor: a wider one fits too many units.
const WIDEST: f64 = 0.26;
/// Largest scatter of the stiffnesses about their common factor, as `ln` of a factor: files are about as wrong.
const MAX_SCATTER: f64 = 0.2;

/// Returns the common factor of all identifiable stiffnesses, if it looks like a mistaken unit. Each is a sample with an error and a
/// scatter of its own, so their mean is that of a random-effects model (DerSimonian and Laird 1986).
pub fn unit_factor(study: &IdentificationStudy, fit: &Fit) -> Option<UnitFactor> {
    let stiffnesses: Vec<(f64, f64)> = (study.unknowns.iter().enumerate())
        .filter(|(_, unknown)| unknown.coordinate == Coordinate::Logarithm && unknown.unit.is_stiffness())
        .map(|(k, _)| (fit.x[k], fit.std(k).powi(2).max(f64::MIN_POSITIVE)))
        .filter(|(_, variance)| variance.is_finite())
        .collect();
    let mean = |scatter: f64| {
        let weights = || stiffnesses.iter().map(|(x, variance)| (x, 1.0 / (variance + scatter)));
        let sum: f64 = weights().map(|(_, weight)| weight).sum();
        (weights().map(|(x, weight)| x * weight).sum::<f64>() / sum, sum)
    };
    let (first, sum) = mean(0.0);
    let squares: f64 = stiffnesses.iter().map(|(_, variance)| variance.powi(-2)).sum();
    let chi_squared: f64 = stiffnesses.iter().map(|(x, variance)| (x - first).powi(2) / variance).sum();
    let excess = chi_squared - (stiffnesses.len() as f64 - 1.0);
    let scatter = if excess > 0.0 && stiffnesses.len() > 1 { excess / (sum - squares / sum) } else { 0.0 };
    let (log, sum) = mean(scatter);
    let width = scatter::half_width(degrees_of_freedom(study, fit)) / sum.sqrt();
    if !(fit.is_converged && stiffnesses.len() > 1 && width <= WIDEST && scatter.sqrt() <= MAX_SCATTER) {
        return None;
    }
    let looks_like = UNIT_FACTORS.into_iter().find(|(unit, _)| (log.abs() - libm::log(*unit)).abs() <= width + NEAR)?;
    let interval = [log.abs() - width, log.abs() + width].map(libm::exp);
    let sizes = || stiffnesses.iter().map(|(x, _)| libm::exp(x * log.signum()));
    let each = [sizes().fold(f64::INFINITY, f64::min), sizes().fold(0.0, f64::max)];
    Some(UnitFactor { each, factor: libm::exp(log.abs()), interval, is_lower: log < 0.0, looks_like })
}
