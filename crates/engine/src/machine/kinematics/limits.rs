//! Travel of drives and limits of passive joints.

use super::{Configuration, Unreachable};
use crate::{
    machine::{Machine, Motion},
    spatial::Pose,
};

/// Share of the largest of limits and travel by which a position beyond a limit still counts as within: rounding by searches, and of a program's numbers.
const LIMIT_ROUNDING: f64 = 1e-9;

impl Machine {
    /// Brings `at`, which meets `target`, within the limits by full turns and redundant drives; `Err` if a limit is violated all the same.
    pub(in crate::machine) fn adjust_to_limits(
        &self,
        at: Configuration,
        target: &Pose,
    ) -> Result<Configuration, Unreachable> {
        let at = self.adjust_freely(at, target);
        self.check_limits(&at)?;
        Ok(at)
    }

    /// Brings `at`, which meets `target`, within travel as far as redundant drives, moved nearest to home, and full turns allow.
    pub(in crate::machine) fn adjust_freely(&self, at: Configuration, target: &Pose) -> Configuration {
        let mut at = if self.redundancy > 0 { self.nearest_to_home(at, target) } else { at };
        if self.check_travel(&at).is_err() {
            self.turn_within_travel(&mut at);
        }
        at
    }

    /// Takes revolute drives as many full turns back or on as bring them nearest to home.
    pub(in crate::machine) fn turn_nearest_to_home(&self, at: &mut Configuration) {
        let turns = self.full_turns_towards(&at.drives, &self.home.drives);
        at.drives.iter_mut().zip(turns).for_each(|(rho, turns)| *rho += turns);
    }

    /// Takes revolute drives beyond their travel full turns back or on where that brings them within.
    fn turn_within_travel(&self, at: &mut Configuration) {
        for (((_, drive), turn), rho) in self.drives().zip(self.full_turns()).zip(&mut at.drives) {
            if let Some(within) = drive.travel.and_then(|travel| wrap_into_travel(*rho, travel, turn)) {
                *rho = within;
            }
        }
    }

    /// Takes revolute drives that are beyond their travel as many full turns back or on as bring them nearest to its middle.
    pub(in crate::machine) fn turn_nearest_to_travel(&self, at: &mut Configuration) {
        for (((_, drive), turn), rho) in self.drives().zip(self.full_turns()).zip(&mut at.drives) {
            if let (Some((low, high)), Some(turn)) = (drive.travel, turn)
                && overrun(*rho, low, high) > 0.0
            {
                *rho -= ((*rho - 0.5 * (low + high)) / turn).round() * turn;
            }
        }
    }

    /// Whether the travel of a drive, a passive joint or the branch is limited.
    pub(crate) fn has_limits(&self) -> bool {
        let drives = self.drives().any(|(_, drive)| drive.travel.is_some());
        drives
            || self.branch.is_some()
            || self.chains.iter().flat_map(|chain| &chain.passive).any(|joint| joint.limits.is_some())
    }

    /// Checks travel, joint limits and the chosen branch at the configuration `at`.
    pub fn check_limits(&self, at: &Configuration) -> Result<(), Unreachable> {
        self.check_travel(at)?;
        self.check_branch(at)
    }

    /// Index of the first drive that is beyond its travel at `positions` (mm, rad; machine order), and the error that says so; `None` if none is.
    pub fn drive_beyond_travel(&self, positions: &[f64]) -> Option<(usize, Unreachable)> {
        self.drives().zip(positions).enumerate().find_map(|(number, ((c, drive), &rho))| {
            let (low, high) = drive.travel?;
            let fault = || Unreachable::Travel {
                chain: self.chains[c].name.clone(),
                drive: drive.name.clone(),
                value: drive.motion.to_shown(rho),
                low: drive.motion.to_shown(low),
                high: drive.motion.to_shown(high),
                unit: drive.motion.position_unit().into(),
            };
            (overrun(rho, low, high) > 0.0).then(|| (number, fault()))
        })
    }

