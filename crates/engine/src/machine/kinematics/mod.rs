//! Rigid kinematics of any machine: all chain ends on one platform pose, springs undeflected.
//!
//! Unknowns are the drives, the passive joints and the platform pose; equations are the six closure errors of each chain
//! and what is commanded (task coordinates in the inverse problem, drives in the forward one). They are solved by a damped
//! least-squares Newton (Levenberg–Marquardt) that follows the straight line from a known configuration, usually home,
//! in steps short enough to stay on its assembly mode. Where the drives control more than the task asks for, the module
//! `redundancy` says what they do; where the straight line does not lead to the target, `alternative_branches` tries others.

#[cfg(target_arch = "x86_64")]
mod between;
mod closure;
mod command_step;
mod continuation;
mod equations;
mod forward;
mod inverse;
mod lane_configuration;
#[cfg(target_arch = "x86_64")]
mod lane_newton;
mod limits;
mod normal_step;
mod search;
mod side_by_side;
mod singularity;

use std::borrow::Cow;

use serde::{Deserialize, Serialize};

pub(super) use closure::{Closure, Command, characteristic_length};
pub(crate) use command_step::{CommandStep, DriveMotions};
pub(super) use limits::wrap_into_travel;
pub(super) use search::CLOSURE_ROUNDING;
pub use side_by_side::BatchKinematics;

use super::{Branch, Chain, task_space::round_off};
use crate::spatial::Pose;

/// A rigid configuration of the machine.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
pub struct Configuration {
    /// Pose of P in O.
    pub pose: Pose,
    /// Coordinates of all drives in machine order, mm or rad.
    pub drives: Vec<f64>,
    /// Passive joint coordinates of each chain, mm or rad.
    pub passive: Vec<Vec<f64>>,
}

impl Clone for Configuration {
    fn clone(&self) -> Self {
        Self { pose: self.pose, drives: self.drives.clone(), passive: self.passive.clone() }
    }

    /// Copies `from` into the storage that there is.
    fn clone_from(&mut self, from: &Self) {
        self.pose = from.pose;
        self.drives.clone_from(&from.drives);
        self.passive.clone_from(&from.passive);
    }
}

/// Why a target cannot be reached.
#[derive(Debug, Clone, PartialEq, thiserror::Error, Serialize, Deserialize)]
pub enum Unreachable {
    /// No configuration closes the chains.
    #[error("chain {chain} cannot close: gap {gap_mm:.3} mm")]
    Closure {
        /// The chain with the largest gap.
        chain: String,
        /// Its gap where the search stopped, rotations weighted by the machine's characteristic length.
        gap_mm: f64,
    },
    /// The target is farther from where a chain begins to move than the chain is long.
    #[error("chain {chain} would have to span {away_mm:.1} mm and is at most {span_mm:.1} mm long")]
    BeyondSpan {
        /// The chain.
        chain: String,
        /// From where it begins to move to the target, in the controlled coordinates, mm.
        away_mm: f64,
        /// The most that it spans, mm.
        span_mm: f64,
    },
    /// The chains do not close at the target: the straight way there ends before it.
    #[error("chain {chain} cannot close there; continuation from home stops {short_mm:.1} mm before")]
    TooFar {
        /// The chain that closes worst.
        chain: String,
        /// From where the straight way ends to the target in the controlled coordinates, rotations weighted by the machine's characteristic length.
        short_mm: f64,
    },
    /// The chains close there, but the way from home leads through a singularity or to another assembly mode.
    #[error("only on another working or assembly mode than home, or beyond a singularity")]
    OtherMode,
    /// Neither the straight line from home nor another way leads there.
    #[error("{straight}; alternative solution branches tried: {tried}")]
    NoWay {
        /// What the straight line ends with.
        straight: Box<Unreachable>,
        /// What else was tried.
        tried: Cow<'static, str>,
    },
    /// An arm meets the target in postures that are all beyond its travel.
    #[error("no posture of the arm is within its travel there: {limits}")]
    NoPosture {
        /// What the straight line from home ends with.
        straight: Box<Unreachable>,
        /// The first limit of each posture, with its branches.
        limits: String,
    },
    /// A coordinate is asked for that the drives do not control, and the machine is elsewhere in it.
    #[error(
        "{axis}: asked {asked} mm, the machine stays at {stands} mm: difference {} mm; the machine controls {controls}",
        round_off(.asked - .stands)
    )]
    Uncontrolled {
        /// The coordinate: x, y or z of P.
        axis: Cow<'static, str>,
        /// What is asked for, mm.
        asked: f64,
        /// Where P stands, mm.
        stands: f64,
        /// The coordinates that are controlled.
        controls: String,
    },
    /// An orientation is asked for that the drives cannot turn the platform to.
    #[error(
        "orientation: {apart_deg:.3} degrees from that of the platform there, roll, pitch and yaw {stands}; the machine controls {controls}"
    )]
    OtherOrientation {
        /// The angle between them, degrees.
        apart_deg: f64,
        /// The roll, pitch and yaw of the platform there, degrees.
        stands: String,
        /// The coordinates that are controlled.
        controls: String,
    },
    /// The platform turns with its position, and the point that is to be tracked is not where it should be.
    #[error(
        "the platform has a parasitic rotation (its orientation depends on its position): no position was found that \
         brings the tracked point onto the path (the nearest is {beside_mm:.3} mm off)"
    )]
    Turned {
        /// How far the point is from where it is asked for, mm.
        beside_mm: f64,
    },
    /// The drives that serve the task cannot meet it where the external axes stand.
    #[error("external axes: {reason}")]
    External {
        /// Why, in words.
        reason: String,
    },
    /// A drive would leave its travel.
    #[error("drive {drive} of chain {chain} at {value:.3} {unit}, travel {low:.3} to {high:.3} {unit}")]
    Travel {
        /// Its chain.
        chain: String,
        /// Its name.
        drive: String,
        /// Where it would have to stand.
        value: f64,
        /// Lower end of the travel.
        low: f64,
        /// Upper end of the travel.
        high: f64,
        /// `mm` or `deg`.
        unit: Cow<'static, str>,
    },
    /// The machine stands there on another branch than the one that was chosen.
    #[error("on branch {stands}; {chosen} is asked for")]
    OtherBranch {
        /// The branch there.
        stands: Branch,
        /// The branch chosen.
        chosen: Branch,
    },
    /// Only other branches than the one that was chosen reach there within travel.
    #[error("not on branch {chosen}: {reason}; within travel there: {branches}")]
    OnOtherBranches {
        /// Why the branch chosen does not.
        reason: Box<Unreachable>,
        /// The branch chosen.
        chosen: Branch,
        /// Those that do.
        branches: String,
    },
    /// A passive joint would leave its limits.
    #[error("joint {joint} of chain {chain} at {value:.3} {unit}, limits {low:.3} to {high:.3} {unit}")]
    JointLimit {
        /// Its chain.
        chain: String,
        /// Its name.
        joint: String,
        /// Where it would have to stand.
        value: f64,
        /// Lower limit.
        low: f64,
        /// Upper limit.
        high: f64,
        /// `mm` or `deg`.
        unit: Cow<'static, str>,
    },
}

impl Configuration {
    /// Configuration from which home is sought: drives and joints at the values of the machine file, P at `pose`.
    pub(super) fn start(chains: &[Chain], pose: Pose) -> Self {
        Self {
            pose,
            drives: chains.iter().flat_map(|chain| chain.drives.iter().map(|drive| drive.home)).collect(),
            passive: chains.iter().map(|chain| chain.passive.iter().map(|joint| joint.home).collect()).collect(),
        }
    }
}
