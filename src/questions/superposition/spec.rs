//! The table `[superposition]` of a study file as written, with units in its keys; checked by [`crate::questions::Study`].

use serde::Deserialize;

use crate::questions::spec::default_grid;

/// The table `[superposition]` of a study file: where and up to which load displacements by single sources may be added.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SuperpositionSpec {
    /// Number of grid points along x, y, z, both ends included; 11 × 11 × 11 if not given.
    #[serde(default = "default_grid")]
    pub grid: [usize; 3],
    /// Lower corner; the machine's workspace if not given.
    pub min_mm: Option<[f64; 3]>,
    /// Upper corner; the machine's workspace if not given.
    pub max_mm: Option<[f64; 3]>,
    /// Step between tool angles over one turn; 10° if not given.
    pub phi_step_deg: Option<f64>,
    /// Heights of the slices drawn; the grid plane nearest to each is shown.
    pub slices_z_mm: Vec<f64>,
    /// Superposition error of the tool tip from which superposition no longer counts as safe.
    pub tolerance_mm: f64,
    /// Locations studied in detail; the named points of the machine if not given.
    pub location: Option<Vec<LocationSpec>>,
    /// Factors on load and chain errors at which the growth of the superposition error is measured.
    #[serde(default)]
    pub scales: ScalesSpec,
    /// The largest factor tried on load and chain errors when the largest safe one is sought; 16 if not given.
    pub largest_factor: Option<f64>,
}

/// A location of P, by a named point or a position.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LocationSpec {
    /// Name; that of the point if not given.
    pub name: Option<String>,
    /// Named point of the machine. A location has this or `position_mm`.
    pub point: Option<String>,
    /// Position of P. A location has this or `point`.
    pub position_mm: Option<[f64; 3]>,
}

/// Factors at equal ratios, both ends included.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ScalesSpec {
    /// The smallest factor.
    pub smallest: f64,
    /// The largest factor.
    pub largest: f64,
    /// Number of factors.
    pub steps: usize,
}

impl Default for ScalesSpec {
    /// Returns the default factors of the growth study.
    fn default() -> Self {
        Self { smallest: 0.03125, largest: 2.0, steps: 7 }
    }
}
