//! The loaded kinematics of one machine as generated straight-line code for a controller: a fixed number of Newton steps of the
//! engine itself, written down as it makes them, from a start by polynomials; and how far that is from what the engine answers.

mod domain;
mod emit;
mod exact;
mod folder;
mod function;
mod search;

pub use domain::Domain;
pub use folder::{MANIFEST, files, write};

use crate::{
    input::error::{Error, Result},
    machine::{ChainError, Machine},
    simulation::Machines,
    statics::one_step::Given,
};
use domain::{Place, corners, spread, towards_faces};
use exact::{Exact, Solved};
use function::{Degrees, Function, range};
use search::{Found, Search};

/// What is to be generated.
#[derive(Debug, Clone)]
pub struct Question {
    /// The nominal machine and the one that answers.
    pub machines: Machines,
    /// The errors of its chains.
    pub errors: Vec<ChainError>,
    /// Where the functions answer.
    pub domain: Domain,
    /// Newton steps of each call.
    pub steps: usize,
    /// Places at which errors are looked for besides the corners of the domain; [`PLACES`] for what is stated.
    pub places: usize,
}

/// Places at which errors are looked for, as a rule.
pub const PLACES: usize = 3584;

/// Largest distances found, and what is stated for them, mm.
#[derive(Debug, Clone, PartialEq)]
pub struct Errors {
    /// The largest found at the start and after each step.
    pub found_mm: Vec<f64>,
}

impl Errors {
    /// What is stated of the function, mm: twice what was found, as a search is no proof, in two digits.
    pub fn stated_mm(&self) -> f64 {
        let twice = (2.0 * self.found_mm.last().copied().unwrap_or(f64::INFINITY)).max(LEAST_MM);
        let unit = 10f64.powf(twice.log10().floor() - 1.0);
        (twice / unit).ceil() * unit
    }
}

/// The generated functions and what is known of them.
#[derive(Debug, Clone)]
pub struct Realtime {
    /// What was asked.
    pub question: Question,
    /// Errors of the tool tip with the drives that are found.
    pub correct_errors: Errors,
    /// Errors of the position that is found.
    pub where_errors: Errors,
    /// What the last step may be: of each drive (mm, rad), and of each coordinate of the platform, mm.
    pub largest_last_step: [[f64; 3]; 2],
    /// Places with what the program answers there.
    examples: Vec<Solved>,
    /// The drives of the rigid machine there.
    nominal_examples: Vec<Vec<f64>>,
    /// Between what drives may be, mm or rad.
    drives: [[f64; 3]; 2],
    correct: Function,
    whereabouts: Function,
    nominal: Nominal,
}

/// Less than this is not stated, mm: rounding.
const LEAST_MM: f64 = 1e-12;
/// Error that the polynomials are chosen to leave after the last step, mm.
pub const AIM_MM: f64 = 1e-6;
/// What is seen at few places is at most this share of it.
const MARGIN: f64 = 0.25;
/// The last step may be so many times the largest that was found.
const STEP_MARGIN: f64 = 4.0;
/// A last step of this share of the machine's reach is rounding, mm; of a hinge, rad.
const ROUNDING: f64 = 1e-12;
/// Polynomials that are tried, the shortest first.
const DEGREES: [Degrees; 13] = [
    (1, None),
    (2, None),
    (2, Some(0)),
    (3, Some(0)),
    (3, Some(1)),
    (4, Some(1)),
    (4, Some(2)),
    (5, Some(2)),
    (6, Some(2)),
    (5, Some(3)),
    (6, Some(3)),
    (7, Some(3)),
    (7, Some(4)),
];
/// Equilibria that polynomials are fitted to, besides the corners of the domain, and places at which they are tried.
const FITTED: usize = 640;
const TRIED: usize = 96;
/// Places of which answers are left with the code.
const EXAMPLES: usize = 24;
/// Most Newton steps.
pub const MOST_STEPS: usize = 8;

