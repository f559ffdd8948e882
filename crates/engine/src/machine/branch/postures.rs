//! The postures in which an arm meets a pose, one for each branch, and the machine on a chosen branch.

use std::cell::RefCell;

use serde::Serialize;

use super::{Branch, arm::ON_BOTH};
use crate::{
    input::error::{Error, Result},
    machine::{
        Configuration, Machine, Unreachable,
        kinematics::{self, Closure, Command},
    },
    spatial::{Pose, branch_labels},
};

/// A configuration of an arm that meets a pose.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Posture {
    /// Its branch.
    pub branch: Branch,
    /// Drives, within their travel if full turns allow it, and the pose of P.
    pub at: Configuration,
    /// The first limit that it violates.
    pub limits: std::result::Result<(), Unreachable>,
}

impl Machine {
    /// Postures in which an arm ([`Machine::branch_of`]) meets `target`, at most one for each branch, in the order of [`Branch::ALL`],
    /// within travel or not. A rail under the arm stays at home unless redundancy moves it. Empty for other machines and out of reach.
    ///
    /// Joints are found in closed form and corrected by the machine's own closure equations.
    pub fn postures_at(&self, target: &Pose) -> Vec<Posture> {
        let is_finite = target.translation.iter().chain(target.rotation.iter()).all(|entry| entry.is_finite());
        let Some(arm) = self.arm.as_ref().filter(|_| is_finite) else { return Vec::new() };
        let chain = &self.chains[0];
        let mut values = vec![0.0; chain.virtual_count];
        chain.add_joint_positions(&self.home.drives, &mut values);
        let drives = &chain.drives[arm.first..];
        let free = values[drives[3].coordinate];
        let closure = RefCell::new(Closure::new(self));
        let posture = |joints: [f64; 6]| -> Option<Posture> {
            for (drive, joint) in drives.iter().zip(joints) {
                values[drive.coordinate] = joint;
            }
            let start = self.serial_configuration(&chain.commanded_drives(&values));
            let mut at = closure.borrow_mut().solve_from(start, &Command::Task(target))?;
            self.turn_nearest_to_home(&mut at);
            let mut at = self.adjust_freely(at, target);
            self.turn_nearest_to_travel(&mut at);
            Some(Posture { branch: self.branch_of(&at)?, limits: self.check_travel(&at), at })
        };
        let postures: Vec<Posture> = arm.solutions(target, free).into_iter().filter_map(posture).collect();
        Branch::ALL
            .iter()
            .filter_map(|branch| postures.iter().find(|posture| posture.branch == *branch).cloned())
            .collect()
    }

    /// Branch and drives (mm, rad) of the postures in which an arm meets `target`, computed from its axes alone: as [`Machine::postures_at`] but
    /// for full turns, to within what an arm may miss a spherical wrist by. For many poses; empty for other machines.
    pub fn postures_in_closed_form(&self, target: &Pose) -> Vec<(Branch, Vec<f64>)> {
        let Some(arm) = self.arm.as_ref() else { return Vec::new() };
        let chain = &self.chains[0];
        let mut values = vec![0.0; chain.virtual_count];
        chain.add_joint_positions(&self.home.drives, &mut values);
        let drives = &chain.drives[arm.first..];
        let (free, commanded) = (values[drives[3].coordinate], chain.command_solver());
        let posture = |joints: [f64; 6]| {
            for (drive, joint) in drives.iter().zip(joints) {
                values[drive.coordinate] = joint;
            }
            (Branch::from_signs(arm.branch_factors(&joints)), commanded(&values))
        };
        arm.solutions(target, free).into_iter().map(posture).collect()
    }

