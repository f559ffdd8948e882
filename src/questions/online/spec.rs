//! The table `[online]` of a study file as written, with units in its keys; checked by [`crate::questions::Study`].

use serde::Deserialize;

use crate::questions::{path::spec::LineSpec, spec::CircleSpec};

/// The table `[online]`: a path, the force sensor, and the errors of model and predicted force to compare.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OnlineSpec {
    /// Circular path. A study has a circle, a line or a file, as a path study.
    pub circle: Option<CircleSpec>,
    /// Straight path, instead of a circle or file.
    pub line: Option<LineSpec>,
    /// Path file, instead of a circle or line.
    pub file: Option<String>,
    /// Feed all along the path.
    #[serde(rename = "feed_mm_per_min")]
    pub feed: f64,
    /// Time between two commands of the controller; 1 if not given.
    pub cycle_ms: Option<f64>,
    /// Time from the force to its measured value in the controller.
    #[serde(default)]
    pub delay_ms: f64,
    /// Corner frequency of the first-order low-pass of the measured force; none if not given.
    #[serde(rename = "low_pass_Hz")]
    pub low_pass: Option<f64>,
    /// Standard deviation of each measured value.
    #[serde(rename = "noise_N", default)]
    pub noise: f64,
    /// Standard deviation of the constant error of each axis of the sensor, over seeds.
    #[serde(rename = "bias_N", default)]
    pub bias: f64,
    /// By how much the model bends too much under a force, in per cent; below 0 too little.
    #[serde(default)]
    pub model_compliance_error_percent: f64,
    /// Share of the process's chain errors that the model knows; 100 if not given.
    pub known_chain_errors_percent: Option<f64>,
    /// Standard deviations of the error of the predicted force, over seeds; from 0 to 50 if not given.
    pub force_errors_percent: Option<Vec<f64>>,
    /// Number of random seeds for each force error; 20 if not given, 256 with uncertain inputs, where each is a draw.
    pub seeds: Option<usize>,
    /// Change of the cutting force per mm of depth of cut.
    #[serde(rename = "cutting_stiffness_N_per_mm")]
    pub cutting_stiffness: Option<f64>,
}
