//! Targets that are farther away than a chain is long: known before anything is solved.

use super::{Chain, Machine, Motion, Step, Unreachable};
use crate::spatial::Pose;

/// Share of a chain's length by which rounding may exceed it.
const ROUNDING: f64 = 1e-9;

impl Machine {
    /// Refuses a target that is farther from where a chain begins to move than that chain is long, slides at the ends of their travel.
    /// What is not refused may still be out of reach. Chains without hinges are not looked at: their travel says more.
    ///
    /// # Errors
    /// [`Unreachable::BeyondSpan`], of the first such chain.
    pub(super) fn within_span(&self, target: &Pose) -> Result<(), Unreachable> {
        let beyond = self.chains.iter().find_map(|chain| {
            let (start, span_mm) = chain.span()?;
            let way = target.translation - start.translation;
            let controlled = (0..3).filter(|&axis| self.controls_translation(axis));
            let away_mm = controlled.map(|axis| way[axis] * way[axis]).sum::<f64>().sqrt();
            let is_beyond = away_mm > span_mm * (1.0 + ROUNDING);
            is_beyond.then(|| Unreachable::BeyondSpan { chain: chain.name.clone(), away_mm, span_mm })
        });
        beyond.map_or(Ok(()), Err)
    }
}

impl Chain {
    /// Where it begins to move, in O, and how far from there its end can be, mm; `None` if it has no hinge, or a slide without an end.
    fn span(&self) -> Option<(Pose, f64)> {
        let (mut start, mut span, mut has_moved, mut has_hinge) =
            (self.route.base, self.route.attachment.translation.norm(), false, false);
        for step in &self.route.steps {
            match *step {
                Step::Fixed(transform) if has_moved => span += transform.translation.norm(),
                Step::Fixed(transform) => start = start.compose(&transform),
                Step::Move { motion, coordinate, .. } if self.is_joint(coordinate) => {
                    has_moved = true;
                    match motion {
                        Motion::Revolute => has_hinge = true,
                        Motion::Prismatic => span += self.farthest(coordinate)?,
                    }
                }
                Step::Move { .. } | Step::Frame => {}
            }
        }
        has_hinge.then_some((start, span))
    }

    /// Whether a chain coordinate moves where nothing bends: that of a drive or of a passive joint.
    fn is_joint(&self, coordinate: usize) -> bool {
        coordinate >= self.virtual_count || self.drives.iter().any(|drive| drive.coordinate == coordinate)
    }

    /// How far the slide of `coordinate` can stand from zero, mm.
    fn farthest(&self, coordinate: usize) -> Option<f64> {
        let (low, high) = match coordinate.checked_sub(self.virtual_count) {
            Some(joint) => self.passive[joint].limits?,
            None if self.coupling.is_some() => return None,
            None => self.drives.iter().find(|drive| drive.coordinate == coordinate)?.travel?,
        };
        Some(low.abs().max(high.abs()))
    }
}
