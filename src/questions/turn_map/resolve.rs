//! From a map of turns as written to a checked study.

use nalgebra::Vector3;

use super::{TurnMapStudy, axes::axes, spec::TurnMapSpec};
use crate::{
    input::error::{Error, Result},
    machine::Machine,
    process::{Placement, ToolTurn},
    questions::{
        Given, Resolved,
        over_workspace::{Acting, OwnKeys, acting, box_grid, corners_or, grid_input, slice_heights},
    },
    redundancy,
    toolpath::{Sampling, Toolpath},
};

/// Most places of a map, all directions together.
const MAX_POINTS: usize = 1_000_000;
/// Steps between turns and directions of the force if the study does not say them, degrees.
const TURN_STEP_DEG: f64 = 10.0;
const PHI_STEP_DEG: f64 = 45.0;

/// Heights of the slices drawn, mm.
#[derive(Debug, Clone, PartialEq)]
pub struct Shown {
    /// Heights, mm.
    pub slices_z: Vec<f64>,
}

/// Why `machine` cannot turn its tool freely, if it cannot.
fn can_turn(machine: &Machine) -> std::result::Result<(), String> {
    let somewhere =
        Toolpath::line(Vector3::zeros(), Vector3::x(), Sampling::default()).map_err(|fault| fault.to_string())?;
    match redundancy::check(machine, &Placement::default(), &somewhere) {
        Err(Error::Argument { problem, .. }) => Err(problem),
        other => other.map_err(|error| error.to_string()),
    }
}

pub(super) fn resolve(spec: &TurnMapSpec, given: &Given<'_>) -> Result<Resolved<TurnMapStudy>> {
    given.overrides.refuse_points(given.name)?;
    let phi_step_deg = Some(spec.phi_step_deg.unwrap_or(PHI_STEP_DEG));
    let own = OwnKeys { phi_step_deg, uses_target: true };
    let Acting { machine, force, phis, errors, target, tolerance_mm, not_used, inputs } = acting(given, own)?;
    can_turn(&machine).or_else(|problem| given.check.root().key("machine").fail(problem))?;
    let check = &given.check;
    let to_tip = machine.home.pose.rotation * machine.tool_tip;
    let around_home = [machine.workspace.min + to_tip, machine.workspace.max + to_tip];
    let corners = corners_or(spec.min_mm, spec.max_mm, around_home, check)?;
    let axes = axes(spec, &machine, check)?;
    let grid = box_grid(corners, spec.grid, given.overrides, (MAX_POINTS / axes.len(), check))?;
    let slices_z = slice_heights(&spec.slices_z_mm, corners, check)?;
    let step_deg = spec.turn_step_deg.unwrap_or(TURN_STEP_DEG);
    if !(1.0..=180.0).contains(&step_deg) {
        return check.key("turn_step_deg").fail(format!("must be from 1 to 180, got {step_deg}"));
    }
    let distance = check.key("min_singularity_distance");
    let default = ToolTurn::default();
    let min_singularity_distance = match spec.min_singularity_distance {
        Some(given) => distance.not_negative(given)?,
        None => default.min_singularity_distance,
    };
    let turn = ToolTurn { step_deg, min_singularity_distance, ..default };
    let inputs = inputs.and(grid_input(grid.counts()));
    let study = TurnMapStudy { machine, errors, grid, axes, turn, force, phis, target, tolerance_mm, not_used };
    Ok(Resolved { study, shown: Shown { slices_z }, inputs })
}
