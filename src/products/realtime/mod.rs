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
pub use function::{Degrees, Start};

use crate::{
    input::error::{Error, Result},
    machine::{ChainError, Machine},
    simulation::Machines,
    statics::one_step::Given,
};
use domain::{Place, corners, spread, towards_faces};
use exact::{Exact, Solved};
use function::{Function, range};
use search::Search;

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
    /// Drives for a position of the tool tip.
    pub correct: Made,
    /// The position for drives.
    pub whereabouts: Made,
    /// Drives of the rigid machine without errors: what a controller without correction commands.
    pub nominal: Made,
    /// Places with what the program answers there.
    examples: Vec<Solved>,
    /// The drives of the rigid machine there.
    nominal_examples: Vec<Vec<f64>>,
    /// Between what drives may be, mm or rad.
    drives: [[f64; 3]; 2],
}

/// A generated function and what is known of it.
#[derive(Debug, Clone)]
pub struct Made {
    /// Errors of the tool tip with the drives that are found, or of the position.
    pub errors: Errors,
    /// What the last step may be: of each drive (mm, rad), or of each coordinate of the platform, mm.
    pub largest_last_step: [f64; 3],
    function: Function,
}

impl Made {
    fn new(function: Function, found_mm: Vec<f64>, last_step: [f64; 3], machine: &Machine) -> Self {
        let allowed = |step: f64| STEP_MARGIN * step + ROUNDING * machine.characteristic_length;
        Self { errors: Errors { found_mm }, largest_last_step: last_step.map(allowed), function }
    }

    /// Operations of one call: of the start, and of each step.
    pub fn operations(&self) -> (usize, usize) {
        (self.function.start.operation_count(), self.function.step.operation_count())
    }
}

/// Less than this is not stated, mm: rounding.
const LEAST_MM: f64 = 1e-12;
/// Error that the polynomials are chosen to leave after the last step, mm.
pub const AIM_MM: f64 = 1e-6;
/// What is seen at few places is at most this share of it.
const MARGIN: f64 = 0.25;
/// The last step may be so many times the largest that was found.
const STEP_MARGIN: f64 = 4.0;
/// A last step of this share of the machine's characteristic length is rounding, mm; of a hinge, rad.
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
        return Err(Error::argument("--steps", problem));
    }
    let exact = Exact { machines: question.machines.clone() };
    let search = Search { exact: &exact, domain: &domain, steps };
    let known = known(&search)?;
    let correct = shortest(&search, Given::Tip, &DEGREES, &known, &|own| search.briefly((own, None), TRIED).correct)?;
    let tried = |own: &Function| search.briefly((&correct, Some(own)), TRIED).whereabouts;
    let whereabouts = shortest(&search, Given::Drives, &DEGREES, &known, &tried)?;
    let found = search.thoroughly((&correct, Some(&whereabouts)), question.places);
    let drives = range(Given::Drives, &domain, &known.solved);
    let (nominal, rigid) = generate_nominal(&question)?;
    let examples = exact.solved(&domain, (0..EXAMPLES).map(|index| spread(1000 + index)))?;
    let rigid_at = |own: &Solved| Ok(rigid.unloaded(&own.asked.0)?.drives);
    let ([of_drives, of_platform], machine) = (found.last_step, &question.machines.nominal);
    Ok(Realtime {
        correct: Made::new(correct, found.correct, of_drives, machine),
        whereabouts: Made::new(whereabouts, found.whereabouts, of_platform, machine),
        nominal,
        nominal_examples: examples.iter().map(rigid_at).collect::<Result<_>>()?,
        examples,
        drives: [drives.low, drives.high],
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

/// Places whose equilibria polynomials are fitted to.
fn fitted() -> impl Iterator<Item = Place> {
    corners().step_by(3).chain((0..FITTED).map(towards_faces))
}

/// Equilibria of a machine: where steps are recorded, and those that polynomials are fitted to.
struct Known {
    postures: Vec<Solved>,
    solved: Vec<Solved>,
}

fn known(search: &Search<'_>) -> Result<Known> {
    let solved = |places: &mut dyn Iterator<Item = Place>| search.exact.solved(search.domain, places);
    Ok(Known { postures: solved(&mut postures())?, solved: solved(&mut fitted())? })
}

/// The function with polynomials of the first of `degrees` that leave little, by the errors after each step that are `tried`, else of those
/// that leave least.
fn shortest(
    search: &Search<'_>,
    given: Given,
    degrees: &[Degrees],
    known: &Known,
    tried: &dyn Fn(&Function) -> Vec<f64>,
) -> Result<Function> {
    let (exact, steps) = (search.exact, search.steps);
    let step = Function::step(exact, given, &known.postures)?;
    let range = range(given, search.domain, &known.solved);
    let of = |degrees: &Degrees| Function::new(given, &range, *degrees, &known.solved, step.clone());
    let mut best: Option<(f64, Function)> = None;
    for function in degrees.iter().filter_map(of) {
        let error = tried(&function).last().copied().unwrap_or(f64::INFINITY);
        if best.as_ref().is_none_or(|(least, _)| error < *least) {
            best = Some((error, function));
        }
        if error <= MARGIN * AIM_MM {
            break;
        }
    }
    best.filter(|(error, _)| error.is_finite()).map(|(_, function)| function).ok_or_else(|| {
        let name = &exact.machines.nominal.name;
        let problem = format!(
            "{steps} steps from none of the starts lead to equilibria of {name} all over the box; expected more steps, a smaller box or smaller forces"
        );
        Error::argument("--steps", problem)
    })
}

impl Realtime {
    /// Drives (mm, rad) that the generated code gives for a position of the tool tip, mm, under a wrench about it (N, N·mm), both in the domain.
    pub fn correct(&self, position: &[f64; 3], wrench: &[f64; 6]) -> [f64; 3] {
        let own = &self.correct.function;
        own.judged(&own.last(position, wrench, self.question.steps))
    }

    /// Position of the tool tip, mm, that it gives for drives under a wrench.
    pub fn whereabouts(&self, drives: &[f64; 3], wrench: &[f64; 6]) -> [f64; 3] {
        let exact = Exact { machines: self.question.machines.clone() };
        exact.tip_of(&self.whereabouts.function.last(drives, wrench, self.question.steps)).into()
    }

    /// Drives (mm, rad) that it gives for a position of the rigid machine without errors.
    pub fn nominal(&self, position: &[f64; 3]) -> [f64; 3] {
        let own = &self.nominal.function;
        own.judged(&own.last(position, &[0.0; 6], self.question.steps))
    }

    /// The functions, each by the name that it has in C.
    pub fn functions(&self) -> [(&'static str, &Made); 3] {
        [
            ("kinetostat_correct", &self.correct),
            ("kinetostat_where", &self.whereabouts),
            ("kinetostat_nominal", &self.nominal),
        ]
    }
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

/// Generates the function where `question` asks for the others; and what answers for it.
///
/// # Errors
/// As of these.
fn generate_nominal(question: &Question) -> Result<(Made, Exact)> {
    let machine = unmoved(&question.machines.nominal);
    let exact = Exact { machines: Machines::new(&machine, &[])? };
    let domain = Domain { wrench: [0.0; 6], ..question.domain };
    let search = Search { exact: &exact, domain: &domain, steps: question.steps };
    let tried = |own: &Function| search.briefly((own, None), TRIED).correct;
    let function = shortest(&search, Given::Tip, &NOMINAL_DEGREES, &known(&search)?, &tried)?;
    let found = search.thoroughly((&function, None), question.places);
    Ok((Made::new(function, found.correct, found.last_step[0], &machine), exact))
}
