//! A placement study as written: raw, units in the keys, unknown keys refused. Checked by [`crate::questions::Study`].

use std::collections::BTreeMap;

use serde::Deserialize;

use crate::{machine::spec::BoxSpec, questions::spec::CircleSpec};

/// Where a workpiece should stand.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlacementStudySpec {
    /// What is cut.
    pub feature: Vec<FeatureSpec>,
    /// The room the workpiece takes in its own frame W; the box around its paths if not given.
    pub workpiece: Option<BoxSpec>,
    /// The table on which the workpiece is to stand; it may stand anywhere if not given.
    pub table: Option<TableSpec>,
    /// Boxes in O that the workpiece must stay out of.
    #[serde(default)]
    pub forbidden: Vec<ForbiddenSpec>,
    /// How far the workpiece must stay from them on every side; 5 mm.
    pub clearance_mm: Option<f64>,
    /// Smallest and largest value of each coordinate that is sought.
    #[serde(default)]
    pub bounds: OfCoordinates<[f64; 2]>,
    /// Value of each coordinate that is not.
    #[serde(default)]
    pub fixed: OfCoordinates<f64>,
    /// What is made small.
    pub objective: ObjectiveSpec,
    /// How it is sought.
    pub search: SearchSpec,
    /// Named places to compare with.
    #[serde(default)]
    pub candidate: Vec<CandidateSpec>,
}

/// A path with its process.
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
    /// How far the tool may be from its path; as its process says if not given.
    pub tolerance_mm: Option<f64>,
}

/// A rectangle in O that must hold the footprint of the workpiece. It has `min_mm` and `max_mm`, or `centre_mm` and `size_mm`.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TableSpec {
    /// Corner of least x and y.
    pub min_mm: Option<[f64; 2]>,
    /// The opposite one.
    pub max_mm: Option<[f64; 2]>,
    /// Its middle.
    pub centre_mm: Option<[f64; 2]>,
    /// Lengths of its sides.
    pub size_mm: Option<[f64; 2]>,
    /// Angle from x of O to its first side, about its middle; 0.
    pub yaw_deg: Option<f64>,
    /// z of its surface; not looked at if not given.
    pub height_mm: Option<f64>,
    /// How far the workpiece must stay from its edge; 0.
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

/// What is said of each coordinate of a place, if anything.
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
    /// In the order of a [`crate::questions::placement::Site`].
    pub(super) fn in_order(&self) -> [Option<T>; 6] {
        [self.x_mm, self.y_mm, self.z_mm, self.yaw_deg, self.pitch_deg, self.roll_deg]
    }
}

/// What is made small.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ObjectiveSpec {
    /// Weight of each metric by name, per unit of the metric; margins and shares are made large.
    pub weights: BTreeMap<String, f64>,
    /// Two or three metrics whose best compromises are wanted.
    #[serde(default)]
    pub pareto: Vec<String>,
}

/// How the best place is sought.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SearchSpec {
    /// Places of the sweep along each coordinate.
    pub grid: GridSpec,
    /// Refinements, from so many best places of the sweep; 3.
    pub starts: Option<usize>,
    /// Most iterations of each refinement; 100.
    pub max_iterations: Option<usize>,
    /// A refinement ends when the objective differs by less than this share; 1e-4.
    pub tolerance: Option<f64>,
    /// Whether places that cannot win are given up before all points of the paths are evaluated; true.
    pub coarse_to_fine: Option<bool>,
}

/// Places along each coordinate, both ends included.
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
    fn default() -> Self {
        Self { x: 1, y: 1, z: 1, yaw: 1, pitch: 1, roll: 1 }
    }
}

/// A named place.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CandidateSpec {
    /// Its name; that of the point if not given.
    pub name: Option<String>,
    /// Named point of the machine: the origin of W lies where the point that paths refer to is when P is there.
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
}
