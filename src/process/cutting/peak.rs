//! The largest force of an end mill within a revolution.

use std::f64::consts::TAU;

use nalgebra::Vector3;

use super::{CutForce, EndMilling};

/// Places looked at between an entry or exit and the next.
const SAMPLES: u32 = 48;
/// Steps that narrow down the best of them; each leaves 0.618 of the interval.
const NARROWINGS: u32 = 24;

impl EndMilling {
    /// Returns force and torque at the instant of a revolution at which the force is largest, at feed per tooth `c` (mm).
    ///
    /// All teeth are alike, so one pitch of the cutter is searched. The force is smooth between entries and exits of teeth and may jump at
    /// them, so both ends of each interval are evaluated as limits from inside.
    #[must_use]
    pub fn peak(&self, c: f64) -> CutForce {
        let mut largest = CutForce { force_N: Vector3::zeros(), torque_Nmm: 0.0 };
        let bounds = self.engagement_changes();
        for interval in bounds.windows(2) {
            let (from, to) = (interval[0], interval[1]);
            let at = |angle: f64| self.at_angle(angle, 0.5 * (from + to), c);
            let step = (to - from) / f64::from(SAMPLES);
            let sampled = (0..=SAMPLES).map(|k| from + step * f64::from(k));
            let best = sampled.map(|angle| (angle, force_magnitude(&at(angle)))).max_by(|a, b| a.1.total_cmp(&b.1));
            let Some((best, _)) = best else { continue };
            let narrowed =
                golden_section_max((best - step).max(from), (best + step).min(to), |angle| force_magnitude(&at(angle)));
            for found in [at(best), at(narrowed)] {
                if force_magnitude(&found) > force_magnitude(&largest) {
                    largest = found;
                }
            }
        }
        largest
    }

    /// Returns the angles (rad) of the first tooth within a pitch at which a tooth enters or leaves, with the ends of the pitch, ascending.
    fn engagement_changes(&self) -> Vec<f64> {
        let (arc, pitch) = (self.arc(), TAU / f64::from(self.teeth));
        let mut bounds = vec![0.0, arc.entry.rem_euclid(pitch), arc.exit.rem_euclid(pitch), pitch];
        bounds.sort_by(f64::total_cmp);
        bounds.dedup_by(|a, b| (*a - *b).abs() < 1e-12);
        bounds
    }
}

/// Returns the magnitude of the force, N.
fn force_magnitude(force: &CutForce) -> f64 {
    force.force_N.norm()
}

/// Returns the argument between `from` and `to` at which `value` is largest, by golden section search.
fn golden_section_max(mut from: f64, mut to: f64, value: impl Fn(f64) -> f64) -> f64 {
    const SHARE: f64 = 0.618_033_988_749_894_9;
    for _ in 0..NARROWINGS {
        let (low, high) = (to - SHARE * (to - from), from + SHARE * (to - from));
        if value(low) > value(high) {
            to = high;
        } else {
            from = low;
        }
    }
    0.5 * (from + to)
}
