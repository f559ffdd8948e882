//! Margins of the best place: how far the workpiece can be moved before the objective is 5 % worse or the workpiece cannot be cut.
//!
//! Objective and limits are probed in steps. Where forbidden boxes and the workspace box end a motion is known without: places that keep
//! them are apart by a known gap, and moving by less cannot close it, so a thin box is not stepped over. Nor is a limit of a drive, a joint
//! or a force: between two probes a quantity deviates from the straight line between its two values by at most an eighth of its curvature
//! times the square of the step. The curvature is that of the parabolas through the probes around, times [`SAFETY`]. Where a limit might
//! be exceeded by that, the step is halved, down to the resolution, at which it counts as exceeded.

use std::f64::consts::PI;

use nalgebra::Vector3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::{
    PlacementStudy,
    evaluate::{Evaluation, Evaluator},
    site::is_angle,
    turned::Setup,
};
use crate::{
    input::error,
    simulation::Failure,
    work::{Event, Stage, Work, if_this_shard},
};

/// Share of its best value by which the objective may become worse.
pub const WORSE: f64 = 0.05;
/// Number of steps over a coordinate's range at which the objective is probed.
const STEPS: f64 = 32.0;

/// Reason why a margin ends.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum End {
    /// The objective is worse by [`WORSE`].
    Worse,
    /// The bound of the coordinate.
    Bound,
    /// None: an angle that may make a full turn.
    Nowhere,
    /// The workpiece cannot be cut beyond, with the reason.
    Infeasible(String),
}

/// Margin along one coordinate in one direction.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Margin {
    /// Index of the coordinate of the [`Site`](super::Site).
    pub coordinate: usize,
    /// +1 or −1.
    pub direction: f64,
    /// The margin, mm or rad.
    pub distance: f64,
    /// Why it ends.
    pub end: End,
    /// Whether the bound of the search ends it at once, though the objective is better beyond.
    pub is_better_beyond: bool,
}

/// Computes the margins of the place `best` with its objective, along each free coordinate in both directions, with the γ of the program; none
/// without a place.
pub(super) fn margins(
    evaluator: &Evaluator,
    study: &PlacementStudy,
    work: &Work,
    best: Option<(Setup, f64)>,
) -> error::Result<Vec<Margin>> {
    let directions: Vec<(usize, f64)> = study.bounds.free().into_iter().flat_map(|i| [(i, -1.0), (i, 1.0)]).collect();
    work.tell(Event::Stage(Stage { of: "ways from the best place", items: directions.len() }));
    let Some((placed, value)) = best else { return Ok(Vec::new()) };
    let (best, limit) = (placed.site, value + WORSE * value.abs());
    let margin_of = |&(coordinate, direction): &(usize, f64)| {
        let is_full_turn = study.bounds.is_full_turn(coordinate);
        let reach = match (is_full_turn, direction > 0.0) {
            (true, _) => PI,
            (_, true) => study.bounds.high[coordinate] - best.0[coordinate],
            _ => best.0[coordinate] - study.bounds.low[coordinate],
        };
        let step = study.bounds.range(coordinate) / STEPS;
        let moved = |distance: f64| Setup {
            site: study.bounds.moved(&best, coordinate, direction * distance),
            gammas: placed.gammas.clone(),
        };
        let free = match is_angle(coordinate) {
            true => free_rotation(evaluator, reach, &moved),
            false => {
                let axis = Vector3::from_fn(|i, _| if i == coordinate { direction } else { 0.0 });
                evaluator.free_translation(&placed, &axis).min(reach)
            }
        };
        let probe = |distance: f64| {
            let infeasible = |failure: Failure| End::Infeasible(failure.reason);
            work.check().map_err(|error| End::Infeasible(error.to_string()))?;
            let (evaluation, shares) = evaluator.evaluate_with_shares(&moved(distance)).map_err(infeasible)?;
            let is_good = study.objective.value(&evaluation.metrics) <= limit;
            if is_good { Ok(Probe { at: distance, shares }) } else { Err(End::Worse) }
        };
        let (distance, mut end) = margin_along(free, step, probe);
        if end == End::Bound && free < reach {
            let beyond = evaluator.evaluate_with_shares(&moved(free + PAST));
            end = End::Infeasible(beyond.err().map_or_else(|| "a box is in the way".into(), |failure| failure.reason));
        } else if end == End::Bound && is_full_turn {
            end = End::Nowhere;
        }
        let shifted = |by: f64| {
            let mut site = best;
            site.0[coordinate] += direction * (reach + by);
            site
        };
        let beyond = |by: f64| evaluator.evaluate_in_work(work, &shifted(by));
        // A bound may be that of the machine; that of a search is in the way only where more is to be had behind it.
        if end == End::Bound
            && let Err(failure) =
                evaluator.evaluate_with_shares(&Setup { site: shifted(PAST), gammas: placed.gammas.clone() })
        {
            end = End::Infeasible(failure.reason);
        }
        let is_at_bound = end == End::Bound && distance < step;
        let is_better = |own: Evaluation| study.objective.value(&own.metrics) < value - NOTABLE * value.abs();
        let is_better_beyond = is_at_bound && BEYOND.iter().any(|share| beyond(share * step).is_ok_and(is_better));
        work.check()?;
        work.tell(Event::Computed(1));
        Ok(Margin { coordinate, direction, distance, end, is_better_beyond })
    };
    let in_shard = |(number, to): (usize, &(usize, f64))| {
        if_this_shard(work.part("room").shard(number).piece(&(best.0, to), |_| 1, || margin_of(to))).transpose()
    };
    let found = directions.par_iter().enumerate().filter_map(in_shard).collect::<error::Result<_>>()?;
    work.barrier()?;
    Ok(found)
}

