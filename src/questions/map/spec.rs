//! A workspace map as its file gives it, before it is checked: units in the keys, unknown keys refused.

use serde::Deserialize;

use crate::questions::spec::default_grid;

/// A workspace map as the study file gives it: a grid over the workspace box and the steps of φ.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WorkspaceMapSpec {
    /// Number of grid points along x, y, z, both ends included; 11 × 11 × 11 if not given.
    #[serde(default = "default_grid")]
    pub grid: [usize; 3],
    /// Lower corner of the box, O; that of the machine's workspace if not given.
    pub min_mm: Option<[f64; 3]>,
    /// Upper corner of the box, O; that of the machine's workspace if not given.
    pub max_mm: Option<[f64; 3]>,
    /// Step between tool angles φ over one revolution; 10° if not given.
    pub phi_step_deg: Option<f64>,
    /// Heights of the slices drawn; the grid plane nearest to each is shown.
    pub slices_z_mm: Vec<f64>,
}
