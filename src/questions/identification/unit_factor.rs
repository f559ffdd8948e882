//! Stiffnesses that are all off by one factor, which looks like forces or lengths read in another unit.

use super::{IdentificationStudy, fit::Fit, free, scatter, unknown::Coordinate};
use crate::machine::Unit;

/// A factor between all stiffnesses and those of the machine file.
#[derive(Debug, Clone, PartialEq)]
pub struct UnitFactor {
    /// Larger of found over file and file over found.
    pub factor: f64,
    /// Its 95 % interval.
    pub interval: [f64; 2],
    /// Least and largest of the factors of each.
    pub each: [f64; 2],
    /// Whether what was found is lower.
    pub is_lower: bool,
    /// The factor it looks like, and between which units that is.
    pub looks_like: (f64, &'static str),
}

/// Factors between units that are taken for one another.
const UNITS: [(f64, &str); 6] = [
    (9.81, "kgf for N"),
    (1000.0, "kN for N, or µm or m for mm"),
    (57.3, "degrees for radians"),
    (25.4, "inches for mm"),
    (4.448, "lbf for N"),
    (175.1, "lbf/in for N/m"),
];
/// The interval comes as near as this to the factor of a unit, as `ln` of a factor.
const NEAR: f64 = 0.03;
/// A wider interval, either way, holds too many factors to look like one.
const WIDEST: f64 = 0.26;
/// Stiffnesses that scatter by more about their common factor have none, as `ln` of a factor: files are about as wrong.
const MOST_SCATTER: f64 = 0.2;

/// The common factor of all stiffnesses that were told, if it looks like a unit. They differ from their file's by more than what is known
/// of each: their mean is that of a sample with a scatter of its own (DerSimonian and Laird 1986).
pub fn unit_factor(study: &IdentificationStudy, fit: &Fit) -> Option<UnitFactor> {
    let stiffness = [Unit::N_PER_MM, Unit::NMM_PER_RAD, Unit::N_PER_MM2];
    let told: Vec<(f64, f64)> = (study.unknowns.iter().enumerate())
        .filter(|(_, own)| own.coordinate == Coordinate::Logarithm && stiffness.contains(&own.unit))
        .map(|(k, _)| (fit.x[k], fit.std(k).powi(2).max(f64::MIN_POSITIVE)))
        .filter(|(_, variance)| variance.is_finite())
        .collect();
    let mean = |scatter: f64| {
        let weights = || told.iter().map(|(x, variance)| (x, 1.0 / (variance + scatter)));
        let sum: f64 = weights().map(|(_, weight)| weight).sum();
        (weights().map(|(x, weight)| x * weight).sum::<f64>() / sum, sum)
    };
    let (first, sum) = mean(0.0);
    let squares: f64 = told.iter().map(|(_, variance)| variance.powi(-2)).sum();
    let off: f64 = told.iter().map(|(x, variance)| (x - first).powi(2) / variance).sum();
    let more = off - (told.len() as f64 - 1.0);
    let scatter = if more > 0.0 && told.len() > 1 { more / (sum - squares / sum) } else { 0.0 };
    let (log, sum) = mean(scatter);
    let width = scatter::half_width(free(study, fit)) / sum.sqrt();
    if !(fit.is_found && told.len() > 1 && width <= WIDEST && scatter.sqrt() <= MOST_SCATTER) {
        return None;
    }
    let looks_like = UNITS.into_iter().find(|(unit, _)| (log.abs() - unit.ln()).abs() <= width + NEAR)?;
    let interval = [log.abs() - width, log.abs() + width].map(f64::exp);
    let sizes = || told.iter().map(|(x, _)| (x * log.signum()).exp());
    let each = [sizes().fold(f64::INFINITY, f64::min), sizes().fold(0.0, f64::max)];
    Some(UnitFactor { each, factor: log.abs().exp(), interval, is_lower: log < 0.0, looks_like })
}
