//! Allowance of a place: how far from it the workpiece may stand once it is clamped.
//!
//! Nobody clamps to a hundredth of a millimetre. Where the workpiece stands is probed and the program compensated there, so the error of
//! clamping is none of the tool's; but the path must be within reach wherever that is, and what is left must be no worse than told. A place
//! is therefore judged at the corners of its allowance, too: it can be cut where it can at all of them, and its metrics are the worst.

use std::ops::Range;

use super::{
    Site,
    evaluate::{Evaluation, Evaluator, PartialEvaluation},
    is_angle,
    metric::{Metric, Metrics},
    site::COORDINATES,
    turned::Setup,
};
use crate::{simulation::Failure, work::Work};

/// How far from a place the workpiece may stand, on either side.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Allowance {
    /// Along each coordinate of the [`Site`], mm or rad.
    pub half: [f64; 6],
}

/// Default allowance of positions, mm.
pub const POSITION_MM: f64 = 1.0;
/// Default allowance of angles, degrees.
pub const ANGLE_DEG: f64 = 0.5;

impl Allowance {
    /// Returns the coordinates along which the workpiece may stand elsewhere.
    fn coordinates(&self) -> Vec<usize> {
        (0..self.half.len()).filter(|&i| self.half[i] > 0.0).collect()
    }

    /// Returns whether the workpiece stands exactly where it is placed.
    pub fn is_none(&self) -> bool {
        self.coordinates().is_empty()
    }

    /// Returns the directions from a place to the corners of its allowance, −1 or 1 along each coordinate that varies, else 0.
    fn corners(&self) -> Vec<[f64; 6]> {
        let coordinates = self.coordinates();
        let corner = |number: usize| {
            let mut direction = [0.0; 6];
            for (bit, &i) in coordinates.iter().enumerate() {
                direction[i] = if number >> bit & 1 == 0 { -1.0 } else { 1.0 };
            }
            direction
        };
        if coordinates.is_empty() { Vec::new() } else { (0..1 << coordinates.len()).map(corner).collect() }
    }

    /// Returns the places at its corners around `site`.
    pub fn sites(&self, site: &Site) -> Vec<Site> {
        let at = |direction: [f64; 6]| Site(std::array::from_fn(|i| site.0[i] + direction[i] * self.half[i]));
        self.corners().into_iter().map(at).collect()
    }

    /// Returns it in words, such as `±1 mm along x and y and ±0.5° of yaw`; empty where there is none.
    pub fn text(&self) -> String {
        let in_degrees = |i: usize| (1e6 * self.half[i].to_degrees()).round() / 1e6;
        let mut parts: Vec<String> = Vec::new();
        for angle in [false, true] {
            let own: Vec<usize> = self.coordinates().into_iter().filter(|&i| is_angle(i) == angle).collect();
            let Some(&first) = own.first() else { continue };
            let names: Vec<&str> = own.iter().map(|&i| COORDINATES[i]).collect();
            parts.push(match angle {
                false => format!("±{} mm along {}", self.half[first], and_list(&names)),
                true => format!("±{}° of {}", in_degrees(first), and_list(&names)),
            });
        }
        parts.join(" and ")
    }

    /// Returns where the corner at `direction` lies, such as `x +1 mm, y −1 mm, yaw +0.5°`.
    fn corner_text(&self, direction: &[f64; 6]) -> String {
        let part = |i: usize| {
            let by = direction[i] * self.half[i];
            match is_angle(i) {
                true => format!("{} {:+}°", COORDINATES[i], (1e6 * by.to_degrees()).round() / 1e6),
                false => format!("{} {by:+} mm", COORDINATES[i]),
            }
        };
        self.coordinates().into_iter().map(part).collect::<Vec<_>>().join(", ").replace('-', "−")
    }
}

/// Returns `names` as a list in a sentence.
fn and_list(names: &[&str]) -> String {
    let list = names.join(", ");
    list.rsplit_once(", ").map_or(list.clone(), |(first, last)| format!("{first} and {last}"))
}

