//! Lengths of chains, by which targets out of reach are refused before anything is solved.

use super::{Chain, Machine, Motion, Step, Unreachable};
use crate::spatial::Pose;

/// Share of a chain's length by which rounding may exceed it.
const ROUNDING: f64 = 1e-9;

impl Machine {
    /// Refuses, with [`Unreachable::BeyondSpan`], a target that is farther from where a chain begins to move than that chain is long, slides at the
    /// ends of their travel. What is not refused may still be out of reach. Chains without revolute joints are not looked at: their travel says more.
    pub(super) fn check_span(&self, target: &Pose) -> Result<(), Unreachable> {
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
    /// Pose in O at the chain's first joint, and how far its end can be from there, mm; `None` without revolute joint or with an endless slide.
    fn span(&self) -> Option<(Pose, f64)> {
        let (mut start, mut span, mut has_moved, mut has_revolute) =
            (self.route.base, self.route.attachment.translation.norm(), false, false);
        for step in &self.route.steps {
            match *step {
                Step::Fixed(transform) if has_moved => span += transform.translation.norm(),
                Step::Fixed(transform) => start = start.compose(&transform),
                Step::Move { motion, coordinate, .. } if self.is_joint(coordinate) => {
                    has_moved = true;
                    match motion {
                        Motion::Revolute => has_revolute = true,
                        Motion::Prismatic => span += self.slide_extent(coordinate)?,
                    }
                }
                Step::Move { .. } | Step::Frame => {}
            }
        }
        has_revolute.then_some((start, span))
    }

    /// Whether a chain coordinate is that of a drive or of a passive joint, and so moves without elastic deflection.
    fn is_joint(&self, coordinate: usize) -> bool {
        coordinate >= self.virtual_count || self.drives.iter().any(|drive| drive.coordinate == coordinate)
    }

    /// Largest distance of the prismatic joint of `coordinate` from zero, mm; `None` where that is unlimited.
    fn slide_extent(&self, coordinate: usize) -> Option<f64> {
        let (low, high) = match coordinate.checked_sub(self.virtual_count) {
            Some(joint) => self.passive[joint].limits?,
            None if self.coupling.is_some() => return None,
            None => self.drives.iter().find(|drive| drive.coordinate == coordinate)?.travel?,
        };
        Some(low.abs().max(high.abs()))
    }
}