/// Smaller gaps are closed, mm.
const CLOSED: f64 = 1e-6;
/// Distance beyond a box or bound at which the reason is evaluated, more than what counts as rounding, mm or rad.
const PAST: f64 = 1e-3;
/// Share of its best value by which the objective must be better beyond a bound.
const NOTABLE: f64 = 1e-3;
/// Shares of a step at which better places are sought beyond a bound.
const BEYOND: [f64; 4] = [1.0, 0.5, 0.25, 0.125];
/// Smallest number of steps over an angle's range, where a gap that stays closed gives no step.
const LOOKS: f64 = 4096.0;

/// Returns by which angle up to `reach`, rad, the workpiece can rotate before it meets a box; `moved` returns its place after a rotation.
fn free_rotation(evaluator: &Evaluator, reach: f64, moved: &impl Fn(f64) -> Setup) -> f64 {
    let (mut free, radius) = (0.0, evaluator.workpiece_radius());
    while free < reach {
        let gap = evaluator.clearance(&moved(free));
        let next = (free + (gap / radius).max(reach / LOOKS)).min(reach);
        if gap <= CLOSED + radius * reach / LOOKS && !evaluator.is_clear(&moved(next)) {
            return bisect(free, next, |angle| evaluator.is_clear(&moved(angle)));
        }
        free = next;
    }
    reach
}

/// Returns by bisection the last value from `inside`, where `holds` is true, towards `outside`, where it is not.
fn bisect(mut inside: f64, mut outside: f64, holds: impl Fn(f64) -> bool) -> f64 {
    for _ in 0..32 {
        let middle = 0.5 * (inside + outside);
        if holds(middle) { inside = middle } else { outside = middle }
    }
    inside
}

/// Number of halvings of a step down to the resolution.
const HALVINGS: i32 = 12;
/// Factor on the curvature of the probes around, for the curvature between them.
const SAFETY: f64 = 4.0;
/// Rounding of a share of a limit.
const ROUNDING: f64 = 1e-12;
/// Reason of a margin that ends at no probe.
const TOO_NEAR: &str = "a drive or joint comes nearer to its limit than the steps of the search for the way can tell";

/// Limited quantities at a distance at which the workpiece can be cut.
#[derive(Debug, Clone)]
pub struct Probe {
    /// Its distance, mm or rad.
    pub at: f64,
    /// Position of each limited quantity between its limits, −1 and 1.
    pub shares: Vec<f64>,
}

/// A search along one direction for the end of the margin.
struct MarginSearch<F> {
    reach: f64,
    step: f64,
    evaluate: F,
}

/// Returns the first distance up to `reach` where `evaluate` finds an end or a limit may be exceeded between probes, mm or rad, and why.
pub fn margin_along(reach: f64, step: f64, evaluate: impl Fn(f64) -> Result<Probe, End>) -> (f64, End) {
    match evaluate(0.0) {
        Ok(start) => MarginSearch { reach, step, evaluate }.end_beyond(None, start, None),
        Err(end) => (0.0, end),
    }
}

