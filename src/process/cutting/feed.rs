//! Feed per tooth from feed and spindle speed.

use super::LoadError;
use crate::toolpath::PathPoint;

/// Returns the feed per tooth at `point`, mm: `given`, or c = v / (S N) from its feed v and spindle speed S with N `teeth`.
/// `key` names the process file's key for it in errors. Fails when it follows from the point's feed and spindle speed and one of them is missing.
pub(super) fn feed_per_tooth_at(
    point: &PathPoint,
    given: Option<f64>,
    teeth: u32,
    key: &'static str,
) -> Result<f64, LoadError> {
    if let Some(c) = given {
        return Ok(c);
    }
    let segment = point.source.segment;
    let feed = point.feed_mm_per_min.filter(|feed| *feed > 0.0).ok_or(LoadError::NoFeed { segment, key })?;
    match point.spindle_rev_per_min {
        Some(speed) if speed > 0.0 => Ok(feed / (speed * f64::from(teeth))),
        rev_per_min => Err(LoadError::NoSpindleSpeed { segment, rev_per_min, key }),
    }
}
