//! What the program itself answers: drives for a position of the tool tip under a wrench, and where the tip stands with drives.

use nalgebra::Vector3;

use super::domain::{Asked, Domain, Place};
use crate::{
    compensation::{CompensationStatus, Method, Session, Target, TaskPoint, compensate},
    input::error::{Error, Result},
    machine::Machine,
    simulation::{Machines, Source, sources::TO_ROUNDING},
    spatial::Wrench,
    statics::{State, Workspace, equilibrium, one_step},
};

/// The nominal machine, by which positions are commanded, and the one that answers, wherever it is asked.
#[derive(Debug, Clone)]
pub(super) struct Exact {
    pub machines: Machines,
}

/// Storage to ask the program with.
pub(super) struct Asking {
    session: Session,
    workspace: Workspace,
}

/// An equilibrium at a position under a wrench.
#[derive(Debug, Clone)]
pub(super) struct Solved {
    pub asked: Asked,
    pub drives: Vec<f64>,
    /// Its numbers, see [`one_step`].
    pub numbers: Vec<f64>,
}

impl Exact {
    /// The machine that answers.
    pub fn real(&self) -> &Machine {
        &self.machines.real
    }

    /// The wrench at P of one about the tool tip.
    fn load(&self, wrench: &[f64; 6]) -> Wrench {
        let tip = self.machines.nominal.home.pose.rotation * self.machines.nominal.tool_tip;
        let own = Wrench::new(*wrench);
        Wrench { force: own.force, moment: own.moment + tip.cross(&own.force) }
    }

    /// Storage to ask with.
    pub fn asking(&self) -> Asking {
        Asking { session: self.machines.session(Source::All), workspace: Workspace::new(self.real()) }
    }

    fn task(&self, (position, wrench): &Asked) -> TaskPoint {
        let nominal = &self.machines.nominal;
        let at = Vector3::from(*position) - nominal.home.pose.rotation * nominal.tool_tip;
        let (pose, load) = (nominal.pose_at(at), self.load(wrench));
        TaskPoint { pose, load, target: Target::ToolTip, wanted: None, external: None }
    }

    /// Equilibria with the tool tip where it is asked for.
    ///
    /// # Errors
    /// The machine does not stand somewhere: which, and why.
    pub fn solved(&self, domain: &Domain, places: impl IntoIterator<Item = Place>) -> Result<Vec<Solved>> {
        let mut asking = self.asking();
        places.into_iter().map(|place| self.solve(&mut asking, domain.asked(&place))).collect()
    }

    /// The equilibrium without a load, with the tool tip at `position`, mm.
    ///
    /// # Errors
    /// As of [`Self::solved`].
    pub fn unloaded(&self, position: &[f64; 3]) -> Result<Solved> {
        self.solve(&mut self.asking(), (*position, [0.0; 6]))
    }

    fn solve(&self, asking: &mut Asking, asked: Asked) -> Result<Solved> {
        let done = compensate(&mut asking.session, &self.task(&asked), Method::Direct);
        if !done.status.is_success() {
            return Err(self.does_not_stand(&asked, &done.status));
        }
        let numbers = one_step::numbers(&done.drives, asking.session.state());
        Ok(Solved { asked, drives: done.drives, numbers })
    }

    fn does_not_stand(&self, (position, wrench): &Asked, status: &CompensationStatus) -> Error {
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

    /// Where the tool tip stands with these drives under the wrench, mm, sought from `near`, numbers of a state; `None` where there is no
    /// equilibrium.
    pub fn tip(&self, drives: &[f64], wrench: &[f64; 6], near: &[f64], asking: &mut Asking) -> Option<Vector3<f64>> {
        if drives.iter().chain(near).any(|number| !number.is_finite()) {
            return None;
        }
        let real = self.real();
        let (_, mut state): (_, State) = one_step::state_of(real, near);
        let outcome = equilibrium(real, drives, &self.load(wrench), &mut state, &mut asking.workspace, &TO_ROUNDING);
        outcome.is_equilibrium().then(|| state.pose.transform(real.tool_tip))
    }

    /// Where the tool tip of a state is, mm.
    pub fn tip_of(&self, numbers: &[f64]) -> Vector3<f64> {
        let (_, state) = one_step::state_of(self.real(), numbers);
        state.pose.transform(self.real().tool_tip)
    }
}
