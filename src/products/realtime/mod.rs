//! Generates controller code of the loaded kinematics of one machine, without loops of unknown length, and finds how far the code is from the
//! engine. The code is a polynomial start and a fixed number of the engine's Newton steps, recorded operation by operation.

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
    process::uncertainty::Uncertainty,
    products::{
        field::{self, FieldCase, FieldSpread},
        field_report::Field,
    },
    simulation::Machines,
    spatial::Grid,
    statics::one_step::StepInput,
    work::Work,
};
use domain::{Sample, corners, point_near_faces, sequence_point};
use exact::{ReferenceSolver, TipState};
use function::{Function, input_range};
use search::Search;

/// Input of the code generation.
#[derive(Debug, Clone)]
pub struct Question {
    /// The nominal machine and the actual one.
    pub machines: Machines,
    /// Chain errors of the actual machine.
    pub errors: Vec<ChainError>,
    /// Positions and wrenches for which the functions are valid.
    pub domain: Domain,
    /// Newton steps of each call.
    pub steps: usize,
    /// Number of places at which errors are searched besides the corners of the domain; [`PLACES`] for errors that are stated.
    pub places: usize,
    /// What is not known exactly; `None` where all inputs are taken as exact.
    pub uncertainty: Option<Uncertainty>,
    /// Largest distance of the tool from where it is wanted that is within tolerance, mm.
    pub tolerance_mm: Option<f64>,
}

/// Default number of places at which errors are searched.
pub const PLACES: usize = 3584;

/// Largest errors found of a function, mm.
#[derive(Debug, Clone, PartialEq)]
pub struct Errors {
    /// Largest error at the start and after each step, mm.
    pub found_mm: Vec<f64>,
}

impl Errors {
    /// Returns the error to state, mm: twice the one found, since a search is no proof, rounded up to two digits.
    pub fn stated_mm(&self) -> f64 {
        let twice = (2.0 * self.found_mm.last().copied().unwrap_or(f64::INFINITY)).max(LEAST_MM);
        let unit = libm::pow(10.0, libm::log10(twice).floor() - 1.0);
        (twice / unit).ceil() * unit
    }
}

/// The generated functions with their errors and examples.
#[derive(Debug, Clone)]
pub struct Realtime {
    /// The input.
    pub question: Question,
    /// Function from a position of the tool tip to the drives of the loaded machine.
    pub correct: FunctionCode,
    /// Function from the drives to the position of the tool tip under load.
    pub whereabouts: FunctionCode,
    /// Function from a position to the drives of the rigid machine without errors, as a controller without correction commands them.
    pub nominal: FunctionCode,
    /// Distances on machines and under forces as they may be without correction and with it; `None` where inputs are taken as exact.
    pub spread: Option<FieldSpread>,
    /// Equilibria of the engine for the examples in C.
    examples: Vec<TipState>,
    /// Drives of the rigid machine at the examples.
    nominal_examples: Vec<Vec<f64>>,
    /// Smallest and largest drive positions in the domain, mm or rad.
    drives: [[f64; 3]; 2],
}

/// A generated function with its errors.
#[derive(Debug, Clone)]
pub struct FunctionCode {
    /// Errors of the tool tip with the drives found, or of the position found.
    pub errors: Errors,
    /// Largest last step that is accepted: of each drive (mm, rad), or of each coordinate of the platform, mm.
    pub largest_last_step: [f64; 3],
    function: Function,
}

impl FunctionCode {
    /// Stores a function with its errors, and accepts last steps up to the largest one found, `last_step`, times [`STEP_MARGIN`].
    fn new(function: Function, found_mm: Vec<f64>, last_step: [f64; 3], machine: &Machine) -> Self {
        let allowed = |step: f64| STEP_MARGIN * step + ROUNDING * machine.characteristic_length;
        Self { errors: Errors { found_mm }, largest_last_step: last_step.map(allowed), function }
    }

    /// Returns the number of operations of the start and of one step.
    pub fn operations(&self) -> (usize, usize) {
        (self.function.start.operation_count(), self.function.step.operation_count())
    }
}

/// Smallest error that is stated, mm: rounding.
const LEAST_MM: f64 = 1e-12;
/// Largest error after the last step that the choice of polynomials aims at, mm.
pub const AIM_MM: f64 = 1e-6;
/// Share of that aim that a quick search may find.
const MARGIN: f64 = 0.25;
/// How many times the largest last step found is accepted.
const STEP_MARGIN: f64 = 4.0;
/// Last step that is rounding, as a share of the machine's characteristic length, mm; of a revolute joint, rad.
const ROUNDING: f64 = 1e-12;
/// Polynomial degrees to try, the shortest first.
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
const FIT_POINTS: usize = 640;
const TRIALS: usize = 96;
/// Number of examples written with the code.
const EXAMPLES: usize = 24;
/// Most Newton steps.
pub const MAX_STEPS: usize = 8;

