//! A machine held at drive positions and loaded.

use crate::{
    machine::{Configuration, Machine},
    simulation::{Failure, sources::TO_ROUNDING},
    spatial::{Pose, Wrench},
    statics::{Outcome, State, Status, Workspace, equilibrium},
};

/// A machine held at drive positions, solved for one load after another.
pub(super) struct Rig<'a> {
    machine: &'a Machine,
    drives: Vec<f64>,
    /// Where a solve starts that fails from its predecessor.
    start: State,
    /// Equilibrium last reached.
    pub state: State,
    workspace: Workspace,
}

impl<'a> Rig<'a> {
    /// `machine` with the drives of `at`, a rigid configuration of the nominal machine.
    pub fn rigid(machine: &'a Machine, at: &Configuration) -> Self {
        Self::standing(machine, &at.drives, State::rigid(machine, at))
    }

    /// `machine` with its drives at `drives` and `start` as the starting state.
    pub fn standing(machine: &'a Machine, drives: &[f64], start: State) -> Self {
        let workspace = Workspace::new(machine);
        Self { machine, drives: drives.to_vec(), state: start.clone(), start, workspace }
    }

    /// Stable equilibrium under `load`.
    pub fn settle(&mut self, load: &Wrench) -> Result<Outcome, Failure> {
        let mut outcome = self.solve(load);
        if outcome.status != Status::Solved {
            self.state.clone_from(&self.start);
            outcome = self.solve(load);
        }
        match outcome.status {
            Status::Solved => Ok(outcome),
            status => Err(Failure { status: status.label().into(), reason: status.reason(self.machine) }),
        }
    }

    fn solve(&mut self, load: &Wrench) -> Outcome {
        equilibrium(self.machine, &self.drives, load, &mut self.state, &mut self.workspace, &TO_ROUNDING)
    }

    /// Pose of P under each load, each solved from the one before; a failure names the φ (rad) of its load.
    pub fn turn(&mut self, loads: &[Wrench], phis: &[f64]) -> Result<Vec<Pose>, Failure> {
        let pose = |(load, phi): (&Wrench, &f64)| match self.settle(load) {
            Ok(_) => Ok(self.state.pose),
            Err(Failure { status, reason }) => {
                Err(Failure { status, reason: format!("{reason} (tool angle {:.1}°)", phi.to_degrees()) })
            }
        };
        loads.iter().zip(phis).map(pose).collect()
    }
}
