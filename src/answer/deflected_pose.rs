//! The machine under one load, to be drawn: its links as commanded, and in static equilibrium.

use crate::{
    compensation::TaskPoint,
    machine::{ChainError, Machine},
    page::DeflectedPose,
    simulation::{Machines, Source, settled::equilibrium_under},
};

/// Solves `machine` with `errors` at the nominal command of `task`, called `place`; `None` where it has no equilibrium.
pub fn deflected_pose(
    machine: &Machine,
    errors: &[ChainError],
    task: &TaskPoint,
    place: String,
) -> Option<DeflectedPose> {
    let machines = Machines::new(machine, errors).ok()?;
    let balanced = equilibrium_under(&machines, Source::All, task).ok()?;
    Some(DeflectedPose {
        place,
        commanded: balanced.commanded,
        loaded: balanced.loaded,
        tool_displacement_mm: balanced.tool_displacement_mm,
        force_n: task.load.force,
    })
}
