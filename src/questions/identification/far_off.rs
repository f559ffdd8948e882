//! Readings that lie far off all others: slips of the pen, or a marker that moved.

use super::{fit::Fit, measurements::Measurement, validate::OWN};

/// A reading that lies far off.
#[derive(Debug, Clone, PartialEq)]
pub struct FarOff {
    /// Which measurement.
    pub measurement: usize,
    /// Which of its readings.
    pub column: &'static str,
    /// Measured less predicted, mm; of rotations degrees.
    pub by: f64,
}

/// So many times the typical residual: normal noise leaves one in two million.
const FAR: f64 = 5.0;
/// Standard deviation of normal noise over the median of its size.
const PER_MEDIAN: f64 = 1.4826;
/// Fewer readings that others tell do not say what is typical.
const FEWEST: usize = 8;
/// What is left is rounding of the solves, if it is less, mm and rad.
const ROUNDING: f64 = 1e-7;

/// Readings far off, the farthest first. What is typical is the median, which those that are far off do not move.
pub fn far_off(fit: &Fit, measurements: &[Measurement]) -> Vec<FarOff> {
    // A reading that tells an unknown alone leaves nothing.
    let size = |i: usize| {
        let others = 1.0 - fit.hat(i, 1)[(0, 0)] / fit.weights[i].max(f64::MIN_POSITIVE);
        (others > OWN).then(|| (fit.residuals[i] / fit.stds[i]).abs() / others.sqrt())
    };
    let all: Vec<Option<f64>> = (0..fit.residuals.len()).map(size).collect();
    let mut sizes: Vec<f64> = all.iter().flatten().copied().collect();
    if sizes.len() < FEWEST {
        return Vec::new();
    }
    sizes.sort_by(f64::total_cmp);
    let typical = PER_MEDIAN * sizes[sizes.len() / 2];
    let readings = measurements.iter().enumerate().flat_map(|(m, own)| own.readings.iter().map(move |r| (m, r)));
    let mut far: Vec<(f64, FarOff)> = Vec::new();
    for (i, (measurement, reading)) in readings.enumerate() {
        let (residual, Some(size)) = (fit.residuals[i], all[i]) else { continue };
        if size > FAR * typical && residual.abs() > ROUNDING {
            let by = if reading.quantity.is_rotation() { residual.to_degrees() } else { residual };
            far.push((size, FarOff { measurement, column: reading.column, by }));
        }
    }
    far.sort_by(|a, b| b.0.total_cmp(&a.0));
    far.into_iter().map(|(_, own)| own).collect()
}
