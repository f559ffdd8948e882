//! A function as it is generated: a start and a fixed number of Newton steps.

use super::{
    domain::Domain,
    exact::{Exact, Solved},
    start::{Degrees, Range, Start},
};
use crate::{
    input::error::{Error, Result},
    lanes::{MAX_LANES, Program},
    statics::one_step::{self, Given},
};

/// Drives for a position of the tool tip, or the position for drives.
#[derive(Debug, Clone)]
pub(crate) struct Function {
    /// What is given: the position, or the drives.
    pub given: Given,
    /// Where the steps start. Of a function of the drives, without these.
    pub start: Start,
    /// One step, of the numbers of a state and what is given.
    pub step: Program,
    /// Number of drives.
    pub drives: usize,
}

/// States after a number of steps.
pub(crate) struct Path {
    /// At the start, and after each step.
    pub states: Vec<Vec<f64>>,
}

impl Path {
    /// After the last step.
    pub fn last(&self) -> &[f64] {
        self.states.last().map_or(&[], Vec::as_slice)
    }
}

impl Function {
    /// One that starts with polynomials of these degrees, fitted to `solved`; `postures` show the ways that a step takes.
    pub fn new(
        exact: &Exact,
        given: Given,
        range: &Range,
        degrees: Degrees,
        solved: &[Solved],
        step: Program,
    ) -> Option<Self> {
        let drives = exact.real().drive_count();
        let inputs: Vec<Vec<f64>> = solved.iter().map(|solved| inputs(given, solved)).collect();
        let known = if given == Given::Drives { drives } else { 0 };
        let states: Vec<Vec<f64>> = solved.iter().map(|solved| solved.numbers[known..].to_vec()).collect();
        let start = Start::fitted(range, degrees, &inputs, &states)?;
        Some(Self { given, start, step, drives })
    }

    /// A step of the machine, whose ways `solved` show.
    ///
    /// # Errors
    /// It cannot be written down.
    pub fn step(exact: &Exact, given: Given, solved: &[Solved]) -> Result<Program> {
        let postures: Vec<Vec<f64>> = solved
            .iter()
            .take(MAX_LANES)
            .map(|solved| step_inputs(given, &solved.numbers, &solved.asked.0, &solved.asked.1))
            .collect();
        one_step::step_program(exact.real(), given, &postures).ok_or_else(|| Error::Argument {
            argument: "--machine".into(),
            problem: format!(
                "{}: a Newton step cannot be written without branches, as a chain cannot be condensed where the machine stands: \
                 expected chains without idle joints",
                exact.real().name
            ),
        })
    }

    /// Where `steps` steps lead from the start at three coordinates (a position or the drives) under a wrench.
    pub fn path(&self, at: &[f64; 3], wrench: &[f64; 6], steps: usize, values: &mut Vec<f64>) -> Path {
        let inputs: Vec<f64> = at.iter().chain(wrench).copied().collect();
        let mut state = match self.given {
            Given::Tip => Vec::new(),
            Given::Drives => at.to_vec(),
        };
        state.extend(self.start.at(&inputs));
        let mut states = vec![state];
        for step in 0..steps {
            let inputs = step_inputs(self.given, &states[step], at, wrench);
            states.push(self.step.evaluate(&inputs, values));
        }
        Path { states }
    }

    /// The numbers of a state by which its last step is judged: the drives or the place of the platform, whichever is sought.
    pub fn judged(&self, state: &[f64]) -> [f64; 3] {
        let first = match self.given {
            Given::Tip => 0,
            Given::Drives => one_step::origin(self.drives),
        };
        std::array::from_fn(|i| state[first + i])
    }
}

/// What the start is given: three coordinates and the wrench.
fn inputs(given: Given, solved: &Solved) -> Vec<f64> {
    let at = match given {
        Given::Tip => solved.asked.0.to_vec(),
        Given::Drives => solved.drives.clone(),
    };
    at.into_iter().chain(solved.asked.1).collect()
}

/// What a step is given: a state, and what is asked.
fn step_inputs(given: Given, state: &[f64], at: &[f64; 3], wrench: &[f64; 6]) -> Vec<f64> {
    let position: &[f64] = if given == Given::Tip { at } else { &[] };
    state.iter().chain(position).chain(wrench).copied().collect()
}

/// Between what the coordinates of a function of `given` are, with room for rounding of the drives.
pub(super) fn range(given: Given, domain: &Domain, solved: &[Solved]) -> Range {
    let (mut low, mut high) = (domain.low, domain.high);
    if given == Given::Drives {
        for i in 0..3 {
            let all = || solved.iter().map(|solved| solved.drives[i]);
            let (least, most) = (all().fold(f64::INFINITY, f64::min), all().fold(f64::NEG_INFINITY, f64::max));
            let room = ROOM * (most - least);
            (low[i], high[i]) = (least - room, most + room);
        }
    }
    Range { low, high, wrench: domain.wrench }
}

/// How far drives may be outside of those that were sampled, as a share of their range.
const ROOM: f64 = 0.01;
