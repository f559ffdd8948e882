//! Static equilibria of a machine under one load after another, with all drives at one command.

use crate::{
    machine::{Configuration, Machine},
    simulation::{Failure, sources::TO_ROUNDING},
    spatial::{Pose, Wrench},
    statics::{Outcome, Scratch, State, Status, equilibrium},
};

/// A machine with its drives locked at given positions, solved for one load after another.
pub(super) struct LockedMachine<'a> {
    machine: &'a Machine,
    drives: Vec<f64>,
    /// State from which a solve starts again where it failed from the former equilibrium.
    start: State,
    /// Equilibrium reached last.
    pub state: State,
    scratch: Scratch,
}

impl<'a> LockedMachine<'a> {
    /// Locks the drives of `machine` as in `at`, a rigid configuration of the nominal machine, from which solves start.
    pub fn at_command(machine: &'a Machine, at: &Configuration) -> Self {
        Self::at_drives(machine, &at.drives, State::rigid(machine, at))
    }

    /// Locks the drives of `machine` at `drives`; solves start from `start`.
    pub fn at_drives(machine: &'a Machine, drives: &[f64], start: State) -> Self {
        let scratch = Scratch::new(machine);
        Self { machine, drives: drives.to_vec(), state: start.clone(), start, scratch }
    }

    /// Solves the stable equilibrium under `load`, a wrench at P; `Err` where there is none.
    pub fn equilibrium_under(&mut self, load: &Wrench) -> Result<Outcome, Failure> {
        let mut outcome = self.try_equilibrium(load);
        if outcome.status != Status::Solved {
            self.state.clone_from(&self.start);
            outcome = self.try_equilibrium(load);
        }
        match outcome.status {
            Status::Solved => Ok(outcome),
            status => Err(Failure { status: status.label().into(), reason: status.reason(self.machine) }),
        }
    }

    /// Solves the equilibrium under `load` once, from the current state.
    fn try_equilibrium(&mut self, load: &Wrench) -> Outcome {
        equilibrium(self.machine, &self.drives, load, &mut self.state, &mut self.scratch, &TO_ROUNDING)
    }

    /// Returns the pose of P under each load, each solved from the one before; a failure names the φ (rad) of its load.
    pub fn poses_under(&mut self, loads: &[Wrench], phis: &[f64]) -> Result<Vec<Pose>, Failure> {
        let pose = |(load, phi): (&Wrench, &f64)| match self.equilibrium_under(load) {
            Ok(_) => Ok(self.state.pose),
            Err(Failure { status, reason }) => {
                Err(Failure { status, reason: format!("{reason} (tool angle {:.1}°)", phi.to_degrees()) })
            }
        };
        loads.iter().zip(phis).map(pose).collect()
    }
}
