//! A pattern search: the last steps to a best place, where worst values have edges on which Nelder–Mead stays lying.
//!
//! Places a step away along the axes of a basis are looked at, in both senses; the first better one is taken and the step
//! doubled, and where none is better the step is halved. Each basis is turned differently, by a fixed sequence, so that
//! an edge which runs between the axes of one is met by another. Of a place that is no better nothing needs to be known
//! but that.

use super::{
    PlacementStudy,
    site::{Bounds, Site},
};
use crate::spatial::radical_inverse;

/// Steps of a pattern search, in steps of the grid.
#[derive(Debug, Clone, Copy)]
pub(super) struct Steps {
    /// The first one, which none exceeds.
    pub first: f64,
    /// Below it the search ends, or begins again with the first one.
    pub last: f64,
    /// Bases along which no step may be better before the search ends: where several values have an edge, few ways lead
    /// on, and the bases of one search may all miss them.
    pub bases: usize,
}

/// Most places that are looked at.
const MOST: usize = 600;

/// Makes `cost` small from `start` on, whose cost is given, until it is at most `goal` or steps are small. `cost` is told
/// the value below which a place is better, and may answer with infinity instead of anything that is not.
pub(super) fn polish(
    study: &PlacementStudy,
    start: (Site, f64),
    steps: Steps,
    goal: f64,
    mut cost: impl FnMut(&Site, f64) -> f64,
) -> (Site, f64) {
    let free = study.bounds.free();
    let units: Vec<f64> = free.iter().map(|&i| study.grid.step(i, &study.bounds)).collect();
    let (mut found, mut size, mut looked, mut fruitless) = (start, steps.first, 0, 0);
    let mut last_way: Option<Vec<f64>> = None;
    for turn in 0.. {
        if size < steps.last || found.1 <= goal || looked >= MOST || free.is_empty() {
            break;
        }
        let ways = last_way.take().into_iter().chain(basis(free.len(), turn).into_iter().flat_map(both_senses));
        let mut is_better = false;
        for way in ways {
            let site = moved(&study.bounds, &found.0, &free, &units, &way, size);
            if site == found.0 {
                continue;
            }
            // A gain that rounding could give is none.
            let below = found.1 - GAIN * found.1.abs();
            looked += 1;
            let value = cost(&site, below);
            if value < below {
                found = (site, value);
                last_way = Some(way);
                is_better = true;
                break;
            }
        }
        fruitless = if is_better { 0 } else { fruitless + 1 };
        size = if is_better { (2.0 * size).min(steps.first) } else { 0.5 * size };
        if size < steps.last && fruitless < steps.bases {
            size = steps.first;
        }
    }
    found
}

/// Share of a value that a better one is better by.
const GAIN: f64 = 1e-7;

fn moved(bounds: &Bounds, from: &Site, free: &[usize], units: &[f64], way: &[f64], size: f64) -> Site {
    let parts = free.iter().zip(units).zip(way);
    parts.fold(*from, |site, ((&i, unit), part)| bounds.moved(&site, i, part * unit * size))
}

fn both_senses(way: Vec<f64>) -> [Vec<f64>; 2] {
    let back = way.iter().map(|part| -part).collect();
    [way, back]
}

/// An orthonormal basis, the axes themselves first: of the reflection along a direction that a low-discrepancy sequence
/// gives.
pub fn basis(n: usize, turn: usize) -> Vec<Vec<f64>> {
    const PRIMES: [usize; 6] = [2, 3, 5, 7, 11, 13];
    let normal: Vec<f64> = PRIMES[..n].iter().map(|&prime| 2.0 * radical_inverse(turn, prime) - 1.0).collect();
    let square: f64 = normal.iter().map(|part| part * part).sum();
    let column = |j: usize| {
        let entry = |i: usize| {
            let axis = if i == j { 1.0 } else { 0.0 };
            if turn == 0 || square == 0.0 { axis } else { axis - 2.0 * normal[i] * normal[j] / square }
        };
        (0..n).map(entry).collect()
    };
    (0..n).map(column).collect()
}
