//! How far a workpiece may be moved from its best place before that matters.
//!
//! Objective and limits are looked at in steps, and limits of drives, joints and forces between them too, see [`way`].
//! Where forbidden boxes and the workspace box end a way is known without:
//! places that keep them are apart by a known gap, and moving by less cannot close it, so a thin box is not stepped over.

use std::f64::consts::PI;

use nalgebra::Vector3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::{
    Best, PlacementStudy,
    evaluate::Evaluator,
    site::{Site, is_angle},
    way::{Look, way},
};
use crate::{
    input::error::Result,
    simulation::Failure,
    work::{Event, Work, here},
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
pub(super) fn flatness(evaluator: &Evaluator, study: &PlacementStudy, work: &Work, best: &Best) -> Result<Vec<Room>> {
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
            if is_good { Ok(Look { at: distance, shares }) } else { Err(End::Worse) }
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
        here(work.part("room").dealt(number).piece(&(best.0, way), |_| 1, || room(way))).transpose()
    };
    let rooms = ways.par_iter().enumerate().filter_map(kept).collect::<Result<_>>()?;
    work.gathered()?;
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
