//! The largest errors of generated functions: looked for all over their domain, and from the worst places on.

use nalgebra::Vector3;
use rayon::prelude::*;

use super::{
    domain::{Domain, Place, corners, spread},
    exact::{Asking, Exact},
    function::Function,
};

/// Worst places from which the search goes on, and the steps that it makes there, as shares of half the domain.
const REFINED: usize = 6;
const FIRST_STEP: f64 = 0.2;
const HALVINGS: usize = 4;

/// What was found at a place, or is the largest at several.
#[derive(Debug, Clone)]
pub(super) struct Found {
    /// Distance of the tool tip from where it should be, mm: at the start and after each step.
    pub correct: Vec<f64>,
    /// Distance of the position found from where the tool tip stands, mm.
    pub whereabouts: Vec<f64>,
    /// Changes by the last step: of the drives (mm, rad), and of the platform's place, mm.
    pub last_step: [[f64; 3]; 2],
}

impl Found {
    fn nothing(steps: usize) -> Self {
        Self { correct: vec![0.0; steps + 1], whereabouts: vec![0.0; steps + 1], last_step: [[0.0; 3]; 2] }
    }

    fn with(mut self, other: &Found) -> Self {
        let errors = self.correct.iter_mut().chain(&mut self.whereabouts);
        let errors = errors.zip(other.correct.iter().chain(&other.whereabouts));
        let steps = self.last_step.iter_mut().flatten().zip(other.last_step.iter().flatten());
        for (own, &other) in errors.chain(steps) {
            *own = crate::spatial::larger(*own, other);
        }
        self
    }

    /// The larger of the errors after the last step, mm.
    fn error(&self) -> f64 {
        let last = |errors: &[f64]| errors.last().copied().unwrap_or(0.0);
        crate::spatial::larger(last(&self.correct), last(&self.whereabouts))
    }
}

/// Where and how functions are held against what the program answers.
pub(super) struct Search<'a> {
    pub exact: &'a Exact,
    pub domain: &'a Domain,
    pub steps: usize,
}

/// The function that corrects, and the one that tells where the tool is once there is one.
type Functions<'a> = (&'a Function, Option<&'a Function>);

impl Search<'_> {
    /// The errors at a place; infinite where the machine does not stand as commanded.
    fn at(&self, (correct, whereabouts): Functions<'_>, place: &Place, asking: &mut Asking) -> Found {
        let (position, wrench) = self.domain.asked(place);
        let mut values = Vec::new();
        let states = correct.path(&position, &wrench, self.steps, &mut values);
        let last = states.last().map_or(&[][..], Vec::as_slice);
        let drives_of = |state: &[f64]| -> [f64; 3] { std::array::from_fn(|i| state[i]) };
        let tips: Vec<_> =
            states.iter().map(|state| self.exact.tip(&drives_of(state), &wrench, last, asking)).collect();
        let off = |tip: Option<Vector3<f64>>, from: Vector3<f64>| {
            let distance = tip.map_or(f64::INFINITY, |tip| (tip - from).norm());
            if distance.is_nan() { f64::INFINITY } else { distance }
        };
        let stands = tips.last().copied().flatten();
        let back = whereabouts.map(|own| (own, own.path(&drives_of(last), &wrench, self.steps, &mut values)));
        let found = back.iter().flat_map(|(_, states)| states).map(|state| off(stands, self.exact.tip_of(state)));
        Found {
            whereabouts: found.collect(),
            correct: tips.iter().map(|&tip| off(tip, position.into())).collect(),
            last_step: [
                last_step(correct, &states),
                back.as_ref().map_or([0.0; 3], |(own, states)| last_step(own, states)),
            ],
        }
    }

    /// The largest errors at `places`, and the places with the errors there.
    fn over(&self, held: Functions<'_>, places: Vec<Place>) -> Vec<(Place, Found)> {
        places
            .into_par_iter()
            .map_init(|| self.exact.asking(), |asking, place| (place, self.at(held, &place, asking)))
            .collect()
    }

    /// The largest errors at the corners and at the first `count` places of the domain.
    pub fn briefly(&self, held: Functions<'_>, count: usize) -> Found {
        let places = corners().step_by(7).chain((0..count).map(spread)).collect();
        self.over(held, places).iter().fold(Found::nothing(self.steps), |largest, (_, found)| largest.with(found))
    }

    /// The largest errors that are found at the corners, at so many places and from the worst of them on.
    pub fn thoroughly(&self, held: Functions<'_>, places: usize) -> Found {
        let mut seen = self.over(held, corners().chain((0..places).map(spread)).collect());
        let mut largest = seen.iter().fold(Found::nothing(self.steps), |largest, (_, found)| largest.with(found));
        seen.sort_by(|a, b| b.1.error().total_cmp(&a.1.error()));
        seen.truncate(REFINED);
        let climbed = |asking: &mut Asking, start| self.climb(held, start, asking);
        let refined: Vec<Found> = seen.into_par_iter().map_init(|| self.exact.asking(), climbed).collect();
        for found in &refined {
            largest = largest.with(found);
        }
        largest
    }

    /// The largest errors on the way up from a place.
    fn climb(&self, held: Functions<'_>, (mut place, mut best): (Place, Found), asking: &mut Asking) -> Found {
        let mut largest = best.clone();
        let mut step = FIRST_STEP;
        for _ in 0..HALVINGS {
            for coordinate in 0..place.len() {
                for sign in [1.0, -1.0] {
                    let mut beside = place;
                    beside[coordinate] = (place[coordinate] + sign * step).clamp(-1.0, 1.0);
                    let found = self.at(held, &beside, asking);
                    largest = largest.with(&found);
                    if found.error() > best.error() {
                        (place, best) = (beside, found);
                    }
                }
            }
            step *= 0.5;
        }
        largest
    }
}

fn last_step(function: &Function, states: &[Vec<f64>]) -> [f64; 3] {
    let Some([before, after]) = states.last_chunk::<2>() else { return [0.0; 3] };
    let (before, after) = (function.judged(before), function.judged(after));
    std::array::from_fn(|i| (after[i] - before[i]).abs())
}
