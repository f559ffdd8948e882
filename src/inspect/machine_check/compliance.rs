//! How the tool tip gives way at a place, and which elements make it do so.

use nalgebra::Vector3;

use crate::{
    machine::{Configuration, Machine},
    simulation::sources::TO_ROUNDING,
    spatial::Wrench,
    statics::{
        Outcome, State, Status, Workspace, deformation_energies, equilibrium, principal_stiffnesses, tool_compliance,
    },
};

/// The force by which elements' shares in the compliance of the tool are told, N.
const FORCE_N: f64 = 1.0;

/// The tool tip's compliance at a place.
pub(super) struct Compliance {
    /// Principal stiffnesses, N/mm, ascending; `None` where the platform is free.
    pub stiffness: Option<[f64; 3]>,
    /// Share of each elastic element, all directions together; sums to 1. None where the tip is rigid.
    pub shares: Vec<(String, f64)>,
}

/// The tool tip's compliance where `machine` without its weight stands at `at`, from a force along x, y and z; the status of
/// a force without equilibrium.
pub(super) fn compliance(
    machine: &Machine,
    at: &Configuration,
    workspace: &mut Workspace,
) -> Result<Compliance, Status> {
    let lever = at.pose.rotation * machine.tool_tip;
    let mut carrier = machine.carrier.clone();
    let mut shares: Vec<(String, f64)> = Vec::new();
    let mut stiffness = None;
    for axis in 0..3 {
        let mut force = Vector3::zeros();
        force[axis] = FORCE_N;
        let load = Wrench { force, moment: lever.cross(&force) };
        let (outcome, mut energies) = taken_up(machine, at, &load, workspace)?;
        let mut of_tip = outcome.compliance.map(|compliance| tool_compliance(&compliance, lever));
        if let Some(carrier) = &mut carrier {
            let (at, load) =
                (carrier.touched_at(at.pose.translation + lever), Wrench { force: -force, moment: Vector3::zeros() });
            let (outcome, of_carrier) = taken_up(carrier, &at, &load, &mut Workspace::new(carrier))?;
            energies.extend(of_carrier);
            let carried = outcome.compliance.map(|compliance| tool_compliance(&compliance, Vector3::zeros()));
            of_tip = of_tip.zip(carried).map(|(tip, carried)| tip + carried);
        }
        stiffness = of_tip.map(|compliance| principal_stiffnesses(&compliance));
        for (index, (name, energy)) in energies.into_iter().enumerate() {
            match shares.get_mut(index) {
                Some((_, sum)) => *sum += energy,
                None => shares.push((name, energy)),
            }
        }
    }
    let total: f64 = shares.iter().map(|(_, energy)| energy).sum();
    if stiffness.is_some_and(|[least, ..]: [f64; 3]| least.is_infinite()) || total == 0.0 {
        shares.clear();
    }
    for (_, share) in &mut shares {
        *share /= total;
    }
    Ok(Compliance { stiffness, shares })
}

/// The equilibrium under `load`, and the energy that each elastic element takes up by it.
fn taken_up(
    machine: &Machine,
    at: &Configuration,
    load: &Wrench,
    workspace: &mut Workspace,
) -> Result<(Outcome, Vec<(String, f64)>), Status> {
    let mut rest = State::rigid(machine, at);
    equilibrium(machine, &at.drives, &Wrench::zero(), &mut rest, workspace, &TO_ROUNDING);
    let mut state = rest.clone();
    let outcome = equilibrium(machine, &at.drives, load, &mut state, workspace, &TO_ROUNDING);
    match outcome.status {
        Status::Solved => {
            let energies = deformation_energies(machine, &at.drives, &rest, &state);
            Ok((outcome, energies))
        }
        failed => Err(failed),
    }
}
