//! The load case of questions over the workspace: a machine, its errors and cutting force, and what is compensated.

use super::Machines;
use crate::{
    compensation::{Target, TaskPoint},
    input::error::Result,
    machine::{ChainError, Machine},
    process::MillingForce,
    spatial::{Pose, Wrench},
};

/// A machine, and the errors and forces that act on it everywhere in its workspace.
#[derive(Debug, Clone)]
pub struct LoadCase {
    /// The nominal machine with the tool of the process, which computes commands.
    pub machine: Machine,
    /// Chain errors of the actual machine.
    pub errors: Vec<ChainError>,
    /// The cutting force.
    pub force: MillingForce,
    /// Which force within a turn of the spindle that is, in a sentence; empty where no law of milling gives it.
    pub force_of_turn: String,
    /// Tool angles φ of one turn, rad.
    pub phis: Vec<f64>,
    /// What is compensated: P, tool tip or full pose.
    pub target: Target,
    /// Tolerance of the tool's position, mm, if the process gives it.
    pub tolerance_mm: Option<f64>,
}

impl LoadCase {
    /// Returns the nominal and actual machines of its error sources.
    pub(crate) fn machines(&self) -> Result<Machines> {
        Machines::new(&self.machine, &self.errors)
    }

    /// Returns the task point at `pose` with the load case's target, under the cutting force with angle φ = `phi` (rad), or unloaded if `None`.
    pub(crate) fn task_point(&self, pose: Pose, phi: Option<f64>) -> TaskPoint {
        let cutting_force = |angle| self.force.wrench(angle, &self.machine.tool_at(&pose.rotation));
        let load = phi.map_or(Wrench::zero(), cutting_force);
        TaskPoint::new(pose, load, self.target)
    }
}
