//! How far a workpiece may be moved from its best place before that matters.

use rayon::prelude::*;

use super::{Best, PlacementStudy, evaluate::Evaluator};
use crate::study::Work;

/// The objective counts as worse beyond this share of its best value.
pub const WORSE: f64 = 0.05;
/// Steps over a coordinate's range at which the objective is looked at.
const STEPS: f64 = 32.0;
/// Halvings of the last step.
const HALVINGS: usize = 8;

/// What ends the way in one direction.
#[derive(Debug, Clone, PartialEq)]
pub enum End {
    /// The objective is worse by [`WORSE`].
    Worse,
    /// The bound of the coordinate.
    Bound,
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
        let reach = match direction > 0.0 {
            true => study.bounds.high[coordinate] - best.0[coordinate],
            false => best.0[coordinate] - study.bounds.low[coordinate],
        };
        let step = study.bounds.range(coordinate) / STEPS;
        let moved = |distance: f64| {
            let mut site = *best;
            site.0[coordinate] += direction * distance;
            site
        };
        let look = |distance: f64| match evaluator.kept(work, &moved(distance)) {
            Ok(evaluation) if study.objective.value(&evaluation.metrics) <= limit => None,
            Ok(_) => Some(End::Worse),
            Err(failure) => Some(End::Infeasible(failure.reason)),
        };
        let (distance, end) = way(reach, step, look);
        Room { coordinate, direction, distance, end }
    };
    ways.par_iter().map(room).collect()
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
