//! Reference results of the engine: drives for a tool tip position under a wrench, and tool tip positions for drives.

use nalgebra::Vector3;

use super::domain::{Domain, Sample, TipTask};
use crate::{
    compensation::{CompensationStatus, Method, Session, Target, TaskPoint, compensate},
    input::error::{Error, Result},
    machine::Machine,
    simulation::{Machines, Source, sources::TO_ROUNDING},
    spatial::Wrench,
    statics::{State, Workspace, equilibrium, one_step},
};

/// The nominal machine, which commands positions, and the actual one, solved by the engine.
#[derive(Debug, Clone)]
pub(super) struct ReferenceSolver {
    pub machines: Machines,
}

/// Storage of the solver, reused from point to point.
pub(super) struct Storage {
    session: Session,
    workspace: Workspace,
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
    pub fn real(&self) -> &Machine {
        &self.machines.real
    }

    /// Returns the wrench at P of a wrench about the tool tip.
    fn load(&self, wrench: &[f64; 6]) -> Wrench {
        let tip = self.machines.nominal.home.pose.rotation * self.machines.nominal.tool_tip;
        let own = Wrench::new(*wrench);
        Wrench { force: own.force, moment: own.moment + tip.cross(&own.force) }
    }

    /// Creates storage for the solver.
    pub fn storage(&self) -> Storage {
        Storage { session: self.machines.session(Source::All), workspace: Workspace::new(self.real()) }
    }

    /// Returns the task point of a tool tip position under a wrench.
    fn task(&self, (position, wrench): &TipTask) -> TaskPoint {
        let nominal = &self.machines.nominal;
        let at = Vector3::from(*position) - nominal.home.pose.rotation * nominal.tool_tip;
        let (pose, load) = (nominal.pose_at(at), self.load(wrench));
        TaskPoint { pose, load, target: Target::ToolTip, wanted: None, external: None }
    }

    /// Solves the equilibria at these points of the domain; the error names a point without equilibrium and the reason.
    pub fn solve_all(&self, domain: &Domain, places: impl IntoIterator<Item = Sample>) -> Result<Vec<TipState>> {
        let mut asking = self.storage();
        places.into_iter().map(|place| self.solve(&mut asking, domain.task_at(&place))).collect()
    }

    /// Solves the unloaded equilibrium with the tool tip at `position` (O, mm).
    pub fn unloaded(&self, position: &[f64; 3]) -> Result<TipState> {
        self.solve(&mut self.storage(), (*position, [0.0; 6]))
    }

    /// Solves the equilibrium of a task.
    fn solve(&self, asking: &mut Storage, asked: TipTask) -> Result<TipState> {
        let done = compensate(&mut asking.session, &self.task(&asked), Method::Direct);
        if !done.status.is_success() {
            return Err(self.no_equilibrium(&asked, &done.status));
        }
        let numbers = one_step::state_numbers(&done.drives, asking.session.state());
        Ok(TipState { asked, drives: done.drives, numbers })
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

    /// Returns the tool tip position (O, mm) at these drives under the wrench, with the state `near` as starting point; `None` without equilibrium.
    pub fn tip(&self, drives: &[f64], wrench: &[f64; 6], near: &[f64], asking: &mut Storage) -> Option<Vector3<f64>> {
        if drives.iter().chain(near).any(|number| !number.is_finite()) {
            return None;
        }
        let real = self.real();
        let (_, mut state): (_, State) = one_step::state_from_numbers(real, near);
        let outcome = equilibrium(real, drives, &self.load(wrench), &mut state, &mut asking.workspace, &TO_ROUNDING);
        outcome.is_equilibrium().then(|| state.pose.transform(real.tool_tip))
    }

    /// Returns the tool tip position (O, mm) of a state.
    pub fn tip_of(&self, numbers: &[f64]) -> Vector3<f64> {
        let (_, state) = one_step::state_from_numbers(self.real(), numbers);
        state.pose.transform(self.real().tool_tip)
    }
}
