//! The table `[measurement_design]` of a study file as written, with units in its keys; checked by [`crate::questions::Study`].

use serde::Deserialize;

use crate::questions::{identification::spec::PriorSpec, placement::spec::ForbiddenSpec};

/// The table `[measurement_design]` of a study file: which measurements to choose from, and for which parameters.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MeasurementDesignSpec {
    /// Names of the parameters to identify; `*` stands for any letters but a dot.
    pub unknowns: Vec<String>,
    /// Number of measurements to choose.
    pub count: usize,
    /// Columns of readings at each candidate, those of an identification; displacements along the axes of O if not given.
    pub reads: Option<Vec<String>>,
    /// Standard deviation of length readings.
    pub std_mm: f64,
    /// Standard deviation of rotation readings.
    pub std_deg: Option<f64>,
    /// Design criterion.
    #[serde(default)]
    pub criterion: CriterionSpec,
    /// CSV file of poses and loads at which the prediction of the tool counts.
    pub tested: Option<String>,
    /// Half width of a 95 % interval that is sufficient: ln of a factor, mm, degrees.
    pub target: Option<f64>,
    /// CSV file of measurements made already.
    pub measured: Option<String>,
    /// Prior knowledge of these parameters.
    #[serde(default)]
    pub prior: Vec<PriorSpec>,
    /// CSV file of candidate poses and loads.
    pub candidates: Option<String>,
    /// Candidates spread over a region, instead of a file.
    pub candidate: Option<CandidateSpec>,
    /// Number of random choices to compare with; 200 if not given.
    pub draws: Option<usize>,
}

/// Design criterion: what the chosen measurements minimise.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CriterionSpec {
    /// Volume of the confidence region of all unknowns: D-optimal.
    #[default]
    AllNumbers,
    /// Error of the tool predicted at the poses and loads of `tested`.
    Tested,
}

/// Candidate poses spread over a region, each under each of some forces.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CandidateSpec {
    /// Number of poses.
    pub poses: usize,
    /// Forces on the tool tip, axes of O, N.
    #[serde(rename = "forces_N")]
    pub forces: Vec<[f64; 3]>,
    /// Lower corner of the box that the tool tip stays in; without it, P stays in the machine's workspace box.
    pub min_mm: Option<[f64; 3]>,
    /// Upper corner of that box.
    pub max_mm: Option<[f64; 3]>,
    /// Boxes that the tool tip stays out of.
    #[serde(default)]
    pub forbidden: Vec<ForbiddenSpec>,
    /// Branches of inverse kinematics that an arm may be on; all if not given.
    #[serde(default)]
    pub branches: Vec<String>,
}
