//! How far a workpiece may be moved from its best place before that matters.
//!
//! Objective and limits are looked at in steps. Where forbidden boxes and the workspace box end a way is known without:
//! places that keep them are apart by a known gap, and moving by less cannot close it, so a thin box is not stepped over.
//! No limit of a drive, a joint or a force is stepped over either:
//! between two looks a quantity leaves the straight line between its two values by at most an eighth of its curvature
//! times the square of the step. The curvature is that of the parabolas through the looks around, times [`SAFETY`]. Where
//! a limit might be exceeded by that, the step is halved, down to the resolution, at which it counts as exceeded.

use std::f64::consts::PI;

use nalgebra::Vector3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::{
    Best, PlacementStudy,
    evaluate::Evaluator,
    site::{Site, is_angle},
};
use crate::{
    input::error,
    simulation::Failure,
    work::{Event, Work, this_shard},
};

/// The objective counts as worse beyond this share of its best value.
pub const WORSE: f64 = 0.05;
/// Steps over a coordinate's range at which the objective is looked at.
const STEPS: f64 = 32.0;

/// What ends the way in one direction.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum End {
    /// The objective is worse by [`WORSE`].
    Worse,
    /// The bound of the coordinate.
    Bound,
    /// Nothing: an angle that may make a full turn.
    Nowhere,
    /// The workpiece cannot be cut any farther; the reason.
    Infeasible(String),
}

/// How far the workpiece may be moved along one coordinate.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Room {
    /// Index of the coordinate of the [`Site`].
    pub coordinate: usize,
    /// +1 or −1.
    pub direction: f64,
    /// How far, mm or rad.
    pub distance: f64,
    /// What ends the way.
    pub end: End,
}

/// The way from `best` along each free coordinate in both directions.
pub(super) fn flatness(
    evaluator: &Evaluator,
    study: &PlacementStudy,
    work: &Work,
    best: &Best,
) -> error::Result<Vec<Room>> {
    let Best { site: best, value, .. } = best;
    let limit = value + WORSE * value.abs();
    let ways: Vec<(usize, f64)> = study.bounds.free().into_iter().flat_map(|i| [(i, -1.0), (i, 1.0)]).collect();
    let room = |&(coordinate, direction): &(usize, f64)| {
        let is_full_turn = study.bounds.is_full_turn(coordinate);
        let reach = match (is_full_turn, direction > 0.0) {
            (true, _) => PI,
            (_, true) => study.bounds.high[coordinate] - best.0[coordinate],
            _ => best.0[coordinate] - study.bounds.low[coordinate],
        };
        let step = study.bounds.range(coordinate) / STEPS;
        let moved = |distance: f64| study.bounds.moved(best, coordinate, direction * distance);
        let free = match is_angle(coordinate) {
            true => free_turn(evaluator, reach, &moved),
            false => {
                let way = Vector3::from_fn(|i, _| if i == coordinate { direction } else { 0.0 });
                evaluator.free_translation(best, &way).min(reach)
            }
        };
        let look = |distance: f64| {
            let refused = |failure: Failure| End::Infeasible(failure.reason);
            work.check().map_err(|error| End::Infeasible(error.to_string()))?;
            let (evaluation, shares) = evaluator.evaluate_within(&moved(distance)).map_err(refused)?;
            let is_good = study.objective.value(&evaluation.metrics) <= limit;
            if is_good { Ok(Sight { at: distance, shares }) } else { Err(End::Worse) }
        };
        let (distance, mut end) = way(free, step, look);
        if end == End::Bound && free < reach {
            let beyond = evaluator.kept(work, &moved(free + PAST));
            end = End::Infeasible(beyond.err().map_or_else(|| "a box is in the way".into(), |failure| failure.reason));
        } else if end == End::Bound && is_full_turn {
            end = End::Nowhere;
        }
        work.check()?;
        work.tell(Event::Computed(1));
        Ok(Room { coordinate, direction, distance, end })
    };
    let kept = |(number, way): (usize, &(usize, f64))| {
        this_shard(work.part("room").shard(number).piece(&(best.0, way), |_| 1, || room(way))).transpose()
    };
    let rooms = ways.par_iter().enumerate().filter_map(kept).collect::<error::Result<_>>()?;
    work.barrier()?;
    Ok(rooms)
}

/// A gap this small is closed, mm; so far past the end of a free way it is not kept, mm or rad.
const CLOSED: f64 = 1e-6;
const PAST: f64 = 1e-5;
/// Least steps over an angle's range, where a gap that stays closed tells nothing.
const LOOKS: f64 = 4096.0;

/// How far the workpiece may be turned before it meets a box, at most `reach`, rad.
fn free_turn(evaluator: &Evaluator, reach: f64, moved: &impl Fn(f64) -> Site) -> f64 {
    let mut free = 0.0;
    while free < reach {
        let gap = evaluator.gap(&moved(free));
        let next = (free + (gap / evaluator.radius()).max(reach / LOOKS)).min(reach);
        if gap <= CLOSED + evaluator.radius() * reach / LOOKS && !evaluator.fits(&moved(next)) {
            return halved(free, next, |angle| evaluator.fits(&moved(angle)));
        }
        free = next;
    }
    reach
}

