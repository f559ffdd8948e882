//! The factor by which errors are enlarged in a drawing so that they can be seen.

use nalgebra::Vector3;

/// Largest share of the path's extent that the largest error may take in the drawing.
const ERROR_SHARE: f64 = 0.15;

/// Returns a round factor that enlarges `largest_error` (mm) to a visible share of the extent of `path` (mm) in the xy-plane; at least 1.
pub(crate) fn amplification(path: &[Vector3<f64>], largest_error: f64) -> f64 {
    let extent = |axis: usize| {
        let (low, high) = path.iter().fold((f64::MAX, f64::MIN), |(l, h), p| (l.min(p[axis]), h.max(p[axis])));
        high - low
    };
    let ideal = ERROR_SHARE * extent(0).max(extent(1)) / largest_error;
    if !ideal.is_finite() || ideal <= 1.0 {
        return 1.0;
    }
    let decade = libm::pow(10.0, libm::log10(ideal).floor());
    [5.0, 2.0, 1.0].into_iter().map(|step| step * decade).find(|factor| *factor <= ideal).unwrap_or(1.0)
}
