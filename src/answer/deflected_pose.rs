//! The machine bent by a load, for a drawing: its lines as commanded and as they settle.

use crate::{
    compensation::TaskPoint,
    machine::{ChainError, Machine},
    page::DeflectedPose,
    simulation::{Machines, Source, settled::settled},
};

/// How `machine` with `errors` settles at the nominal command of `task`; `None` where it does not.
pub fn deflected_pose(
    machine: &Machine,
    errors: &[ChainError],
    task: &TaskPoint,
    place: String,
) -> Option<DeflectedPose> {
    let machines = Machines::new(machine, errors).ok()?;
    let settled = settled(&machines, Source::All, task).ok()?;
    Some(DeflectedPose {
        place,
        commanded: settled.commanded,
        settled: settled.loaded,
        tool_displacement_mm: settled.tool_displacement_mm,
        force_n: task.load.force,
    })
}
