//! A redundancy map as written: raw, units in the keys, unknown keys refused. Checked by [`crate::questions::Study`].

use serde::Deserialize;

/// A redundancy map as the study file gives it: a grid of tool tip positions with tool directions and steps of γ.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RedundancyMapSpec {
    /// Number of grid points along x, y, z, both ends included.
    pub grid: [usize; 3],
    /// Lower corner of the tool tip positions, O; if not given, the machine's workspace box shifted from P to the tip as at home.
    pub min_mm: Option<[f64; 3]>,
    /// Upper corner of the tool tip positions, O.
    pub max_mm: Option<[f64; 3]>,
    /// Tool directions from the tip to the spindle, O; that at home if neither these nor a cone are given.
    pub tool_axes: Option<Vec<[f64; 3]>>,
    /// Directions on a cone.
    pub cone: Option<ConeSpec>,
    /// Step between values of γ, the rotation about the tool axis; 10 if not given.
    pub gamma_step_deg: Option<f64>,
    /// Smallest distance to a singularity, an inverse condition number; 0.01 if not given.
    pub min_singularity_distance: Option<f64>,
    /// Step between directions of the cutting force about the tool axis; 45° if not given.
    pub phi_step_deg: Option<f64>,
    /// Heights of the slices drawn; the grid plane nearest to each is shown.
    pub slices_z_mm: Vec<f64>,
}

/// Tool directions on a cone, and along its middle.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ConeSpec {
    /// Middle of the cone from the tip to the spindle, O.
    pub about: [f64; 3],
    /// Angle between the middle and the other directions.
    pub half_angle_deg: f64,
    /// Number of the other directions; 8 if not given.
    pub around: Option<usize>,
}
