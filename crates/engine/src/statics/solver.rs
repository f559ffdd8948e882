//! Equilibria of one machine, one by one.

use super::{Scratch, Settings, Solution, State, equilibrium};
use crate::{
    machine::{Configuration, Machine, Unreachable},
    spatial::Wrench,
};

/// A machine, and the storage that its equilibria share. No equilibrium depends on the ones before.
/// [`equilibrium()`] takes other [`Settings`] and another start than the undeflected machine, [`Batch`](super::Batch) many cases at once.
#[derive(Debug, Clone)]
pub struct Solver {
    machine: Machine,
    scratch: Scratch,
}

impl Solver {
    /// A solver for `machine`; [`Machine::with_errors`] makes one with errors.
    pub fn new(machine: &Machine) -> Self {
        Self { machine: machine.clone(), scratch: Scratch::new(machine) }
    }

    /// Equilibrium `t = f⁻¹(F | t₀)`, eq. (7), with the drives at `drives` (mm, rad; one each, in machine order) under the dead wrench `load`
    /// at P in O axes (N, N·mm), on the assembly mode of home. Whether there is one is its `status`.
    ///
    /// # Errors
    /// As [`Machine::forward_kinematics`]: the undeflected chains do not close with these drives.
    ///
    /// # Panics
    /// If `drives` are not as many as the machine has.
    pub fn solve(&mut self, drives: &[f64], load: &Wrench) -> Result<Solution, Unreachable> {
        assert_eq!(drives.len(), self.machine.drive_count(), "drives of {}", self.machine.name);
        let commanded = self.machine.forward_kinematics(drives)?;
        Ok(self.solve_at(&commanded, load))
    }

    /// Equilibrium under `load` from the undeflected machine at `commanded`: on its assembly mode; for a machine with errors, whose chains
    /// close only where they yield, on that of the machine without.
    pub fn solve_at(&mut self, commanded: &Configuration, load: &Wrench) -> Solution {
        let (machine, drives) = (&self.machine, &commanded.drives);
        let mut state = State::rigid(machine, commanded);
        let outcome = equilibrium(machine, drives, load, &mut state, &mut self.scratch, &Settings::default());
        Solution::new(machine, drives, &state, &outcome, &mut self.scratch)
    }
}
