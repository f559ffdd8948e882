//! The largest force of an end mill within a turn.

use std::f64::consts::TAU;

use nalgebra::Vector3;

use super::{CutForce, EndMilling};

/// Places looked at between an entry or exit and the next.
const SAMPLES: u32 = 48;
/// Steps that narrow down the best of them; each leaves 0.618 of the interval.
const NARROWINGS: u32 = 24;

impl EndMilling {
    /// Force and torque at the instant of a turn at which the force is largest, at feed per tooth `c` in mm.
    ///
    /// All teeth being alike, a pitch of the cutter is looked at. Between entries and exits of teeth the force is smooth; at
    /// them it may jump, so that each stretch counts with both its ends.
    #[must_use]
    pub fn peak(&self, c: f64) -> CutForce {
        let mut largest = CutForce { force_N: Vector3::zeros(), torque_Nmm: 0.0 };
        let bounds = self.bounds();
        for stretch in bounds.windows(2) {
            let (from, to) = (stretch[0], stretch[1]);
            let at = |angle: f64| self.at_angle(angle, 0.5 * (from + to), c);
            let step = (to - from) / f64::from(SAMPLES);
            let sampled = (0..=SAMPLES).map(|k| from + step * f64::from(k));
            let best = sampled.map(|angle| (angle, size(&at(angle)))).max_by(|a, b| a.1.total_cmp(&b.1));
            let Some((best, _)) = best else { continue };
            let narrowed = narrow((best - step).max(from), (best + step).min(to), |angle| size(&at(angle)));
            for found in [at(best), at(narrowed)] {
                if size(&found) > size(&largest) {
                    largest = found;
                }
            }
        }
        largest
    }

    /// Angles of the first tooth within a pitch at which some tooth enters or leaves, with the ends of the pitch, ascending.
    fn bounds(&self) -> Vec<f64> {
        let (arc, pitch) = (self.arc(), TAU / f64::from(self.teeth));
        let mut bounds = vec![0.0, arc.entry.rem_euclid(pitch), arc.exit.rem_euclid(pitch), pitch];
        bounds.sort_by(f64::total_cmp);
        bounds.dedup_by(|a, b| (*a - *b).abs() < 1e-12);
        bounds
    }
}

fn size(force: &CutForce) -> f64 {
    force.force_N.norm()
}

/// Where `value` is largest between `from` and `to`, by golden section.
fn narrow(mut from: f64, mut to: f64, value: impl Fn(f64) -> f64) -> f64 {
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