    /// Configuration of an arm of one chain with its drives at `drives`, revolute joints turned as often as [`Machine::postures_at`] turns them; `None`
    /// where travel does not allow it. `full_turns`: those of the machine.
    pub fn posture_within_travel(&self, drives: &mut [f64], full_turns: &[Option<f64>]) -> Option<Configuration> {
        let homes = self.home.drives.iter();
        for ((((_, drive), turn), rho), home) in self.drives().zip(full_turns).zip(drives.iter_mut()).zip(homes) {
            if let Some(turn) = turn {
                *rho -= ((*rho - home) / turn).round() * turn;
            }
            if let Some(travel) = drive.travel {
                *rho = kinematics::wrap_into_travel(*rho, travel, *turn)?;
            }
        }
        Some(self.serial_configuration(drives))
    }

    /// This machine at home on `branch`: it stands on no other, and what it reaches on others only is unreachable.
    ///
    /// # Errors
    /// [`Error::Argument`], `branch`: the machine is no arm with a spherical wrist, or does not stand on this branch at home within its
    /// travel; the message names the branches on which it does.
    pub fn on_branch(&self, branch: Branch) -> Result<Self> {
        let refusal = |problem: String| Error::Argument { argument: "branch".into(), problem };
        let mut machine = self.clone();
        machine.branch = None;
        let Some(home_branch) = machine.branch_of(&machine.home) else {
            return Err(refusal(format!(
                "{} has no branches: expected a serial chain that ends in six revolute joints, axes 1 and 2 perpendicular, 2 and 3 parallel, \
                 4 to 6 through one point",
                self.name
            )));
        };
        if home_branch != branch {
            let postures = machine.postures_at(&machine.home.pose);
            let allowed = || {
                branch_labels(postures.iter().filter(|posture| posture.limits.is_ok()).map(|posture| posture.branch))
            };
            let found = postures.iter().find(|posture| posture.branch == branch);
            machine.home = match found.map(|posture| (&posture.at, &posture.limits)) {
                Some((at, Ok(()))) => at.clone(),
                Some((_, Err(limit))) => {
                    return Err(refusal(format!("{branch} at home: {limit}; within travel there: {}", allowed())));
                }
                None => {
                    return Err(refusal(format!("{branch} does not reach home; within travel there: {}", allowed())));
                }
            };
            machine.characteristic_length = kinematics::characteristic_length(&machine.chains, &machine.home);
        }
        machine.branch = Some(branch);
        Ok(machine)
    }

    /// This machine on `branch`, see [`Machine::on_branch`]; unchanged for `None`.
    pub(in crate::machine) fn on_branch_if_any(self, branch: Option<Branch>) -> Result<Self> {
        match branch {
            Some(branch) => self.on_branch(branch),
            None => Ok(self),
        }
    }

    /// Checks that the machine at `at` is on the branch that was chosen, if one was.
    pub(in crate::machine) fn check_branch(&self, at: &Configuration) -> std::result::Result<(), Unreachable> {
        let (Some(chosen), Some(signs)) = (self.branch, self.branch_factors(at)) else { return Ok(()) };
        let is_on = signs.iter().zip(chosen.signs()).all(|(factor, sign)| factor * sign >= -ON_BOTH);
        if is_on { Ok(()) } else { Err(Unreachable::OtherBranch { stands: Branch::from_signs(signs), chosen }) }
    }

    /// The posture on branch `chosen` that meets `target`; `Err` says why none does. `straight`: why the straight line does not lead there.
    pub(in crate::machine) fn solve_on_branch(
        &self,
        chosen: Branch,
        target: &Pose,
        straight: Unreachable,
    ) -> std::result::Result<Configuration, Unreachable> {
        let postures = self.postures_at(target);
        let (fitting, others): (Vec<_>, Vec<_>) = postures.into_iter().partition(|posture| posture.branch == chosen);
        let reason = match fitting.into_iter().next() {
            Some(Posture { at, limits: Ok(()), .. }) => return Ok(at),
            Some(Posture { limits: Err(limit), .. }) => limit,
            None => straight,
        };
        let branches =
            branch_labels(others.iter().filter(|posture| posture.limits.is_ok()).map(|posture| posture.branch));
        match branches.is_empty() {
            true => Err(reason),
            false => Err(Unreachable::OnOtherBranches { reason: Box::new(reason), chosen, branches }),
        }
    }
}
