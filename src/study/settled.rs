//! Where a loaded machine stands, as lines in space.

#[cfg(feature = "report")]
use nalgebra::Vector3;

use crate::{
    compensation::{Demand, Method, compensate},
    machine::Skeleton,
    statics::State,
    study::{Machines, Source},
};

/// A machine at a nominal command, without and under its load.
#[derive(Debug, Clone)]
pub(super) struct Settled {
    /// The nominal machine at its command.
    pub commanded: Skeleton,
    /// The real machine under load.
    pub loaded: Skeleton,
    /// Displacement of the tool tip, O axes, mm.
    #[cfg(feature = "report")]
    pub tool_displacement_mm: Vector3<f64>,
}

/// How the real machine settles at the nominal command of `demand`; `None` where it does not.
pub(super) fn settled(machines: &Machines, demand: &Demand) -> Option<Settled> {
    let at = machines.nominal.inverse_kinematics(&demand.pose).ok()?;
    let mut session = machines.session(Source::All);
    session.stand(&at, &State::rigid(&machines.nominal, &at));
    let answer = compensate(&mut session, demand, Method::None);
    if !answer.status.is_success() {
        return None;
    }
    let state = session.state();
    let mut first = 0;
    let chains: Vec<Vec<f64>> = machines
        .real
        .chains
        .iter()
        .zip(&state.chains)
        .map(|(chain, settled)| {
            let mut values = settled.coordinates.clone();
            chain.add_joints(&at.drives[first..], &mut values);
            first += chain.drives.len();
            values
        })
        .collect();
    Some(Settled {
        commanded: machines.nominal.rigid_skeleton(&at),
        loaded: machines.real.skeleton(&chains, &state.pose),
        #[cfg(feature = "report")]
        tool_displacement_mm: answer.tool_displacement,
    })
}
