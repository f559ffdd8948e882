//! What a controller without correction commands: drives of the rigid machine without errors, as a generated function like the others.

use super::{
    Errors, FITTED, Question, TRIED, allowed,
    domain::{Domain, corners, towards_faces},
    exact::{Exact, Solved},
    function::{Function, range},
    nothing, postures,
    search::Search,
    shortest,
    start::Degrees,
};
use crate::{input::error::Result, machine::Machine, simulation::Machines, statics::one_step::Given};

/// The function, and what is known of it.
#[derive(Debug, Clone)]
pub(super) struct Nominal {
    pub function: Function,
    pub errors: Errors,
    /// What the last step of each drive may be, mm or rad.
    pub largest_last_step: [f64; 3],
    exact: Exact,
}

/// Polynomials that are tried, the shortest first: there is no wrench.
const DEGREES: [Degrees; 8] = [(1, None), (2, None), (3, None), (4, None), (5, None), (6, None), (7, None), (8, None)];

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
pub(super) fn generate(question: &Question) -> Result<Nominal> {
    let machine = unmoved(&question.machines.nominal);
    let exact = Exact { machines: Machines::new(&machine, &[])? };
    let domain = Domain { wrench: [0.0; 6], ..question.domain };
    let solved = exact.solved(&domain, corners().step_by(3).chain((0..FITTED).map(towards_faces)))?;
    let step = Function::step(&exact, Given::Tip, &exact.solved(&domain, postures())?)?;
    let range = range(Given::Tip, &domain, &solved);
    let of = |degrees| Function::new(&exact, Given::Tip, &range, degrees, &solved, step.clone());
    let steps = question.steps;
    let tried = |correct: &Function| {
        let search = Search { exact: &exact, domain: &domain, correct, whereabouts: None, steps };
        search.briefly(TRIED).correct.last().copied().unwrap_or(f64::INFINITY)
    };
    let function = shortest(DEGREES.into_iter().filter_map(of), tried).ok_or_else(|| nothing(question))?;
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
    pub fn solved(&self, at: &[Solved]) -> Result<Vec<Vec<f64>>> {
        at.iter().map(|solved| Ok(self.exact.unloaded(&solved.asked.0)?.drives)).collect()
    }
}
