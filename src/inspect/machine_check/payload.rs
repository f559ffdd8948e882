//! The mass that the drives can hold at the tool tip.

use nalgebra::Vector3;
use serde::Serialize;

use crate::{
    machine::{Configuration, Machine, Motion},
    simulation::sources::TO_ROUNDING,
    spatial::Wrench,
    statics::{State, Workspace, drive_forces, equilibrium},
};

/// The mass by which it is first told how drives' forces grow, kg.
const TRIAL_KG: f64 = 1.0;
/// The mass is corrected this often for how far it bends the machine.
const CORRECTIONS: usize = 4;
/// A drive whose force grows less by a kilogram does not carry it, as a share of that kilogram's weight, of a hinge at the machine's reach.
const NOT_CARRIED: f64 = 1e-6;

/// What the tool tip can carry where it can carry least.
#[derive(Debug, Clone, Serialize)]
pub struct Payload {
    /// The largest mass, kg; 0 where the machine's own weight is too much for a drive.
    pub kilograms: f64,
    /// The drive at its limit.
    pub drive: String,
    /// The place, of P, mm.
    pub position_mm: Vector3<f64>,
}

/// A mass, and the index of the drive that it takes to its limit.
type Held = (f64, usize);

/// The mass at the tool tip that at all `places` no drive with a limit needs more force for than that, the machine's own weight
/// included; `None` without gravity or limits, or where the mass has an effect on no drive.
pub(super) fn payload(machine: &Machine, places: &[Configuration], workspace: &mut Workspace) -> Option<Payload> {
    if machine.gravity == Vector3::zeros() || machine.drives().all(|(_, drive)| drive.force_limit.is_none()) {
        return None;
    }
    let mut least: Option<(Held, &Configuration)> = None;
    for at in places {
        let held = held_beyond(machine, at, 0.0, workspace);
        if let Some(held) = held.filter(|held| least.is_none_or(|(other, _)| held.0 < other.0)) {
            least = Some((held, at));
        }
    }
    let ((mut kilograms, mut drive), at) = least?;
    for _ in 0..CORRECTIONS {
        match held_beyond(machine, at, kilograms, workspace) {
            Some(held) if kilograms > 0.0 => (kilograms, drive) = held,
            _ => break,
        }
    }
    let drive = machine.drive_labels().swap_remove(drive);
    Some(Payload { kilograms, drive, position_mm: at.pose.translation })
}

/// The mass that takes the first drive to its limit, by how drives' forces grow from `kilograms` on.
fn held_beyond(machine: &Machine, at: &Configuration, kilograms: f64, workspace: &mut Workspace) -> Option<Held> {
    let start = forces(machine, at, kilograms, workspace)?;
    let more = forces(machine, at, kilograms + TRIAL_KG, workspace)?;
    let limits = machine.drives().map(|(_, drive)| (drive.force_limit, drive.motion));
    let mut least: Option<Held> = None;
    for (drive, (limit, motion)) in limits.enumerate() {
        let Some(limit) = limit else { continue };
        let lever = if motion == Motion::Revolute { machine.reach } else { 1.0 };
        if kilograms == 0.0 && start[drive].abs() > limit {
            return Some((0.0, drive));
        }
        let per_kilogram = (more[drive] - start[drive]) / TRIAL_KG;
        if per_kilogram.abs() <= NOT_CARRIED * machine.gravity.norm() * lever {
            continue;
        }
        let mass = (kilograms + (limit - start[drive] * per_kilogram.signum()) / per_kilogram.abs()).max(0.0);
        if least.is_none_or(|(other, _)| mass < other) {
            least = Some((mass, drive));
        }
    }
    least
}

/// Forces of all drives with a mass at the tool tip, N or N·mm.
fn forces(machine: &Machine, at: &Configuration, kilograms: f64, workspace: &mut Workspace) -> Option<Vec<f64>> {
    let force = machine.gravity * kilograms;
    let load = Wrench { force, moment: (at.pose.rotation * machine.tool_tip).cross(&force) };
    let mut state = State::rigid(machine, at);
    let outcome = equilibrium(machine, &at.drives, &load, &mut state, workspace, &TO_ROUNDING);
    outcome.is_equilibrium().then(|| drive_forces(machine, &state))
}
