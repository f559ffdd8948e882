//! Checks of a workspace map as written, which make it a [`WorkspaceMapStudy`].

use super::{WorkspaceMapStudy, block_count, run_in_blocks, spec::WorkspaceMapSpec};
use crate::{
    input::error::Result,
    questions::{
        Question, Resolved, StudyContext, Template,
        over_workspace::{LoadCaseKeys, Region, Shown, load_case, uncertainty_anywhere},
    },
    work::Work,
};

/// Most points of a map, which is computed in blocks: its table takes about 80 GB.
const MAX_POINTS: usize = 100_000_000;

impl Question for WorkspaceMapStudy {
    type Spec = WorkspaceMapSpec;
    type Shown = Shown;
    const NAME: &str = "a workspace map";
    const TEMPLATE: Template = Template {
        name: "map",
        about: "How far the tool moves over the workspace, and which drive commands compensate that",
        files: &[("study.toml", include_str!("template/study.toml"))],
    };
    const TABLES: &[&str] = &["map"];

    /// Checks the map's table and makes its load case and grid.
    fn resolve(spec: &WorkspaceMapSpec, context: &StudyContext<'_>) -> Result<Resolved<Self>> {
        context.overrides.refuse_points(context.name)?;
        let keys = LoadCaseKeys { phi_step_deg: spec.phi_step_deg, uses_target: true };
        let (load_case, not_used, inputs) = load_case(context, keys)?;
        let region =
            Region { min_mm: spec.min_mm, max_mm: spec.max_mm, grid: spec.grid, slices_z_mm: &spec.slices_z_mm };
        let box_of_p = [load_case.machine.workspace.min, load_case.machine.workspace.max];
        let (grid, slices_z, size) = region.checked_grid(context, box_of_p, MAX_POINTS)?;
        let shown = Shown { slices_z, not_used };
        let (uncertainty, read) = uncertainty_anywhere(context, &load_case)?;
        let inputs = inputs.and(read).and(size);
        Ok(Resolved { study: WorkspaceMapStudy { load_case, grid, uncertainty }, shown, inputs })
    }

    /// Returns the number of grid points of the map.
    fn items(&self) -> (usize, &'static str) {
        (self.grid.len(), "points")
    }

    /// Returns the number of grid points, never `None`, as every map can be an image.
    fn image_points(&self) -> Option<usize> {
        Some(self.grid.len())
    }

    /// Returns the number of blocks of the map.
    fn pieces(&self) -> usize {
        block_count(self)
    }

    /// Computes all blocks of the map and keeps them in `work`.
    fn compute(&self, work: &Work) -> Result<()> {
        run_in_blocks(self, work, |_| Ok(()))
    }
}
