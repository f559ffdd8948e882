//! The machine bent by a load, for a drawing: its lines as commanded and as they settle.

use crate::{
    compensation::Demand,
    machine::{ChainError, Machine},
    page::DeflectedPose,
    simulation::{Machines, Source, settled::settled},
};

/// How `machine` with `errors` settles at the nominal command of `demand`; `None` where it does not.
pub(crate) fn deflected_pose(
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

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;
    use crate::{compensation::Target, process::MillingForce};

    #[test]
    fn the_lines_of_a_loaded_machine_end_where_its_platform_settles() {
        let machine = Machine::named_or_file("orthoglide").unwrap();
        let errors = machine.assembly_errors(&[1.0, -1.0, 1.0]);
        let load = MillingForce::PAPER.wrench(0.7, &machine.tool());
        let pose = machine.pose_at(machine.points[1].position);
        let bent = deflected_pose(
            &machine,
            &errors,
            &Demand { pose, load, target: Target::ToolTip, wanted: None, external: None },
            "at Q1".into(),
        )
        .unwrap();
        for skeleton in [&bent.commanded, &bent.settled] {
            for chain in &skeleton.chains {
                let end = Vector3::from(*chain.links.last().unwrap().last().unwrap());
                assert!((end - Vector3::from(skeleton.platform_mm)).norm() < 1e-6, "{}: {end}", chain.name);
            }
        }
        let moved = Vector3::from(bent.settled.tool_tip_mm) - Vector3::from(bent.commanded.tool_tip_mm);
        assert!((moved - bent.tool_displacement_mm).norm() < 1e-9);
        assert!(moved.norm() > 0.5);
    }
}
