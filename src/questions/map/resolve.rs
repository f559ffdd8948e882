//! From a workspace map as written to a checked study.

use super::{Shown, WorkspaceMapStudy, spec::WorkspaceMapSpec};
use crate::{
    input::error::Result,
    questions::{
        Given, Resolved,
        over_workspace::{Acting, OwnKeys, acting, box_grid, grid_input, map_box, slice_heights},
    },
};

/// Most points of a map, which is computed in blocks: its table takes about 80 GB.
const MAX_POINTS: usize = 100_000_000;

pub(super) fn resolve(spec: &WorkspaceMapSpec, given: &Given<'_>) -> Result<Resolved<WorkspaceMapStudy>> {
    given.overrides.refuse_points(given.name)?;
    let own = OwnKeys { phi_step_deg: spec.phi_step_deg, uses_target: true };
    let Acting { machine, force, phis, errors, target, tolerance_mm, not_used, inputs } = acting(given, own)?;
    let corners = map_box(spec.min_mm, spec.max_mm, &machine, &given.check)?;
    let grid = box_grid(corners, spec.grid, given.overrides, (MAX_POINTS, &given.check))?;
    let slices_z = slice_heights(&spec.slices_z_mm, corners, &given.check)?;
    let inputs = inputs.and(grid_input(grid.counts()));
    let study = WorkspaceMapStudy { machine, errors, grid, force, phis, target, tolerance_mm, not_used };
    Ok(Resolved { study, shown: Shown { slices_z }, inputs })
}
