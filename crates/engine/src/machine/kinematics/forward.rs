//! Forward kinematics: from the drives to the pose of P, and the machine assembled at home.

use std::f64::consts::TAU;

use super::{
    Configuration, Unreachable,
    closure::{Closure, Command},
    continuation::MIN_STEP,
    search::CLOSURE_ROUNDING,
    singularity::Barriers,
};
use crate::machine::{Machine, Motion};

impl Machine {
    /// Forward kinematics: the configuration with drives at `drives` (mm, rad) on the assembly mode of home; limits of joints are not checked.
    ///
    /// # Errors
    /// [`Unreachable::Closure`] if the chains cannot close with these drives.
    pub fn forward_kinematics(&self, drives: &[f64]) -> Result<Configuration, Unreachable> {
        self.forward_kinematics_from(&self.home, drives)
    }

    /// Forward kinematics continued from a known configuration `start` instead of home.
    ///
    /// # Errors
    /// As [`Machine::forward_kinematics`].
    pub fn forward_kinematics_from(&self, start: &Configuration, drives: &[f64]) -> Result<Configuration, Unreachable> {
        let reached = self.follow(start, MIN_STEP, Barriers::OfDrives, |s, closure, from| {
            let rho: Vec<f64> = start.drives.iter().zip(drives).map(|(a, b)| a + (b - a) * s).collect();
            closure.newton(from, &Command::Drives(&rho))
        });
        self.conclude(reached, &Command::Drives(drives))
    }

    /// Closes all chains at the home pose, searching from the joint values in the machine file; `Err` if that fails or a limit is broken.
    pub(in crate::machine) fn assemble_at_home(&self) -> Result<Configuration, Unreachable> {
        let mut closure = Closure::new(self);
        let command = Command::Task(&self.home.pose);
        let mut at = self.home.clone();
        for _ in 0..20 {
            at = closure.approach(&at, &command);
            closure.linearise(&at, &command);
            if closure.residual.amax() < CLOSURE_ROUNDING * self.characteristic_length {
                self.unwind(&mut at);
                self.check_limits(&at)?;
                return Ok(at);
            }
        }
        Err(closure.failure_reason(&at, &command))
    }

    /// Takes back full turns that the search has made, of revolute drives and of passive revolute joints without a spring.
    fn unwind(&self, at: &mut Configuration) {
        let nearest = |value: f64, home: f64, turn: f64| value - ((value - home) / turn).round() * turn;
        for (((_, drive), turn), rho) in self.drives().zip(self.full_turns()).zip(&mut at.drives) {
            if let Some(turn) = turn {
                *rho = nearest(*rho, drive.home, turn);
            }
        }
        for (chain, values) in self.chains.iter().zip(&mut at.passive) {
            for (joint, q) in chain.passive.iter().zip(values) {
                if joint.motion == Motion::Revolute && joint.stiffness == 0.0 {
                    *q = nearest(*q, joint.home, TAU);
                }
            }
        }
    }
}
