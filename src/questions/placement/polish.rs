//! A pattern search for the last steps to a best place: worst values have edges on which Nelder–Mead gets stuck.
//!
//! It tries places a step away along the axes of a basis, in both directions. The first better one is taken and the step doubled; where
//! none is better the step is halved. Each basis is rotated differently, by a fixed sequence, so that an edge which runs between the axes
//! of one is met by another. A place that is no better needs no exact value.

use std::f64::consts::FRAC_PI_4;

use super::{
    PlacementStudy,
    site::{Bounds, Site},
};
use crate::spatial::radical_inverse;

/// Steps of a pattern search, in steps of the sweep's grid.
#[derive(Debug, Clone, Copy)]
pub(super) struct Steps {
    /// The first step, which is also the largest.
    pub first: f64,
    /// Step below which the search ends, or begins again with the first one.
    pub last: f64,
    /// Number of consecutive bases without a better place before the search ends, since at an edge few directions lead on.
    pub bases: usize,
}

/// Largest number of places tried.
const MOST: usize = 600;

/// Minimises `cost` from `start` until it is at most `goal` or steps are small; returns the best place with its cost. `cost` gets a place
/// and the cost below which it is better, and may return infinity for any that is not.
pub(super) fn pattern_search(
    study: &PlacementStudy,
    start: (Site, f64),
    steps: Steps,
    goal: f64,
    mut cost: impl FnMut(&Site, f64) -> f64,
) -> (Site, f64) {
    let free = study.bounds.free();
    let units: Vec<f64> = free.iter().map(|&i| study.grid.step(i, &study.bounds)).collect();
    let (mut best, mut size, mut tries, mut fruitless) = (start, steps.first, 0, 0);
    let mut last_direction: Option<Vec<f64>> = None;
    for round in 0.. {
        if size < steps.last || best.1 <= goal || tries >= MOST || free.is_empty() {
            break;
        }
        let both = |own: Vec<f64>| [own.clone(), own.iter().map(|part| -part).collect()];
        let directions = last_direction.take().into_iter().chain(basis(free.len(), round).into_iter().flat_map(both));
        let mut is_better = false;
        for direction in directions {
            let site = moved(&study.bounds, &best.0, &free, &units, &direction, size);
            if site == best.0 {
                continue;
            }
            // A gain that rounding could give is none.
            let below = best.1 - GAIN * best.1.abs();
            tries += 1;
            let value = cost(&site, below);
            if value < below {
                best = (site, value);
                last_direction = Some(direction);
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
    best
}

/// Smallest gain, as a share of the value, that counts as one.
const GAIN: f64 = 1e-7;

/// Returns `from` moved by `size` steps along `direction` in the free coordinates, within the bounds.
fn moved(bounds: &Bounds, from: &Site, free: &[usize], units: &[f64], direction: &[f64], size: f64) -> Site {
    let parts = free.iter().zip(units).zip(direction);
    parts.fold(*from, |site, ((&i, unit), part)| bounds.moved(&site, i, part * unit * size))
}

/// Returns an orthonormal basis of `n` dimensions: the axes in `round` 0, else their reflection along a low-discrepancy direction. In two
/// dimensions the right angle is divided evenly: eight bases that follow each other leave at most 22.5° between directions.
pub fn basis(n: usize, round: usize) -> Vec<Vec<f64>> {
    const PRIMES: [usize; 6] = [2, 3, 5, 7, 11, 13];
    let normal: Vec<f64> = if n == 2 {
        let (sin, cos) = libm::sincos(FRAC_PI_4 * radical_inverse(round, 2));
        vec![cos, sin]
    } else {
        PRIMES[..n].iter().map(|&prime| 2.0 * radical_inverse(round, prime) - 1.0).collect()
    };
    let square: f64 = normal.iter().map(|part| part * part).sum();
    let column = |j: usize| {
        let entry = |i: usize| {
            let axis = if i == j { 1.0 } else { 0.0 };
            if round == 0 || square == 0.0 { axis } else { axis - 2.0 * normal[i] * normal[j] / square }
        };
        (0..n).map(entry).collect()
    };
    (0..n).map(column).collect()
}
