//! What a question over the workspace asks about: a machine, what acts on it, what is compensated, and how well.

use super::Machines;
use crate::{
    compensation::{Target, TaskPoint},
    input::error::Result,
    machine::{ChainError, Machine},
    process::MillingForce,
    spatial::{Pose, Wrench},
};

/// A machine, and what acts on it everywhere in its workspace.
#[derive(Debug, Clone)]
pub struct Scene {
    /// The nominal machine with the tool of the process, by which positions are commanded.
    pub machine: Machine,
    /// Errors of each chain of the real machine.
    pub errors: Vec<ChainError>,
    /// The cutting force.
    pub force: MillingForce,
    /// Tool angles φ of one turn, rad.
    pub phis: Vec<f64>,
    /// What compensation puts right.
    pub target: Target,
    /// How far the tool may be from where it should be, mm, if the process says it.
    pub tolerance_mm: Option<f64>,
}

impl Scene {
    /// The machines that answer for its sources.
    ///
    /// # Errors
    /// As [`Machines::new`].
    pub(crate) fn machines(&self) -> Result<Machines> {
        Machines::new(&self.machine, &self.errors)
    }

    /// What is asked of a command to `pose`: the cutting force at the tool angle `phi` (rad), if there is one.
    pub(crate) fn task(&self, pose: Pose, phi: Option<f64>) -> TaskPoint {
        let force = |phi| self.force.wrench(phi, &self.machine.tool_at(&pose.rotation));
        let load = phi.map_or(Wrench::zero(), force);
        TaskPoint { pose, load, target: self.target, wanted: None, external: None }
    }
}