/// Generates the functions, and finds their errors.
///
/// # Errors
/// A machine for which there is no such code, by what is missing; a place of the box where it does not stand; too many steps.
pub fn generate(question: Question) -> Result<Realtime> {
    domain::check(&question.machines.nominal)?;
    let Question { domain, steps, .. } = question;
    if !(1..=MOST_STEPS).contains(&steps) {
        let problem = format!("must be from 1 to {MOST_STEPS}, got {steps}");
        return Err(Error::Argument { argument: "--steps".into(), problem });
    }
    let exact = Exact { machines: question.machines.clone() };
    let (postures, solved) = (exact.solved(&domain, postures())?, exact.solved(&domain, fitted())?);
    let made = |given: Given, tried: &dyn Fn(&Function) -> f64| {
        shortest(&question, &exact, (given, &domain, &DEGREES), (&postures, &solved), tried)
    };
    let correct = made(Given::Tip, &|own| {
        let search = Search { exact: &exact, domain: &domain, correct: own, whereabouts: None, steps };
        after_the_last(&search.briefly(TRIED).correct)
    })?;
    let whereabouts = made(Given::Drives, &|own| {
        let search = Search { exact: &exact, domain: &domain, correct: &correct, whereabouts: Some(own), steps };
        after_the_last(&search.briefly(TRIED).whereabouts)
    })?;
    let Found { correct: correct_mm, whereabouts: where_mm, last_step } =
        Search { exact: &exact, domain: &domain, correct: &correct, whereabouts: Some(&whereabouts), steps }
            .thoroughly(question.places);
    let drives = range(Given::Drives, &domain, &solved);
    let nominal = generate_nominal(&question)?;
    let examples = exact.solved(&domain, (0..EXAMPLES).map(|index| spread(1000 + index)))?;
    Ok(Realtime {
        correct_errors: Errors { found_mm: correct_mm },
        where_errors: Errors { found_mm: where_mm },
        largest_last_step: last_step.map(|each| each.map(|step| allowed(step, &question.machines.nominal))),
        nominal_examples: nominal.solved(&examples)?,
        examples,
        drives: [drives.low, drives.high],
        correct,
        whereabouts,
        nominal,
        question,
    })
}

/// Where steps are recorded: near the corners of the box, far from the symmetry of most machines.
fn postures() -> impl Iterator<Item = Place> {
    (0..8_usize).map(|corner| {
        let mut place = spread(corner);
        for (i, coordinate) in place[..3].iter_mut().enumerate() {
            *coordinate = if corner >> i & 1 == 1 { 1.0 } else { -1.0 } * (0.93 + 0.01 * (2 * corner + i) as f64 / 4.0);
        }
        place
    })
}

/// What a last step may be where the largest that was found is `step`.
fn allowed(step: f64, machine: &Machine) -> f64 {
    STEP_MARGIN * step + ROUNDING * machine.reach
}

/// Places whose equilibria polynomials are fitted to.
fn fitted() -> impl Iterator<Item = Place> {
    corners().step_by(3).chain((0..FITTED).map(towards_faces))
}

fn after_the_last(errors_mm: &[f64]) -> f64 {
    errors_mm.last().copied().unwrap_or(f64::INFINITY)
}

/// The function with polynomials of the first of `degrees` that leave little, as `tried` finds, else of those that leave least.
fn shortest(
    question: &Question,
    exact: &Exact,
    (given, domain, degrees): (Given, &Domain, &[Degrees]),
    (postures, solved): (&[Solved], &[Solved]),
    tried: &dyn Fn(&Function) -> f64,
) -> Result<Function> {
    let step = Function::step(exact, given, postures)?;
    let range = range(given, domain, solved);
    let of = |degrees: &Degrees| Function::new(exact, given, &range, *degrees, solved, step.clone());
    let mut best: Option<(f64, Function)> = None;
    for function in degrees.iter().filter_map(of) {
        let error = tried(&function);
        if best.as_ref().is_none_or(|(least, _)| error < *least) {
            best = Some((error, function));
        }
        if error <= MARGIN * AIM_MM {
            break;
        }
    }
    best.filter(|(error, _)| error.is_finite()).map(|(_, function)| function).ok_or_else(|| Error::Argument {
        argument: "--steps".into(),
        problem: format!(
            "{} steps from none of the starts lead to equilibria of {} all over the box; expected more steps, a smaller box or smaller forces",
            question.steps, question.machines.nominal.name
        ),
    })
}