/// The end, between `good` and `bad`, of where something holds.
fn halved(mut good: f64, mut bad: f64, holds: impl Fn(f64) -> bool) -> f64 {
    for _ in 0..32 {
        let middle = 0.5 * (good + bad);
        if holds(middle) { good = middle } else { bad = middle }
    }
    good
}

/// Halvings of a step down to the resolution.
const HALVINGS: i32 = 12;
/// How many times the curvature seen at the looks around it may have between them.
const SAFETY: f64 = 4.0;
/// Rounding of a share.
const ROUNDING: f64 = 1e-12;
/// What ends a way that ends at no look.
const TOO_NEAR: &str = "a drive or joint comes nearer to its limit than the steps of the search for the way can tell";

/// What is seen at a distance on the way where the workpiece can be cut.
#[derive(Debug)]
pub struct Sight {
    /// The distance, mm or rad.
    pub at: f64,
    /// Where each limited quantity stands between its limits, −1 and 1.
    pub shares: Vec<f64>,
}

struct Way<F> {
    reach: f64,
    step: f64,
    look: F,
}

/// The first distance at which `look` finds an end or a limit is exceeded between looks, at most `reach`.
pub fn way(reach: f64, step: f64, look: impl Fn(f64) -> Result<Sight, End>) -> (f64, End) {
    match look(0.0) {
        Ok(start) => Way { reach, step, look }.onward(None, start, None),
        Err(end) => (0.0, end),
    }
}

impl<F: Fn(f64) -> Result<Sight, End>> Way<F> {
    fn resolution(&self) -> f64 {
        self.step * 0.5f64.powi(HALVINGS)
    }

    /// The end of the way from `from`, which follows on `before`; before `bad`, where there is an end.
    fn onward(&self, mut before: Option<Sight>, mut from: Sight, mut bad: Option<(f64, End)>) -> (f64, End) {
        // The look after `from`; the way to it is checked once the one after it is there.
        let mut to: Option<Sight> = None;
        loop {
            let last = to.as_ref().unwrap_or(&from).at;
            let next = match &bad {
                Some((bad, _)) if bad - last > self.resolution() => 0.5 * (last + bad),
                None if last < self.reach => (last + self.step).min(self.reach),
                _ => {
                    let left = to.map_or(Ok(()), |to| self.between(before.as_ref(), &from, &to, None));
                    return left.err().unwrap_or_else(|| bad.map_or((last, End::Bound), |(_, end)| (last, end)));
                }
            };
            match (self.look)(next) {
                Err(end) => bad = Some((next, end)),
                Ok(after) => {
                    if let Some(to) = to.take() {
                        if let Err(end) = self.between(before.as_ref(), &from, &to, Some(&after)) {
                            return end;
                        }
                        before = Some(std::mem::replace(&mut from, to));
                    }
                    to = Some(after);
                }
            }
        }
    }

    /// No limit is exceeded between `a` and `b`, which lie between `before` and `after`; or where the way ends.
    fn between(&self, before: Option<&Sight>, a: &Sight, b: &Sight, after: Option<&Sight>) -> Result<(), (f64, End)> {
        if is_kept(before, a, b, after) {
            return Ok(());
        }
        if b.at - a.at <= self.resolution() {
            let is_seen = before.is_some() || after.is_some();
            return if is_seen { Err((a.at, End::Infeasible(TOO_NEAR.into()))) } else { Ok(()) };
        }
        let middle = 0.5 * (a.at + b.at);
        match (self.look)(middle) {
            Ok(middle) => {
                self.between(before, a, &middle, Some(b))?;
                self.between(Some(a), &middle, b, after)
            }
            Err(end) => {
                let copy = |look: &Sight| Sight { at: look.at, shares: look.shares.clone() };
                Err(self.onward(before.map(copy), copy(a), Some((middle, end))))
            }
        }
    }
}

/// Whether no limit can be exceeded between `a` and `b` with the curvature seen around them.
fn is_kept(before: Option<&Sight>, a: &Sight, b: &Sight, after: Option<&Sight>) -> bool {
    if before.is_none() && after.is_none() {
        return a.shares.is_empty();
    }
    let step = b.at - a.at;
    (0..a.shares.len()).all(|i| {
        let value = |look: &Sight| (look.at, look.shares[i]);
        let bends = [
            before.map(|before| bend(value(before), value(a), value(b))),
            after.map(|after| bend(value(a), value(b), value(after))),
        ];
        // A bend downwards carries it over the upper limit, one upwards over the lower.
        let most = |sign: f64| {
            let bend = bends.iter().flatten().map(|bend| -sign * bend).fold(0.0, f64::max);
            highest(sign * a.shares[i], sign * b.shares[i], 0.5 * SAFETY * bend * step * step)
        };
        most(1.0).max(most(-1.0)) <= 1.0 + ROUNDING
    })
}

/// Second derivative of the parabola through three points.
fn bend((x0, y0): (f64, f64), (x1, y1): (f64, f64), (x2, y2): (f64, f64)) -> f64 {
    2.0 * ((y2 - y1) / (x2 - x1) - (y1 - y0) / (x1 - x0)) / (x2 - x0)
}

/// Largest value for t from 0 to 1 of `a + (b − a) t + bow t (1 − t)`.
fn highest(a: f64, b: f64, bow: f64) -> f64 {
    if (b - a).abs() >= bow {
        return a.max(b);
    }
    let t = 0.5 * (1.0 + (b - a) / bow);
    a + bow * t * t
}
