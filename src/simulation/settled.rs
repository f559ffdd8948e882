//! The loaded machine in equilibrium, as lines in space.

use nalgebra::Vector3;

use crate::{
    compensation::{Method, TaskPoint, compensate},
    simulation::{Failure, Machines, Source},
    spatial::Skeleton,
};

/// Lines of a machine at a nominal command, without and under load.
#[derive(Debug, Clone)]
pub(crate) struct LoadedLines {
    /// The nominal machine at its command.
    pub commanded: Skeleton,
    /// The actual machine of the source, in equilibrium.
    pub loaded: Skeleton,
    /// Displacement of the tool tip, O axes, mm.
    pub tool_displacement_mm: Vector3<f64>,
}

/// Solves the equilibrium of the machine under `source` at the nominal command of `task`; a failure if it has none or cannot go there.
pub(crate) fn equilibrium_under(machines: &Machines, source: Source, task: &TaskPoint) -> Result<LoadedLines, Failure> {
    let (nominal, actual) = (machines.nominal(source), machines.actual(source));
    let head = task.led.and_then(|led| nominal.with_commanded_head()?.with_external_axes(&led).ok());
    let near = head.map(|head| head.inverse_kinematics(&task.pose)).transpose()?;
    let at = match near {
        Some(near) => nominal.inverse_kinematics_from(&near, &task.pose)?,
        None => nominal.inverse_kinematics(&task.pose)?,
    };
    let mut session = machines.session(source);
    session.set_rigid(&at);
    let answer = compensate(&mut session, &source.task(task), Method::None);
    if !answer.status.is_success() {
        return Err(Failure::of(&answer.status, nominal));
    }
    let state = session.state();
    let mut first = 0;
    let chains: Vec<Vec<f64>> = actual
        .chains
        .iter()
        .zip(&state.chains)
        .map(|(chain, settled)| {
            let mut values = settled.coordinates.clone();
            chain.add_joint_positions(&at.drives[first..], &mut values);
            first += chain.drives.len();
            values
        })
        .collect();
    Ok(LoadedLines {
        commanded: nominal.rigid_skeleton(&at),
        loaded: actual.skeleton(&chains, &state.pose),
        tool_displacement_mm: answer.tool_displacement,
    })
}
