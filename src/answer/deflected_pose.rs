//! The machine bent by a load, for a drawing: its lines as commanded and as they settle.

use crate::{
    compensation::Demand,
    machine::{ChainError, Machine},
    page::DeflectedPose,
    simulation::{Machines, Source, settled::settled},
};

/// How `machine` with `errors` settles at the nominal command of `demand`; `None` where it does not.
pub fn deflected_pose(
    machine: &Machine,
    errors: &[ChainError],
    demand: &Demand,
    place: String,
) -> Option<DeflectedPose> {
    let machines = Machines::new(machine, errors).ok()?;
    let settled = settled(&machines, Source::All, demand).ok()?;
    Some(DeflectedPose {
        place,
        commanded: settled.commanded,
        settled: settled.loaded,
        tool_displacement_mm: settled.tool_displacement_mm,
        force_n: demand.load.force,
    })
}
