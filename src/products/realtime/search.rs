//! Searches the largest errors of generated functions over their domain, and from the worst points on.

use nalgebra::Vector3;
use rayon::prelude::*;

use super::{
    domain::{Domain, Sample, corners, sequence_point},
    exact::{ReferenceSolver, Storage},
    function::Function,
};

/// Worst places from which the search goes on, and the steps that it makes there, as shares of half the domain.
const REFINED: usize = 6;
const FIRST_STEP: f64 = 0.2;
const HALVINGS: usize = 4;

/// Errors of the functions at a point, or the largest at several.
#[derive(Debug, Clone)]
pub(super) struct TipError {
    /// Distance of the tool tip from its wanted position at the start and after each step, mm.
    pub correct: Vec<f64>,
    /// Distance of the position found from that of the tool tip at the start and after each step, mm.
    pub whereabouts: Vec<f64>,
    /// Sizes of the last step: of the drives (mm, rad), and of the platform position, mm.
    pub last_step: [[f64; 3]; 2],
}

impl TipError {
    /// Returns zero errors.
    fn zero(steps: usize) -> Self {
        Self { correct: vec![0.0; steps + 1], whereabouts: vec![0.0; steps + 1], last_step: [[0.0; 3]; 2] }
    }

    /// Returns the larger of the two for each error.
    fn max(mut self, other: &TipError) -> Self {
        let errors = self.correct.iter_mut().chain(&mut self.whereabouts);
        let errors = errors.zip(other.correct.iter().chain(&other.whereabouts));
        let steps = self.last_step.iter_mut().flatten().zip(other.last_step.iter().flatten());
        for (own, &other) in errors.chain(steps) {
            *own = crate::spatial::larger(*own, other);
        }
        self
    }

    /// Returns the larger of the two errors after the last step, mm.
    fn last_error(&self) -> f64 {
        let last = |errors: &[f64]| errors.last().copied().unwrap_or(0.0);
        crate::spatial::larger(last(&self.correct), last(&self.whereabouts))
    }
}

/// Compares functions with the reference solver.
pub(super) struct Search<'a> {
    pub exact: &'a ReferenceSolver,
    pub domain: &'a Domain,
    pub steps: usize,
}

/// The function from positions to drives, and the inverse function once there is one.
type Functions<'a> = (&'a Function, Option<&'a Function>);

impl Search<'_> {
    /// Returns the errors at a point of the domain; infinite where the machine has no equilibrium at the drives found.
    fn errors_at(&self, (correct, whereabouts): Functions<'_>, sample: &Sample, storage: &mut Storage) -> TipError {
        let (position, wrench) = self.domain.task_at(sample);
        let mut values = Vec::new();
        let states = correct.states(&position, &wrench, self.steps, &mut values);
        let last = states.last().map_or(&[][..], Vec::as_slice);
        let drives_of = |state: &[f64]| -> [f64; 3] { std::array::from_fn(|i| state[i]) };
        let tips: Vec<_> =
            states.iter().map(|state| self.exact.tip(&drives_of(state), &wrench, last, storage)).collect();
        let off = |tip: Option<Vector3<f64>>, from: Vector3<f64>| {
            let distance = tip.map_or(f64::INFINITY, |tip| (tip - from).norm());
            if distance.is_nan() { f64::INFINITY } else { distance }
        };
        let loaded_tip = tips.last().copied().flatten();
        let back = whereabouts.map(|own| (own, own.states(&drives_of(last), &wrench, self.steps, &mut values)));
        let found = back.iter().flat_map(|(_, states)| states).map(|state| off(loaded_tip, self.exact.tip_of(state)));
        TipError {
            whereabouts: found.collect(),
            correct: tips.iter().map(|&tip| off(tip, position.into())).collect(),
            last_step: [
                last_step_change(correct, &states),
                back.as_ref().map_or([0.0; 3], |(own, states)| last_step_change(own, states)),
            ],
        }
    }

    /// Returns the errors at each of `places`, in their order, computed in parallel.
    fn errors(&self, pair: Functions<'_>, places: Vec<Sample>) -> Vec<(Sample, TipError)> {
        places
            .into_par_iter()
            .map_init(|| self.exact.storage(), |storage, place| (place, self.errors_at(pair, &place, storage)))
            .collect()
    }

    /// Returns the largest errors at some corners and at the first `count` points of the sequence.
    pub fn quick_search(&self, pair: Functions<'_>, count: usize) -> TipError {
        let places = corners().step_by(7).chain((0..count).map(sequence_point)).collect();
        self.errors(pair, places).iter().fold(TipError::zero(self.steps), |largest, (_, found)| largest.max(found))
    }

    /// Returns the largest errors at all corners, at `places` points of the sequence, and on searches uphill from the worst of them.
    pub fn full_search(&self, pair: Functions<'_>, places: usize) -> TipError {
        let mut ranked = self.errors(pair, corners().chain((0..places).map(sequence_point)).collect());
        let mut largest = ranked.iter().fold(TipError::zero(self.steps), |largest, (_, found)| largest.max(found));
        ranked.sort_by(|a, b| b.1.last_error().total_cmp(&a.1.last_error()));
        ranked.truncate(REFINED);
        let refine = |storage: &mut Storage, start| self.climb(pair, start, storage);
        let refined: Vec<TipError> = ranked.into_par_iter().map_init(|| self.exact.storage(), refine).collect();
        for found in &refined {
            largest = largest.max(found);
        }
        largest
    }

    /// Returns the largest errors on a coordinate search uphill from a sample, whose errors are given.
    fn climb(&self, pair: Functions<'_>, (mut place, mut best): (Sample, TipError), storage: &mut Storage) -> TipError {
        let mut largest = best.clone();
        let mut step = FIRST_STEP;
        for _ in 0..HALVINGS {
            for coordinate in 0..place.len() {
                for sign in [1.0, -1.0] {
                    let mut beside = place;
                    beside[coordinate] = (place[coordinate] + sign * step).clamp(-1.0, 1.0);
                    let found = self.errors_at(pair, &beside, storage);
                    largest = largest.max(&found);
                    if found.last_error() > best.last_error() {
                        (place, best) = (beside, found);
                    }
                }
            }
            step *= 0.5;
        }
        largest
    }
}

/// Returns the size of the last change of each unknown (mm, rad) in the `states` after each step; zero with fewer than two.
fn last_step_change(function: &Function, states: &[Vec<f64>]) -> [f64; 3] {
    let Some([before, after]) = states.last_chunk::<2>() else { return [0.0; 3] };
    let (before, after) = (function.unknowns(before), function.unknowns(after));
    std::array::from_fn(|i| (after[i] - before[i]).abs())
}
