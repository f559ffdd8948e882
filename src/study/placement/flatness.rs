//! How far a workpiece may be moved from its best place before that matters.
//!
//! Objective and limits are looked at in steps. Where forbidden boxes and the workspace box end a way is known without:
//! places that keep them are apart by a known gap, and moving by less cannot close it, so a thin box is not stepped over.

use std::f64::consts::PI;

use nalgebra::Vector3;
use rayon::prelude::*;

use super::{
    Best, PlacementStudy,
    evaluate::Evaluator,
    site::{Site, is_angle},
};
use crate::study::{Work, work::Event};

/// The objective counts as worse beyond this share of its best value.
pub const WORSE: f64 = 0.05;
/// Steps over a coordinate's range at which the objective is looked at.
const STEPS: f64 = 32.0;
/// Halvings of the last step.
const HALVINGS: usize = 12;

/// What ends the way in one direction.
#[derive(Debug, Clone, PartialEq)]
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
#[derive(Debug, Clone, PartialEq)]
pub struct Room {
    /// Index of the coordinate of the [`Site`](super::Site).
    pub coordinate: usize,
    /// +1 or −1.
    pub direction: f64,
    /// How far, mm or rad.
    pub distance: f64,
    /// What ends the way.
    pub end: End,
}

/// The way from `best` along each free coordinate in both directions.
pub(super) fn flatness(evaluator: &Evaluator<'_>, study: &PlacementStudy, work: &Work, best: &Best) -> Vec<Room> {
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
        let look = |distance: f64| match evaluator.kept(work, &moved(distance)) {
            Ok(evaluation) if study.objective.value(&evaluation.metrics) <= limit => None,
            Ok(_) => Some(End::Worse),
            Err(failure) => Some(End::Infeasible(failure.reason)),
        };
        let (distance, mut end) = way(free, step, look);
        if end == End::Bound && free < reach {
            let beyond = evaluator.kept(work, &moved(free + PAST));
            end = End::Infeasible(beyond.err().map_or_else(|| "a box is in the way".into(), |failure| failure.reason));
        } else if end == End::Bound && is_full_turn {
            end = End::Nowhere;
        }
        work.tell(Event::Computed(1));
        Room { coordinate, direction, distance, end }
    };
    ways.par_iter().map(room).collect()
}

/// A gap this small is closed, mm; so far past the end of a free way it is not kept, mm or rad.
const CLOSED: f64 = 1e-6;
const PAST: f64 = 1e-5;
/// Least steps over an angle's range, where a gap that stays closed tells nothing.
const LOOKS: f64 = 4096.0;

/// How far the workpiece may be turned before it meets a box, at most `reach`, rad.
fn free_turn(evaluator: &Evaluator<'_>, reach: f64, moved: &impl Fn(f64) -> Site) -> f64 {
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

/// The first distance at which `look` finds an end, at most `reach`.
fn way(reach: f64, step: f64, look: impl Fn(f64) -> Option<End>) -> (f64, End) {
    let mut good = 0.0;
    while good < reach {
        let next = (good + step).min(reach);
        let Some(mut end) = look(next) else {
            good = next;
            continue;
        };
        let mut bad = next;
        for _ in 0..HALVINGS {
            let middle = 0.5 * (good + bad);
            match look(middle) {
                None => good = middle,
                Some(nearer) => (bad, end) = (middle, nearer),
            }
        }
        return (good, end);
    }
    (reach, End::Bound)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_way_ends_where_it_gets_worse_or_at_the_bound() {
        let (distance, end) = way(10.0, 1.0, |d| (d > 3.3).then_some(End::Worse));
        assert!((distance - 3.3).abs() < 5e-3 && end == End::Worse);
        assert_eq!(way(2.5, 1.0, |_| None), (2.5, End::Bound));
        assert_eq!(way(0.0, 1.0, |_| Some(End::Worse)), (0.0, End::Bound));
    }
}
