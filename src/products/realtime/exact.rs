//! Reference results of the engine: drives for a tool tip position under a wrench, and tool tip positions for drives.

use nalgebra::Vector3;

use super::domain::{Domain, Sample, TipTask};
use crate::{
    compensation::{CompensationStatus, Method, Session, Target, TaskPoint, compensate},
    input::error::{Error, Result},
    machine::Machine,
    simulation::{Machines, Source, sources::TO_ROUNDING},
    spatial::Wrench,
    statics::{Scratch, State, equilibrium, one_step},
};

/// The nominal machine, which commands positions, and the actual one, solved by the engine.
#[derive(Debug, Clone)]
pub(super) struct ReferenceSolver {
    pub machines: Machines,
}

/// Storage of the solver, reused from point to point.
pub(super) struct Storage {
    session: Session,
    scratch: Scratch,
}

/// An equilibrium with the tool tip at a position under a wrench.
#[derive(Debug, Clone)]
pub(super) struct TipState {
    pub asked: TipTask,
    pub drives: Vec<f64>,
    /// State of the equilibrium as numbers, see [`one_step`].
    pub numbers: Vec<f64>,
}

impl ReferenceSolver {
    /// Returns the actual machine.
    pub fn actual(&self) -> &Machine {
        &self.machines.actual
    }

    /// Returns the wrench at P (N, N·mm) of a `wrench` about the tool tip, base axes.
    fn load(&self, wrench: &[f64; 6]) -> Wrench {
        let tip = self.machines.nominal.home.pose.rotation * self.machines.nominal.tool_tip;
        let about_tip = Wrench::new(*wrench);
        Wrench { force: about_tip.force, moment: about_tip.moment + tip.cross(&about_tip.force) }
    }

    /// Creates storage for solving, to be reused from point to point.
    pub fn storage(&self) -> Storage {
        Storage { session: self.machines.session(Source::All), scratch: Scratch::new(self.actual()) }
    }

    /// Returns the task point of a tool tip position (O, mm) under a wrench about it.
    pub fn task(&self, (position, wrench): &TipTask) -> TaskPoint {
        let nominal = &self.machines.nominal;
        let at = Vector3::from(*position) - nominal.home.pose.rotation * nominal.tool_tip;
        let (pose, load) = (nominal.pose_at(at), self.load(wrench));
        TaskPoint::new(pose, load, Target::ToolTip)
    }

    /// Solves the equilibria at these points of the domain; the error names a point without equilibrium and the reason.
    pub fn solve_all(&self, domain: &Domain, places: impl IntoIterator<Item = Sample>) -> Result<Vec<TipState>> {
        let mut storage = self.storage();
        places.into_iter().map(|place| self.solve(&mut storage, domain.task_at(&place))).collect()
    }

    /// Solves the unloaded equilibrium with the tool tip at `position` (O, mm).
    pub fn unloaded(&self, position: &[f64; 3]) -> Result<TipState> {
        self.solve(&mut self.storage(), (*position, [0.0; 6]))
    }

    /// Solves the equilibrium of a task, with the drives that bring the loaded tool tip to its position; an error if there is none.
    fn solve(&self, storage: &mut Storage, task: TipTask) -> Result<TipState> {
        let compensation = compensate(&mut storage.session, &self.task(&task), Method::Direct);
        if !compensation.status.is_success() {
            return Err(self.no_equilibrium(&task, &compensation.status));
        }
        let numbers = one_step::state_numbers(&compensation.drives, storage.session.state());
        Ok(TipState { asked: task, drives: compensation.drives, numbers })
    }

    /// Returns the error of a task without equilibrium.
    fn no_equilibrium(&self, (position, wrench): &TipTask, status: &CompensationStatus) -> Error {
        // Without the digits of rounding.
        let shown = |value: f64| (value * 1e3).round() / 1e3 + 0.0;
        let ([x, y, z], [a, b, c, d, e, f]) = (position.map(shown), wrench.map(shown));
        let reason = status.reason(&self.machines.nominal);
        let problem = format!(
            "the machine does not stand with its tool tip at ({x}, {y}, {z}) mm under ({a}, {b}, {c}) N and ({d}, {e}, {f}) N·mm: {reason}; \
             expected a box and a range of forces in which it does"
        );
        Error::argument("--box", problem)
    }

    /// Returns the tool tip (O, mm) at these drives under the wrench, iterated from the state numbers `near`; `None` without equilibrium.
    pub fn tip(&self, drives: &[f64], wrench: &[f64; 6], near: &[f64], storage: &mut Storage) -> Option<Vector3<f64>> {
        if drives.iter().chain(near).any(|number| !number.is_finite()) {
            return None;
        }
        let actual = self.actual();
        let (_, mut state): (_, State) = one_step::state_from_numbers(actual, near);
        let outcome = equilibrium(actual, drives, &self.load(wrench), &mut state, &mut storage.scratch, &TO_ROUNDING);
        outcome.is_equilibrium().then(|| state.pose.transform(actual.tool_tip))
    }

    /// Returns the tool tip position (O, mm) of the state `numbers`.
    pub fn tip_of(&self, numbers: &[f64]) -> Vector3<f64> {
        let (_, state) = one_step::state_from_numbers(self.actual(), numbers);
        state.pose.transform(self.actual().tool_tip)
    }
}
