//! A plan of measurements as written: raw, units in the keys, unknown keys refused. Checked by [`crate::questions::Study`].

use serde::Deserialize;

use crate::questions::{identification::spec::PriorSpec, placement::spec::ForbiddenSpec};

/// Which measurements tell most of some numbers of a machine.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MeasurementDesignSpec {
    /// Names of the parameters sought; `*` stands for any letters but a dot.
    pub unknowns: Vec<String>,
    /// How many measurements are to be chosen.
    pub count: usize,
    /// Columns that are read at each, those of an identification; displacements along the axes of O if not given.
    pub reads: Option<Vec<String>>,
    /// Standard deviation of a length that is read.
    pub std_mm: f64,
    /// The same of a rotation.
    pub std_deg: Option<f64>,
    /// What is made small.
    #[serde(default)]
    pub criterion: CriterionSpec,
    /// Poses and loads whose prediction counts, a CSV file.
    pub tested: Option<String>,
    /// Half a 95 % interval that is enough: ln of a factor, mm, degrees.
    pub target: Option<f64>,
    /// Measurements that have been made, a CSV file.
    pub measured: Option<String>,
    /// What is known beforehand.
    #[serde(default)]
    pub prior: Vec<PriorSpec>,
    /// Poses and loads to choose from, a CSV file.
    pub candidates: Option<String>,
    /// What to choose from, if it is not a file.
    pub candidate: Option<CandidateSpec>,
    /// Random choices to compare with; 200.
    pub draws: Option<usize>,
}

/// What is made small.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CriterionSpec {
    /// The volume of the region in which all unknowns may be: D-optimal.
    #[default]
    AllNumbers,
    /// The error by which the tool is predicted at the poses and loads of `tested`.
    Tested,
}

/// Poses spread over what the machine reaches, each with each of some forces.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CandidateSpec {
    /// How many poses.
    pub poses: usize,
    /// Forces on the tool tip, axes of O.
    #[serde(rename = "forces_N")]
    pub forces: Vec<[f64; 3]>,
    /// Corners of the box that the tool tip stays in; that of the machine holds P if they are not given.
    pub min_mm: Option<[f64; 3]>,
    /// The upper one.
    pub max_mm: Option<[f64; 3]>,
    /// Boxes that the tool tip stays out of.
    #[serde(default)]
    pub forbidden: Vec<ForbiddenSpec>,
    /// Branches on which an arm may stand; all if not given.
    #[serde(default)]
    pub branches: Vec<String>,
}
