//! Changes of posture between two points of a path: no tool stays on its path meanwhile.

use std::fmt;

use serde::{Deserialize, Serialize};

use super::{Branch, arm::ON_BOTH};
use crate::machine::{Configuration, Machine};

/// A hinge that stands this share of a full turn elsewhere has been turned back within its travel, though the way led there.
const TURNED_BACK: f64 = 0.75;
/// The same where no way led there: a wrist at its straight position swings by half a turn.
const SWUNG: f64 = 0.25;

/// Why a machine cannot be led from one configuration to the next along a path.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum PostureChange {
    /// An arm stands on another branch: a singularity is between.
    Branch {
        /// Before.
        from: Branch,
        /// After.
        to: Branch,
    },
    /// A hinge stands elsewhere: taken a full turn back within its travel, or swung about where a singularity is between.
    Jump {
        /// Its drive, as tables call it.
        drive: String,
        /// What it showed, degrees.
        from_deg: f64,
        /// What it shows, degrees.
        to_deg: f64,
    },
}

impl fmt::Display for PostureChange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            PostureChange::Branch { from, to } => write!(f, "changes branch from {from} to {to}"),
            PostureChange::Jump { drive, from_deg, to_deg } => {
                write!(f, "drive {drive} jumps from {from_deg:.1}° to {to_deg:.1}°")
            }
        }
    }
}

impl Machine {
    /// Whether it has several postures for a pose and nothing that holds it in one: hinges, one chain and no passive joints.
    pub(crate) fn may_change_posture(&self) -> bool {
        matches!(self.chains.as_slice(), [chain] if chain.passive.is_empty())
            && self.full_turns().any(|turn| turn.is_some())
    }

    /// How the posture changes from one point of a path, where the machine stands as in `before`, to the next, `after`; `None` where
    /// it stays, and of machines that are no serial chain with hinges. `is_led`: whether the straight line leads there
    /// ([`Machine::inverse_kinematics_from`]). Postures at a singularity are on both branches that meet there.
    pub fn posture_change(&self, before: &Configuration, after: &Configuration, is_led: bool) -> Option<PostureChange> {
        if !self.may_change_posture() {
            return None;
        }
        if let (Some(from), Some(to)) = (self.branch_signs(before), self.branch_signs(after))
            && from.iter().zip(&to).any(|(from, to)| from.abs().min(to.abs()) > ON_BOTH && from * to < 0.0)
        {
            return Some(PostureChange::Branch { from: Branch::of_signs(from), to: Branch::of_signs(to) });
        }
        let most = if is_led { TURNED_BACK } else { SWUNG };
        let values = before.drives.iter().zip(&after.drives);
        let moved = self
            .full_turns()
            .zip(values)
            .position(|(turn, (before, after))| turn.is_some_and(|turn| (after - before).abs() > most * turn))?;
        Some(PostureChange::Jump {
            drive: self.drive_labels().swap_remove(moved),
            from_deg: before.drives[moved].to_degrees(),
            to_deg: after.drives[moved].to_degrees(),
        })
    }
}
