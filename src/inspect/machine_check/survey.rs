//! The machine over its workspace: where its tool is softest, how far its weight moves it, and what it can carry.

use nalgebra::Vector3;
use serde::Serialize;

use super::{
    compliance::compliance,
    payload::{Payload, payload},
};
use crate::{
    machine::{Configuration, Machine},
    simulation::sources::TO_ROUNDING,
    spatial::{Grid, Wrench},
    statics::{State, Status, Workspace, equilibrium, principal_stiffnesses, tool_compliance, unloaded_compliance},
};

/// Points along each side of the workspace.
const POINTS: usize = 5;

/// What is found on a grid over the workspace.
#[derive(Debug, Clone, Serialize)]
pub struct Survey {
    /// Points of the grid along x, y and z.
    pub counts: [usize; 3],
    /// How many of them are reached.
    pub reached: usize,
    /// Where the tool tip is softest; `None` where it is free or rigid everywhere.
    pub softest: Option<Softest>,
    /// What the weight does; `None` without weight.
    pub droop: Option<Droop>,
    /// The mass the tool can carry; `None` without gravity or without a limit of a drive's force.
    pub payload: Option<Payload>,
}

/// The softest place.
#[derive(Debug, Clone, Serialize)]
pub struct Softest {
    /// Of P, mm.
    pub position_mm: Vector3<f64>,
    /// Principal stiffnesses of the tool tip against the workpiece, N/mm, ascending.
    pub tool_stiffness_n_per_mm: [f64; 3],
    /// Share of each elastic element in the compliance of the tool tip, as at home.
    pub compliance_shares: Vec<(String, f64)>,
}

/// How far the weight moves the tool tip from where the rigid machine has it, seen from the workpiece where that is carried.
#[derive(Debug, Clone, Serialize)]
pub struct Droop {
    /// Least and largest distance, mm.
    pub range_mm: [f64; 2],
    /// The place of the largest: of P, mm.
    pub position_mm: Vector3<f64>,
    /// Places where the weight has no stable equilibrium, with the reason at the first.
    pub without: Option<(usize, String)>,
}

/// Looks at the corners of the workspace and at points between them.
pub(super) fn survey(machine: &Machine, workspace: &mut Workspace) -> Survey {
    let (min, max) = (machine.workspace.min, machine.workspace.max);
    let grid = Grid::new(min, max, [0, 1, 2].map(|axis| if max[axis] > min[axis] { POINTS } else { 1 }));
    let places: Vec<Configuration> =
        (0..grid.len()).filter_map(|index| machine.command(grid.position(index)).ok()).collect();
    Survey {
        counts: grid.counts(),
        reached: places.len(),
        softest: softest(&machine.weightless(), &places, workspace),
        droop: droop(machine, &places, workspace),
        payload: payload(machine, &places, workspace),
    }
}

fn softest(machine: &Machine, places: &[Configuration], workspace: &mut Workspace) -> Option<Softest> {
    let mut softest: Option<(f64, &Configuration)> = None;
    let mut carrier = machine.carrier.clone();
    for at in places {
        let lever = at.pose.rotation * machine.tool_tip;
        let Some(compliance) = unloaded_compliance(machine, at, workspace) else { continue };
        let mut of_tip = tool_compliance(&compliance, lever);
        if let Some(carrier) = &mut carrier {
            let touched = carrier.touched_at(at.pose.translation + lever);
            let carried = unloaded_compliance(carrier, &touched, &mut Workspace::new(carrier));
            let Some(carried) = carried else { continue };
            of_tip += tool_compliance(&carried, Vector3::zeros());
        }
        let [least, ..] = principal_stiffnesses(&of_tip);
        if least.is_finite() && softest.is_none_or(|(softer, _)| least < softer) {
            softest = Some((least, at));
        }
    }
    let (_, at) = softest?;
    let found = compliance(machine, at, workspace).ok()?;
    Some(Softest {
        position_mm: at.pose.translation,
        tool_stiffness_n_per_mm: found.stiffness?,
        compliance_shares: found.shares,
    })
}

fn droop(machine: &Machine, places: &[Configuration], workspace: &mut Workspace) -> Option<Droop> {
    if !machine.has_weight() || places.is_empty() {
        return None;
    }
    let mut carrier = machine.carrier.clone();
    let mut droop = Droop { range_mm: [f64::INFINITY, 0.0], position_mm: places[0].pose.translation, without: None };
    for at in places {
        let mut state = State::rigid(machine, at);
        let outcome = equilibrium(machine, &at.drives, &Wrench::zero(), &mut state, workspace, &TO_ROUNDING);
        if outcome.status != Status::Solved {
            droop.without.get_or_insert_with(|| (0, outcome.status.reason(machine))).0 += 1;
            continue;
        }
        let mut moved = machine.tool_displacement(&at.pose, &state.pose);
        if let Some(carrier) = &mut carrier {
            let touched = carrier.touched_at(at.pose.translation + at.pose.rotation * machine.tool_tip);
            let mut state = State::rigid(carrier, &touched);
            let mut own = Workspace::new(carrier);
            let outcome = equilibrium(carrier, &touched.drives, &Wrench::zero(), &mut state, &mut own, &TO_ROUNDING);
            if outcome.status != Status::Solved {
                droop.without.get_or_insert_with(|| (0, outcome.status.reason(carrier))).0 += 1;
                continue;
            }
            moved -= state.pose.translation - touched.pose.translation;
        }
        let moved = moved.norm();
        let [least, largest] = &mut droop.range_mm;
        *least = least.min(moved);
        if moved > *largest {
            (*largest, droop.position_mm) = (moved, at.pose.translation);
        }
    }
    Some(droop)
}