impl<F: Fn(f64) -> Result<Probe, End>> MarginSearch<F> {
    /// Returns the smallest step, mm or rad.
    fn resolution(&self) -> f64 {
        self.step * 0.5f64.powi(HALVINGS)
    }

    /// Returns the end of the margin beyond the probe `from`; `before` is the probe before it, `known_end` an end known to lie ahead.
    fn end_beyond(&self, mut before: Option<Probe>, mut from: Probe, mut known_end: Option<(f64, End)>) -> (f64, End) {
        // The probe after `from`; the interval before it is verified once the probe after it is there.
        let mut to: Option<Probe> = None;
        loop {
            let last = to.as_ref().unwrap_or(&from).at;
            let next = match &known_end {
                Some((end, _)) if end - last > self.resolution() => 0.5 * (last + end),
                None if last < self.reach => (last + self.step).min(self.reach),
                _ => {
                    let left = to.map_or(Ok(()), |to| self.verify_interval(before.as_ref(), &from, &to, None));
                    return left.err().unwrap_or_else(|| known_end.map_or((last, End::Bound), |(_, end)| (last, end)));
                }
            };
            match (self.evaluate)(next) {
                Err(end) => known_end = Some((next, end)),
                Ok(after) => {
                    if let Some(to) = to.take() {
                        if let Err(end) = self.verify_interval(before.as_ref(), &from, &to, Some(&after)) {
                            return end;
                        }
                        before = Some(std::mem::replace(&mut from, to));
                    }
                    to = Some(after);
                }
            }
        }
    }

    /// Checks that no limited quantity can exceed its limit between the neighbouring probes `a` and `b`; `before` and `after` are the probes on
    /// either side, for the curvature. Where this is not certain it evaluates the middle and recurses down to the resolution. `Err`: distance
    /// (mm or rad) at which the margin ends, and why.
    fn verify_interval(
        &self,
        before: Option<&Probe>,
        a: &Probe,
        b: &Probe,
        after: Option<&Probe>,
    ) -> Result<(), (f64, End)> {
        if is_within_limits(before, a, b, after) {
            return Ok(());
        }
        if b.at - a.at <= self.resolution() {
            let has_curvature = before.is_some() || after.is_some();
            return if has_curvature { Err((a.at, End::Infeasible(TOO_NEAR.into()))) } else { Ok(()) };
        }
        let middle = 0.5 * (a.at + b.at);
        match (self.evaluate)(middle) {
            Ok(middle) => {
                self.verify_interval(before, a, &middle, Some(b))?;
                self.verify_interval(Some(a), &middle, b, after)
            }
            Err(end) => Err(self.end_beyond(before.cloned(), a.clone(), Some((middle, end)))),
        }
    }
}

/// Returns whether no limited quantity can exceed ±1 between `a` and `b`, if it bends no more than [`SAFETY`] times as around them.
fn is_within_limits(before: Option<&Probe>, a: &Probe, b: &Probe, after: Option<&Probe>) -> bool {
    if before.is_none() && after.is_none() {
        return a.shares.is_empty();
    }
    let step = b.at - a.at;
    (0..a.shares.len()).all(|i| {
        let value = |probe: &Probe| (probe.at, probe.shares[i]);
        let bends = [
            before.map(|before| second_derivative(value(before), value(a), value(b))),
            after.map(|after| second_derivative(value(a), value(b), value(after))),
        ];
        // A bend downwards carries it over the upper limit, one upwards over the lower.
        let extreme = |sign: f64| {
            let bend = bends.iter().flatten().map(|bend| -sign * bend).fold(0.0, f64::max);
            bow_maximum(sign * a.shares[i], sign * b.shares[i], 0.5 * SAFETY * bend * step * step)
        };
        extreme(1.0).max(extreme(-1.0)) <= 1.0 + ROUNDING
    })
}

/// Returns the second derivative of the parabola through three points.
fn second_derivative((x0, y0): (f64, f64), (x1, y1): (f64, f64), (x2, y2): (f64, f64)) -> f64 {
    2.0 * ((y2 - y1) / (x2 - x1) - (y1 - y0) / (x1 - x0)) / (x2 - x0)
}

/// Returns the largest value, for t from 0 to 1, of the parabola `a + (b − a) t + bow t (1 − t)`; `bow` is not negative.
fn bow_maximum(a: f64, b: f64, bow: f64) -> f64 {
    if (b - a).abs() >= bow {
        return a.max(b);
    }
    let t = 0.5 * (1.0 + (b - a) / bow);
    a + bow * t * t
}