impl Realtime {
    /// Drives (mm, rad) that the generated code gives for a position of the tool tip, mm, under a wrench about it (N, N·mm), both in the domain.
    pub fn correct(&self, position: &[f64; 3], wrench: &[f64; 6]) -> [f64; 3] {
        let path = self.correct.path(position, wrench, self.question.steps, &mut Vec::new());
        self.correct.judged(path.last())
    }

    /// Position of the tool tip, mm, that it gives for drives under a wrench.
    pub fn whereabouts(&self, drives: &[f64; 3], wrench: &[f64; 6]) -> [f64; 3] {
        let path = self.whereabouts.path(drives, wrench, self.question.steps, &mut Vec::new());
        let exact = Exact { machines: self.question.machines.clone() };
        exact.tip_of(path.last()).into()
    }

    /// Drives (mm, rad) that it gives for a position of the rigid machine without errors.
    pub fn nominal(&self, position: &[f64; 3]) -> [f64; 3] {
        let path = self.nominal.function.path(position, &[0.0; 6], self.question.steps, &mut Vec::new());
        self.nominal.function.judged(path.last())
    }

    /// Errors of the tool tip of the rigid machine with these.
    pub fn nominal_errors(&self) -> &Errors {
        &self.nominal.errors
    }

    /// Operations of one call: of the start, and of each step, for the three functions.
    pub fn operations(&self) -> [(usize, usize); 3] {
        [&self.correct, &self.whereabouts, &self.nominal.function]
            .map(|own| (own.start.operation_count(), own.step.operation_count()))
    }
}

/// What a controller without correction commands: drives of the rigid machine without errors, as a generated function like the others.
#[derive(Debug, Clone)]
struct Nominal {
    function: Function,
    errors: Errors,
    /// What the last step of each drive may be, mm or rad.
    largest_last_step: [f64; 3],
    exact: Exact,
}

/// The same of the rigid machine: there is no wrench.
const NOMINAL_DEGREES: [Degrees; 8] =
    [(1, None), (2, None), (3, None), (4, None), (5, None), (6, None), (7, None), (8, None)];

/// The machine without what moves it: unloaded, it stands where the rigid one does.
fn unmoved(nominal: &Machine) -> Machine {
    let mut machine = nominal.weightless();
    for chain in &mut machine.chains {
        chain.passive.iter_mut().for_each(|joint| joint.stiffness = 0.0);
        chain.route.for_each(&mut |route| route.point_springs.clear());
    }
    machine
}

/// Generates the function where `question` asks for the others.
///
/// # Errors
/// As of these.
fn generate_nominal(question: &Question) -> Result<Nominal> {
    let machine = unmoved(&question.machines.nominal);
    let exact = Exact { machines: Machines::new(&machine, &[])? };
    let domain = Domain { wrench: [0.0; 6], ..question.domain };
    let (solved, postures) = (exact.solved(&domain, fitted())?, exact.solved(&domain, postures())?);
    let steps = question.steps;
    let tried = |correct: &Function| {
        let search = Search { exact: &exact, domain: &domain, correct, whereabouts: None, steps };
        after_the_last(&search.briefly(TRIED).correct)
    };
    let function = shortest(question, &exact, (Given::Tip, &domain, &NOMINAL_DEGREES), (&postures, &solved), &tried)?;
    let found = Search { exact: &exact, domain: &domain, correct: &function, whereabouts: None, steps }
        .thoroughly(question.places);
    Ok(Nominal {
        errors: Errors { found_mm: found.correct },
        largest_last_step: found.last_step[0].map(|step| allowed(step, &machine)),
        function,
        exact,
    })
}

impl Nominal {
    /// Drives that the program answers at positions of the tool tip.
    ///
    /// # Errors
    /// The machine does not stand at one of them.
    fn solved(&self, at: &[Solved]) -> Result<Vec<Vec<f64>>> {
        at.iter().map(|solved| Ok(self.exact.unloaded(&solved.asked.0)?.drives)).collect()
    }
}