    /// Checks the travel of drives and the limits of passive joints at the configuration `at`.
    pub(in crate::machine) fn check_travel(&self, at: &Configuration) -> Result<(), Unreachable> {
        if let Some((_, fault)) = self.drive_beyond_travel(&at.drives) {
            return Err(fault);
        }
        for (chain, values) in self.chains.iter().zip(&at.passive) {
            for (joint, &q) in chain.passive.iter().zip(values) {
                if let Some((low, high)) = joint.limits
                    && overrun(q, low, high) > 0.0
                {
                    return Err(Unreachable::JointLimit {
                        chain: chain.name.clone(),
                        joint: joint.name.clone(),
                        value: joint.motion.to_shown(q),
                        low: joint.motion.to_shown(low),
                        high: joint.motion.to_shown(high),
                        unit: joint.motion.position_unit().into(),
                    });
                }
            }
        }
        Ok(())
    }

    /// Limits, motion and coordinate (mm, rad) of each drive and then of each passive joint that has limits.
    fn limited_axes(&self, at: &Configuration) -> impl Iterator<Item = ((f64, f64), Motion, f64)> {
        let drives = self.drives().zip(&at.drives).map(|((_, drive), &rho)| (drive.travel, drive.motion, rho));
        let joints = self.chains.iter().zip(&at.passive).flat_map(|(chain, values)| {
            chain.passive.iter().zip(values).map(|(joint, &q)| (joint.limits, joint.motion, q))
        });
        drives.chain(joints).filter_map(|(limits, motion, value)| Some((limits?, motion, value)))
    }

    /// Largest excess of a drive or joint over its limits, mm or degrees; 0 within them.
    pub fn limit_excess(&self, at: &Configuration) -> f64 {
        let excess =
            self.limited_axes(at).map(|((low, high), motion, value)| motion.to_shown(overrun(value, low, high)));
        excess.fold(0.0, f64::max)
    }

    /// Smallest margin of a drive or joint to an end of its limits, mm or degrees; negative beyond, infinite without limits.
    pub fn limit_margin(&self, at: &Configuration) -> f64 {
        let room = self.limited_axes(at).map(|((low, high), motion, q)| motion.to_shown(f64::min(q - low, high - q)));
        room.fold(f64::INFINITY, f64::min)
    }

    /// Appends to `shares` where each limited drive and joint is in its range, ±1 at the ends that `check_limits` takes.
    pub fn limit_fractions(&self, at: &Configuration, shares: &mut Vec<f64>) {
        shares.extend(self.limited_axes(at).map(|((low, high), _, value)| {
            let half = 0.5 * (high - low) + limit_rounding(low, high);
            (value - 0.5 * (low + high)) / half
        }));
    }
}

/// Position of a drive brought from `value` into its travel by multiples of its full `turn`; `None` if none of them is within.
pub(in crate::machine) fn wrap_into_travel(value: f64, (low, high): (f64, f64), turn: Option<f64>) -> Option<f64> {
    if overrun(value, low, high) == 0.0 {
        return Some(value);
    }
    let (turn, rounding) = (turn?, limit_rounding(low, high));
    let back = match value < low {
        true => value + ((low - rounding - value) / turn).ceil() * turn,
        false => value - ((value - high - rounding) / turn).ceil() * turn,
    };
    (overrun(back, low, high) == 0.0).then_some(back)
}

/// Excess of `value` over its limits, in its unit; 0 within them and up to [`limit_rounding`] outside.
fn overrun(value: f64, low: f64, high: f64) -> f64 {
    let excess = f64::max(low - value, value - high);
    if excess > limit_rounding(low, high) { excess } else { 0.0 }
}

/// Excess over the limits `low` and `high` that is put down to rounding, in their unit.
fn limit_rounding(low: f64, high: f64) -> f64 {
    LIMIT_ROUNDING * low.abs().max(high.abs()).max(high - low)
}
