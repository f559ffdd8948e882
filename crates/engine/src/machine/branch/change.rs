//! Changes of posture between two points of a path, during which the tool leaves the path: another branch, or a revolute joint turned a full turn back.

use std::fmt;

use serde::{Deserialize, Serialize};

use super::{Branch, arm::ON_BOTH};
use crate::machine::{Configuration, Machine};

/// Share of a full turn by which a revolute joint jumps that has been turned back within its travel, though the way was tracked.
const JUMP_TRACKED: f64 = 0.75;
/// Share of a full turn by which a revolute joint jumps where the way was not tracked: a wrist at its straight position swings by half a turn.
const JUMP_UNTRACKED: f64 = 0.25;
/// Configurations whose revolute and prismatic joints differ by less than this share of a full turn, and of the characteristic length, are the same.
const BESIDE: f64 = 1e-3;

/// Why a machine cannot be tracked from one configuration to the next along a path.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum PostureChange {
    /// An arm stands on another branch: a singularity is between.
    Branch {
        /// Before.
        from: Branch,
        /// After.
        to: Branch,
    },
    /// A revolute joint stands elsewhere: taken a full turn back within its travel, or swung about where a singularity is between.
    Jump {
        /// Its drive, as tables call it.
        drive: String,
        /// What it showed, degrees.
        from_deg: f64,
        /// What it shows, degrees.
        to_deg: f64,
    },
    /// The arm does not have the posture that a program says; or it is none within its travel at this pose.
    Contradicts,
}

impl fmt::Display for PostureChange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            PostureChange::Branch { from, to } => write!(f, "changes branch from {from} to {to}"),
            PostureChange::Jump { drive, from_deg, to_deg } => {
                write!(f, "drive {drive} jumps from {from_deg:.1}° to {to_deg:.1}°")
            }
            PostureChange::Contradicts => f.write_str("has not the posture that the program says"),
        }
    }
}

impl Machine {
    /// Whether a pose has several postures and nothing holds the machine in one: revolute joints, one chain and no passive joints.
    pub fn may_change_posture(&self) -> bool {
        matches!(self.chains.as_slice(), [chain] if chain.passive.is_empty())
            && self.full_turns().any(|turn| turn.is_some())
    }

    /// Change of posture from one point of a path, where the machine stands as in `before`, to the next, `after`; `None` where it stays, and for
    /// machines that are no serial chain with revolute joints. `tracked`: whether the straight line leads there ([`Machine::inverse_kinematics_from`]).
    /// Postures at a singularity are on both branches that meet there.
    pub fn posture_change(
        &self,
        before: &Configuration,
        after: &Configuration,
        tracked: bool,
    ) -> Option<PostureChange> {
        if !self.may_change_posture() {
            return None;
        }
        if let (Some(from), Some(to)) = (self.branch_factors(before), self.branch_factors(after))
            && from.iter().zip(&to).any(|(from, to)| from.abs().min(to.abs()) > ON_BOTH && from * to < 0.0)
        {
            return Some(PostureChange::Branch { from: Branch::from_signs(from), to: Branch::from_signs(to) });
        }
        let min_share_of_turn = if tracked { JUMP_TRACKED } else { JUMP_UNTRACKED };
        self.find_jump(&before.drives, &after.drives, min_share_of_turn)
    }

    /// The first revolute joint that differs by more than 3/4 of a full turn between the drive positions `from` and `to` (mm, rad), such as nominal
    /// and corrected command of a point; `None` if there is none, or the machine is no serial chain with a revolute joint.
    pub fn full_turn_jump(&self, from: &[f64], to: &[f64]) -> Option<PostureChange> {
        self.may_change_posture().then(|| self.find_jump(from, to, JUMP_TRACKED)).flatten()
    }

    /// The first revolute joint that moves by more than the share `min_share_of_turn` of a full turn between two sets of drive positions (mm, rad);
    /// `None` if none does.
    fn find_jump(&self, from: &[f64], to: &[f64], min_share_of_turn: f64) -> Option<PostureChange> {
        let moved = self
            .full_turns()
            .zip(from.iter().zip(to))
            .position(|(turn, (from, to))| turn.is_some_and(|turn| (to - from).abs() > min_share_of_turn * turn))?;
        Some(PostureChange::Jump {
            drive: self.drive_labels().swap_remove(moved),
            from_deg: from[moved].to_degrees(),
            to_deg: to[moved].to_degrees(),
        })
    }

    /// Full turns that bring each revolute joint of `from` nearest to its position in `to`, as changes of drives, rad; 0 for prismatic joints and locked ones.
    pub fn full_turns_towards(&self, from: &[f64], to: &[f64]) -> Vec<f64> {
        let turns = |(turn, (from, to)): (Option<f64>, (&f64, &f64))| {
            turn.map_or(0.0, |turn| ((to - from) / turn).round() * turn)
        };
        self.full_turns().zip(from.iter().zip(to)).map(turns).collect()
    }

    /// Whether all drives have the same positions, to within 0.1 % of a full turn or of the characteristic length.
    pub fn has_same_drives(&self, a: &Configuration, b: &Configuration) -> bool {
        let values = a.drives.iter().zip(&b.drives);
        let length = self.characteristic_length;
        self.full_turns().zip(values).all(|(turn, (a, b))| (a - b).abs() <= BESIDE * turn.unwrap_or(length))
    }
}