impl Evaluator {
    /// Returns the numbers of the corners of the allowance.
    pub(super) fn corners(&self) -> Range<usize> {
        0..self.study.allowance.corners().len()
    }

    /// Returns `setup` and, behind it, what it is at each corner of the allowance, with the same γ.
    pub(super) fn clamped_setups(&self, setup: &Setup) -> Vec<Setup> {
        let at = |site| Setup { site, gammas: setup.gammas.clone() };
        std::iter::once(setup.site).chain(self.study.allowance.sites(&setup.site)).map(at).collect()
    }

    /// Returns `evaluation` of a place with the worst metrics of these `corners` of its allowance, each as `evaluate` finds it. `Err` says at which it
    /// cannot be cut.
    pub(super) fn with_corners(
        &self,
        mut evaluation: Evaluation,
        corners: impl IntoIterator<Item = usize>,
        mut evaluate: impl FnMut(usize) -> Result<Evaluation, Failure>,
    ) -> Result<Evaluation, Failure> {
        let allowance = &self.study.allowance;
        let directions = allowance.corners();
        for corner in corners {
            let located = |failure: Failure| Failure {
                reason: format!(
                    "clamped at {} from there: {}",
                    allowance.corner_text(&directions[corner]),
                    failure.reason
                ),
                ..failure
            };
            let own = evaluate(corner).map_err(located)?;
            let deflection = |own: &Evaluation| own.metrics.get(Metric::WorstDeflection);
            if deflection(&own) > deflection(&evaluation) {
                evaluation.worst_corner = Some(corner);
            }
            evaluation.worsen_by(&own);
        }
        Ok(evaluation)
    }

    /// Evaluates `setup` exactly there, or clamped at this `corner` of its allowance alone.
    pub(super) fn evaluate_clamped(&self, setup: &Setup, corner: Option<usize>) -> Result<Evaluation, Failure> {
        let clamped = corner.map(|corner| self.clamped_setups(setup).swap_remove(1 + corner));
        self.conclude_placed(&self.all_points(self.begin_setup(clamped.as_ref().unwrap_or(setup))?, &mut None)?)
    }

    /// Starts an evaluation at `setup`. `Err` says why the workpiece must not stand there.
    pub(super) fn begin_setup(&self, setup: &Setup) -> Result<PartialEvaluation, Failure> {
        self.check_workspace(setup)?;
        self.check_boxes(&setup.site)?;
        self.begin_at(setup.clone())
    }

    /// Evaluates `site` level by level, first exactly there, then at these `corners` of its allowance, as a piece of `work`; `None` where it cannot be
    /// cut, or once `value` of the best possible metrics reaches `below`, or if that is stopped.
    pub(super) fn evaluate_below_in_work(
        &self,
        work: &Work,
        (site, corners): (&Site, &[usize]),
        value: &dyn Fn(&Metrics) -> f64,
        below: f64,
    ) -> Option<Evaluation> {
        let evaluate = || {
            let partial = self.begin_evaluation(site).ok()?;
            let setups = self.clamped_setups(&partial.setup);
            let mut evaluation = self.evaluate_levels_below(partial, |best| value(best) >= below)?;
            for corner in corners {
                let is_enough = |best: &Metrics| value(&evaluation.metrics.worse_of(best)) >= below;
                let begun = self.begin_setup(&setups[1 + corner]).ok()?;
                evaluation.worsen_by(&self.evaluate_levels_below(begun, is_enough)?);
            }
            Some(evaluation)
        };
        work.part("below").piece(&(site.0, corners, below), |_| 0, || Ok(evaluate())).ok().flatten()
    }
}

impl Evaluation {
    /// Takes the worse of each number of this place and `other`, another where the workpiece may be clamped.
    fn worsen_by(&mut self, other: &Self) {
        self.metrics = self.metrics.worse_of(&other.metrics);
        for (own, other) in self.features.iter_mut().zip(&other.features) {
            *own = own.worse_of(other);
        }
        self.open_backlash_mm = self.open_backlash_mm.zip(other.open_backlash_mm).map(|(a, b)| a.max(b));
        self.not_corrected = self.not_corrected.take().or_else(|| other.not_corrected.clone());
    }
}