/// Generates the functions and finds their errors.
///
/// # Errors
/// A machine for which such code cannot be generated, with what is missing; a place of the box without equilibrium; too many steps.
pub fn generate(question: Question) -> Result<Realtime> {
    domain::check_machine(&question.machines.nominal)?;
    let (domain, steps) = (question.domain, question.steps);
    if !(1..=MAX_STEPS).contains(&steps) {
        let problem = format!("must be from 1 to {MAX_STEPS}, got {steps}");
        return Err(Error::argument("--steps", problem));
    }
    let exact = ReferenceSolver { machines: question.machines.clone() };
    let search = Search { exact: &exact, domain: &domain, steps };
    let fit = equilibria(&search)?;
    let correct = shortest_function(&search, StepInput::Tip, &DEGREES, &fit, &|function| {
        search.quick_search((function, None), TRIALS).correct
    })?;
    let trial_errors = |function: &Function| search.quick_search((&correct, Some(function)), TRIALS).whereabouts;
    let whereabouts = shortest_function(&search, StepInput::Drives, &DEGREES, &fit, &trial_errors)?;
    let found = search.full_search((&correct, Some(&whereabouts)), question.places);
    let drives = input_range(StepInput::Drives, &domain, &fit.solved);
    let (nominal, rigid) = generate_nominal(&question)?;
    let examples = exact.solve_all(&domain, (0..EXAMPLES).map(|index| sequence_point(1000 + index)))?;
    let rigid_at = |function: &TipState| Ok(rigid.unloaded(&function.asked.0)?.drives);
    let ([of_drives, of_platform], machine) = (found.last_step, &question.machines.nominal);
    let mut realtime = Realtime {
        correct: FunctionCode::new(correct, found.correct, of_drives, machine),
        whereabouts: FunctionCode::new(whereabouts, found.whereabouts, of_platform, machine),
        nominal,
        nominal_examples: examples.iter().map(rigid_at).collect::<Result<_>>()?,
        examples,
        drives: [drives.low, drives.high],
        spread: None,
        question,
    };
    let Question { machines, errors, uncertainty, tolerance_mm, .. } = &realtime.question;
    let (uncertainty, cases) = (uncertainty.as_ref(), || realtime.field_cases());
    realtime.spread = FieldSpread::solve(uncertainty, machines, errors, cases, *tolerance_mm, &Work::default())?;
    Ok(realtime)
}

/// Returns the points at which steps are recorded: near the corners of the box, away from the symmetry of most machines.
fn recording_points() -> impl Iterator<Item = Sample> {
    (0..8_usize).map(|corner| {
        let mut sample = sequence_point(corner);
        for (i, coordinate) in sample[..3].iter_mut().enumerate() {
            *coordinate = if corner >> i & 1 == 1 { 1.0 } else { -1.0 } * (0.93 + 0.01 * (2 * corner + i) as f64 / 4.0);
        }
        sample
    })
}

/// Equilibria of a machine: `postures`, at which steps are recorded, and `solved`, which polynomials are fitted to.
struct Equilibria {
    postures: Vec<TipState>,
    solved: Vec<TipState>,
}

/// Solves the equilibria for recording and fitting.
fn equilibria(search: &Search<'_>) -> Result<Equilibria> {
    let solved = |places: &mut dyn Iterator<Item = Sample>| search.exact.solve_all(search.domain, places);
    let mut fitted = corners().step_by(3).chain((0..FIT_POINTS).map(point_near_faces));
    Ok(Equilibria { postures: solved(&mut recording_points())?, solved: solved(&mut fitted)? })
}

/// Returns the function with the first of `degrees` whose last error, by `trial_errors`, is small enough; else the one with the smallest error.
fn shortest_function(
    search: &Search<'_>,
    given: StepInput,
    degrees: &[Degrees],
    equilibria: &Equilibria,
    trial_errors: &dyn Fn(&Function) -> Vec<f64>,
) -> Result<Function> {
    let (exact, steps) = (search.exact, search.steps);
    let step = Function::step(exact, given, &equilibria.postures)?;
    let range = input_range(given, search.domain, &equilibria.solved);
    let fitted = |degrees: &Degrees| Function::new(given, &range, *degrees, &equilibria.solved, step.clone());
    let mut best: Option<(f64, Function)> = None;
    for function in degrees.iter().filter_map(fitted) {
        let error = trial_errors(&function).last().copied().unwrap_or(f64::INFINITY);
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
            "with {steps} Newton steps the generated code does not reach the equilibria of {name} everywhere in the box; allow more steps, or ask for a smaller box or smaller forces"
        );
        Error::argument("--steps", problem)
    })
}

impl Realtime {
    /// Returns the drives (mm, rad) that the generated code gives for a tool tip position (O, mm) under a wrench about the tip (N, N·mm).
    pub fn correct(&self, position: &[f64; 3], wrench: &[f64; 6]) -> [f64; 3] {
        let function = &self.correct.function;
        function.unknowns(&function.last_state(position, wrench, self.question.steps))
    }

