//! Result of a compensation, which all methods share.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use crate::{
    machine::{Machine, PostureChange, Unreachable},
    statics,
};

/// How a compensation ended.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum CompensationStatus {
    /// The task error came below the tolerance.
    Converged,
    /// The method made its fixed number of passes, whatever error is left.
    Applied,
    /// The error was still shrinking when the iterations were used up.
    Slow,
    /// The error grew.
    Diverged,
    /// The step length α is outside (0, 1].
    BadStepLength {
        /// Its value.
        alpha: f64,
    },
    /// The modified target cannot be reached by the nominal machine.
    Unreachable(Unreachable),
    /// The machine cannot be tracked here from an earlier point of the path: it stands in another posture.
    ChangesPosture {
        /// How it changes.
        change: PostureChange,
        /// P in O at the earlier point, mm.
        before_mm: Vector3<f64>,
        /// P in O here, mm.
        here_mm: Vector3<f64>,
    },
    /// The loaded machine has no stable equilibrium at a command.
    NoEquilibrium(statics::Status),
    /// The workpiece's carrier has no stable equilibrium under the load.
    Workpiece {
        /// How its equilibrium ended.
        status: statics::Status,
        /// Why, in words.
        reason: String,
    },
    /// The drives have no influence on a controlled coordinate.
    Singular,
    /// The method needs a stiffness of the platform, and the machine is rigid in some directions.
    Rigid,
}

impl CompensationStatus {
    /// Word used in tables.
    pub fn label(&self) -> &'static str {
        match self {
            CompensationStatus::Converged => "converged",
            CompensationStatus::Applied => "applied",
            CompensationStatus::Slow => "slow",
            CompensationStatus::Diverged => "diverged",
            CompensationStatus::BadStepLength { .. } => "bad_step_length",
            CompensationStatus::Unreachable(_) => "unreachable",
            CompensationStatus::ChangesPosture { .. } => "changes_posture",
            CompensationStatus::NoEquilibrium(status) | CompensationStatus::Workpiece { status, .. } => status.label(),
            CompensationStatus::Singular => "uncontrollable",
            CompensationStatus::Rigid => "rigid",
        }
    }

    /// Whether the method converged, or was applied without a test of convergence.
    pub fn is_success(&self) -> bool {
        matches!(self, CompensationStatus::Converged | CompensationStatus::Applied)
    }

    /// Reason in words; empty for a success.
    pub fn reason(&self, machine: &Machine) -> String {
        match self {
            CompensationStatus::Converged | CompensationStatus::Applied => String::new(),
            CompensationStatus::Slow => "still converging when the iterations were used up".into(),
            CompensationStatus::Diverged => "the error grew".into(),
            CompensationStatus::BadStepLength { alpha } => format!("the step length must be in (0, 1], got {alpha}"),
            CompensationStatus::Unreachable(unreachable) => unreachable.to_string(),
            CompensationStatus::ChangesPosture { change, before_mm, here_mm } => {
                let at = |p: &Vector3<f64>| format!("({:.3}, {:.3}, {:.3})", p.x, p.y, p.z);
                format!("{change} on the way from P at {} to P at {} mm", at(before_mm), at(here_mm))
            }
            CompensationStatus::NoEquilibrium(status) => status.reason(machine),
            CompensationStatus::Workpiece { reason, .. } => reason.clone(),
            CompensationStatus::Rigid => {
                "this method moves the platform against the stiffness of all chains, and the machine is rigid in some directions".into()
            }
            CompensationStatus::Singular => "the drives have no influence on a controlled coordinate".into(),
        }
    }
}

/// A compensated point.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Compensation {
    /// How it ended.
    pub status: CompensationStatus,
    /// Drive positions ρ commanded, mm or rad.
    pub drives: Vec<f64>,
    /// Length of the task error in mm (rotations at the characteristic length) before the first correction and after each.
    pub history: Vec<f64>,
    /// Position error of the compensated point at the end, O axes, mm.
    pub position_error: Vector3<f64>,
    /// Displacement of the tool tip from where it is wanted, whatever is compensated, O axes, mm.
    pub tool_displacement: Vector3<f64>,
    /// Rotation of the platform from the wanted orientation at the end, rotation vector in O axes, rad.
    pub residual_rotation: Vector3<f64>,
    /// Forces of the drives at the end, N or N·mm.
    pub drive_forces: Vec<f64>,
    /// The equilibrium at the end; `None` where there is none.
    pub outcome: Option<statics::Outcome>,
}

impl Compensation {
    /// Number of corrections made.
    pub fn iterations(&self) -> usize {
        self.history.len().saturating_sub(1)
    }

    /// Length of the task error at the end, mm; infinite where none was computed.
    pub fn task_error(&self) -> f64 {
        self.history.last().copied().unwrap_or(f64::INFINITY)
    }
}
