//! A placement study as written: raw, units in the keys, unknown keys refused. Checked by [`crate::questions::Study`].

use std::collections::BTreeMap;

use serde::Deserialize;

use crate::{machine::spec::BoxSpec, process::GammaChoice, questions::spec::CircleSpec};

/// A placement study as the study file gives it.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlacementStudySpec {
    /// Features to be cut.
    pub feature: Vec<FeatureSpec>,
    /// Box that the workpiece occupies in its own frame W; the box around its paths if not given.
    pub workpiece: Option<BoxSpec>,
    /// The table on which the workpiece is to stand; it may stand anywhere if not given.
    pub table: Option<TableSpec>,
    /// Boxes in O that the workpiece must stay out of.
    #[serde(default)]
    pub forbidden: Vec<ForbiddenSpec>,
    /// Smallest distance of the workpiece from these boxes on every side; 5 mm if not given.
    pub clearance_mm: Option<f64>,
    /// Smallest and largest value of each coordinate that is searched.
    #[serde(default)]
    pub bounds: OfCoordinates<[f64; 2]>,
    /// Value of each coordinate that is not searched.
    #[serde(default)]
    pub fixed: OfCoordinates<f64>,
    /// How far from a place the workpiece may stand once it is clamped.
    #[serde(default)]
    pub allowance: AllowanceSpec,
    /// Objective to be minimised.
    pub objective: ObjectiveSpec,
    /// Settings of the search.
    pub search: SearchSpec,
    /// Named places to compare with.
    #[serde(default)]
    pub candidate: Vec<CandidateSpec>,
}

/// A feature: a path with its process.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FeatureSpec {
    /// Its name.
    pub name: String,
    /// Process file of this feature, relative to the study's folder; that of the study if not given.
    pub process: Option<String>,
    /// A full circle in the xy-plane of W. A feature has this or `file`.
    pub circle: Option<CircleSpec>,
    /// A program, relative to the study's folder. A feature has this or `circle`.
    pub file: Option<String>,
    /// Largest deviation of the tool from its path; that of its process if not given.
    pub tolerance_mm: Option<f64>,
    /// Width of the zone of ISO 1101 in which it must be, in place of `tolerance_mm`.
    pub tolerance_zone_mm: Option<f64>,
}

/// A rectangle in O that must hold the footprint of the workpiece. It has `min_mm` and `max_mm`, or `centre_mm` and `size_mm`.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TableSpec {
    /// Corner of least x and y.
    pub min_mm: Option<[f64; 2]>,
    /// The opposite corner.
    pub max_mm: Option<[f64; 2]>,
    /// Its centre.
    pub centre_mm: Option<[f64; 2]>,
    /// Lengths of its sides.
    pub size_mm: Option<[f64; 2]>,
    /// Angle about its centre from x of O to its first side; 0 if not given.
    pub yaw_deg: Option<f64>,
    /// z of its surface; not checked if not given.
    pub height_mm: Option<f64>,
    /// Smallest distance of the workpiece from its edge; 0 if not given.
    pub margin_mm: Option<f64>,
}

/// A box the workpiece must stay out of, in O.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ForbiddenSpec {
    /// Its name.
    pub name: String,
    /// Lower corner.
    pub min_mm: [f64; 3],
    /// Upper corner.
    pub max_mm: [f64; 3],
}

/// A value for each coordinate of a place, where one is given.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs)]
pub struct OfCoordinates<T> {
    pub x_mm: Option<T>,
    pub y_mm: Option<T>,
    pub z_mm: Option<T>,
    pub yaw_deg: Option<T>,
    pub roll_deg: Option<T>,
    pub pitch_deg: Option<T>,
}

impl<T: Copy> OfCoordinates<T> {
    /// Returns the values in the order of a [`crate::questions::placement::Site`].
    pub(super) fn in_order(&self) -> [Option<T>; 6] {
        [self.x_mm, self.y_mm, self.z_mm, self.yaw_deg, self.pitch_deg, self.roll_deg]
    }
}

/// How far from a place, on either side, the workpiece may stand once it is clamped; where it stands is probed, and the program compensated there.
#[derive(Debug, Clone, Copy, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AllowanceSpec {
    /// Along x and y, and along z if that is sought; 1 mm if not given.
    pub position_mm: Option<f64>,
    /// Of yaw, and of pitch and roll if they are sought; 0.5° if not given.
    pub angle_deg: Option<f64>,
}

/// Objective to be minimised.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ObjectiveSpec {
    /// Weight of each metric by name, per unit of the metric; margins and shares are maximised.
    pub weights: BTreeMap<String, f64>,
    /// Two or three metrics for which the Pareto front is computed.
    #[serde(default)]
    pub pareto: Vec<String>,
}

/// Settings of the search for the best place.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SearchSpec {
    /// Number of grid points of the sweep along each coordinate.
    pub grid: GridSpec,
    /// Number of best places of the sweep that are refined; 3 if not given.
    pub starts: Option<usize>,
    /// Largest number of iterations of each refinement; 100 if not given.
    pub max_iterations: Option<usize>,
    /// Change of the objective, as a share, below which a refinement ends; 1e-4 if not given.
    pub tolerance: Option<f64>,
    /// Whether places that cannot win are pruned before all points of the paths are evaluated; true if not given.
    pub coarse_to_fine: Option<bool>,
}

/// Number of grid points along each coordinate, both ends included.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields, default)]
#[allow(missing_docs)]
pub struct GridSpec {
    pub x: usize,
    pub y: usize,
    pub z: usize,
    pub yaw: usize,
    pub pitch: usize,
    pub roll: usize,
}

impl Default for GridSpec {
    /// Returns one grid point along each coordinate.
    fn default() -> Self {
        Self { x: 1, y: 1, z: 1, yaw: 1, pitch: 1, roll: 1 }
    }
}

/// A named place for comparison.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CandidateSpec {
    /// Its name; that of the point if not given.
    pub name: Option<String>,
    /// Named point of the machine: W is placed so that its origin is where the point that paths refer to is when P is there.
    pub point: Option<String>,
    /// Origin of W in O.
    pub origin_mm: Option<[f64; 3]>,
    /// Angle from the x axis of O to that of W about z.
    #[serde(default)]
    pub yaw_deg: f64,
    /// Pitch and roll of W, on a machine that controls these rotations: `R_OW = R_z(yaw) R_y(pitch) R_x(roll)`.
    #[serde(default)]
    pub pitch_deg: f64,
    /// See `pitch_deg`.
    #[serde(default)]
    pub roll_deg: f64,
    /// At which γ it is judged: as programmed if not given, or at the best constant one as found places are.
    #[serde(default)]
    pub gamma: GammaChoice,
}