    /// Returns the tool tip position (O, mm) that the generated code gives for drives (mm, rad) under a wrench about the tip (N, N·mm).
    pub fn whereabouts(&self, drives: &[f64; 3], wrench: &[f64; 6]) -> [f64; 3] {
        let exact = ReferenceSolver { machines: self.question.machines.clone() };
        exact.tip_of(&self.whereabouts.function.last_state(drives, wrench, self.question.steps)).into()
    }

    /// Returns the drives (mm, rad) that the generated code gives for a tool tip position (O, mm) of the rigid machine without errors.
    pub fn nominal(&self, position: &[f64; 3]) -> [f64; 3] {
        let function = &self.nominal.function;
        function.unknowns(&function.last_state(position, &[0.0; 6], self.question.steps))
    }

    /// Returns what the correction leaves on machines as they may be; `None` where inputs are taken as exact.
    pub(crate) fn field(&self) -> Option<Field<'_>> {
        let (spread, uncertainty) = self.spread.as_ref().zip(self.question.uncertainty.as_ref())?;
        let (machine, corrector) = (&self.question.machines.nominal.name, "kinetostat_correct".into());
        let nominal_mm = self.correct.errors.found_mm.last().copied().unwrap_or(f64::INFINITY);
        Some(Field { spread, uncertainty, machine, corrector, nominal_mm, tolerance_mm: self.question.tolerance_mm })
    }

    /// Returns what the correction leaves on machines as they may be, in sentences: the verdict, what it rests on, and how it was found; `None` where inputs are taken as exact.
    pub fn field_text(&self) -> Option<[String; 3]> {
        let field = self.field()?;
        Some([field.verdict(), field.cautions(), field.details(&["without correction", "with kinetostat_correct"])])
    }

    /// Returns the cases by which the correction is checked where inputs are uncertain: at corners, middles of edges and faces and the middle of the box, each
    /// without force, under the largest one along each axis, and under the largest forces and moments that bend most there.
    fn field_cases(&self) -> Result<Vec<FieldCase>> {
        let Question { machines, domain, .. } = &self.question;
        let exact = ReferenceSolver { machines: machines.clone() };
        let grid = Grid::new(domain.low.into(), domain.high.into(), [3; 3]);
        let places: Vec<[f64; 3]> = (0..grid.len()).map(|index| grid.position(index).into()).collect();
        let corner = |corner: usize| {
            std::array::from_fn(|i| if corner >> i & 1 == 1 { domain.wrench[i] } else { -domain.wrench[i] })
        };
        let tried: Vec<[f64; 6]> = (0..64).map(corner).collect();
        let along =
            |index: usize| std::array::from_fn(|i| if i == index % 3 { tried[63 * (index / 3)][i] } else { 0.0 });
        let loads: Vec<[f64; 6]> = std::iter::once([0.0; 6]).chain((0..6).map(along)).collect();
        field::cases(machines, &places, [&loads, &tried], |place, load| {
            let task = exact.task(&(*place, *load));
            let at = machines.nominal.inverse_kinematics(&task.pose);
            let at = at.map_err(|unreachable| Error::argument("--box", unreachable.to_string()))?;
            let drives = [self.nominal(place), self.correct(place, load)].map(Vec::from).into();
            Ok(FieldCase { task, at, position: (*place).into(), drives })
        })
    }

    /// Returns the three functions, each with its name in C.
    pub fn functions(&self) -> [(&'static str, &FunctionCode); 3] {
        [
            ("kinetostat_correct", &self.correct),
            ("kinetostat_where", &self.whereabouts),
            ("kinetostat_nominal", &self.nominal),
        ]
    }
}

/// Polynomial degrees to try for the rigid machine, which has no wrench.
const NOMINAL_DEGREES: [Degrees; 8] =
    [(1, None), (2, None), (3, None), (4, None), (5, None), (6, None), (7, None), (8, None)];

/// Returns the machine without weight and springs: unloaded, it stands where the rigid machine does.
fn without_own_forces(nominal: &Machine) -> Machine {
    let mut machine = nominal.weightless();
    for chain in &mut machine.chains {
        chain.passive.iter_mut().for_each(|joint| joint.stiffness = 0.0);
        chain.route.for_each(&mut |route| route.point_springs.clear());
    }
    machine
}

/// Generates the function of the rigid machine; returns it with its reference solver. Errors as for [`generate`].
fn generate_nominal(question: &Question) -> Result<(FunctionCode, ReferenceSolver)> {
    let machine = without_own_forces(&question.machines.nominal);
    let exact = ReferenceSolver { machines: Machines::new(&machine, &[])? };
    let domain = Domain { wrench: [0.0; 6], ..question.domain };
    let search = Search { exact: &exact, domain: &domain, steps: question.steps };
    let trial_errors = |own: &Function| search.quick_search((own, None), TRIALS).correct;
    let function = shortest_function(&search, StepInput::Tip, &NOMINAL_DEGREES, &equilibria(&search)?, &trial_errors)?;
    let found = search.full_search((&function, None), question.places);
    Ok((FunctionCode::new(function, found.correct, found.last_step[0], &machine), exact))
}
