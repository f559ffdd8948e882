//! The table `[identification]` of a study file as written, with units in its keys; checked by [`crate::questions::Study`].

use serde::Deserialize;

/// The table `[identification]` of a study file: which parameters to identify from which measurements.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct IdentificationSpec {
    /// Measurements: a CSV file relative to the study's folder.
    pub data: String,
    /// Names of the parameters to identify; `*` stands for any letters but a dot.
    pub unknowns: Vec<String>,
    /// Prior knowledge of these parameters.
    #[serde(default)]
    pub prior: Vec<PriorSpec>,
    /// Standard deviation of measured lengths where the file does not say it; estimated from the scatter if not given.
    pub std_mm: Option<f64>,
    /// Standard deviation of measured rotations where the file does not say it.
    pub std_deg: Option<f64>,
    /// Loss function, which says how much outliers count.
    #[serde(default)]
    pub loss: LossSpec,
    /// Number of folds in cross-validation, of whole poses; 5 if not given.
    pub folds: Option<usize>,
    /// Whether intervals are computed from the profile likelihood as well; if not given, for up to 20 unknowns.
    pub profile: Option<bool>,
    /// Other sets of unknowns, compared by how well they predict in cross-validation.
    #[serde(default)]
    pub alternative: Vec<AlternativeSpec>,
}

/// Prior knowledge of a parameter: a value and its standard deviation.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PriorSpec {
    /// Name of the parameter, one of the unknowns.
    pub parameter: String,
    /// Expected value, in the unit of the machine file; that of the machine if not given.
    pub value: Option<f64>,
    /// Standard deviation of the value, in the same unit.
    pub std: f64,
}

/// Loss function of residuals: how much outliers count.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LossSpec {
    /// Least squares: half the square of the residual.
    #[default]
    Squares,
    /// Huber's loss: linear in the residual from 1.345 standard deviations on.
    Huber,
    /// Cauchy's loss: logarithmic in the squared residual, with 2.385 standard deviations as its scale.
    Cauchy,
}

/// Another set of unknowns, to compare its predictions.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AlternativeSpec {
    /// Name of the set.
    pub name: String,
    /// Names of its parameters, with patterns as in `unknowns` of the study.
    pub unknowns: Vec<String>,
}
