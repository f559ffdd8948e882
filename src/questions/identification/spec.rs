//! An identification as written: raw, units in the keys, unknown keys refused. Checked by [`crate::questions::Study`].

use serde::Deserialize;

/// Which numbers of a machine are sought from which measurements.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct IdentificationSpec {
    /// The measurements, a CSV file relative to the study's folder.
    pub data: String,
    /// Names of the parameters sought; `*` stands for any letters but a dot.
    pub unknowns: Vec<String>,
    /// What is known of them beforehand.
    #[serde(default)]
    pub prior: Vec<PriorSpec>,
    /// Standard deviation of measured lengths where the file does not say it; estimated from the scatter if not given.
    pub std_mm: Option<f64>,
    /// The same of measured rotations.
    pub std_deg: Option<f64>,
    /// How much measurements count that lie far off.
    #[serde(default)]
    pub loss: LossSpec,
    /// Parts that the measurements are divided into, each predicted from the others; 5 if not given.
    pub folds: Option<usize>,
    /// Whether intervals are sought by the profile of the likelihood as well; if not given, for up to 20 unknowns.
    pub profile: Option<bool>,
    /// Other sets of unknowns, compared by how well they predict what they were not fitted to.
    #[serde(default)]
    pub alternative: Vec<AlternativeSpec>,
}

/// What is known of a parameter beforehand.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PriorSpec {
    /// Its name, one of the unknowns.
    pub parameter: String,
    /// Its value, in the unit of the machine file; that of the machine if not given.
    pub value: Option<f64>,
    /// Standard deviation of that, in the same unit.
    pub std: f64,
}

/// How much measurements count that lie far off.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LossSpec {
    /// By their square.
    #[default]
    Squares,
    /// By their size from 1.345 standard deviations on.
    Huber,
    /// By its logarithm, with 2.385 standard deviations as the unit.
    Cauchy,
}

/// Another set of unknowns.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AlternativeSpec {
    /// What it is called.
    pub name: String,
    /// Names of its parameters, as `unknowns`.
    pub unknowns: Vec<String>,
}
