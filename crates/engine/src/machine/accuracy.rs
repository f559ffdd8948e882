//! How accurate a machine is without load: what its maker or a measurement says, each number by itself, as none follows from another.

use serde::Deserialize;

use super::{
    Grade,
    spec::{AccuracySpec, StatedSpec},
};
use crate::input::{check::Check, error::Result};

/// Standard deviations along an axis in a repeatability RP (ISO 9283): the mean of distances that are normally distributed alike along three axes, 2 √(2/π), and
/// three times their standard deviation, √(3 − 8/π).
pub const RP_FACTOR: f64 = 3.616_1;
/// Standard deviations along an axis within which 95 % of such distances are: what AP and AT of a few poses are taken as.
pub const ACCURACY_FACTOR: f64 = 2.795_5;

/// Where an accuracy is measured from.
#[derive(Debug, Clone, Copy, Default, Deserialize, PartialEq, Eq)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum AccuracyFrame {
    /// The base of the machine: geometric errors are in it.
    #[default]
    Base,
    /// A frame that is taught at the part.
    Part,
}

/// What is stated of a machine without load; `None` is not known.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Accuracy {
    /// Pose accuracy AP: how far the mean attained pose is from the commanded one.
    pub pose: Option<Stated>,
    /// Pose repeatability RP: how far attained poses are from their mean.
    pub repeatability: Option<Stated>,
    /// Path accuracy AT: how far the mean attained path is from the commanded one, at a speed.
    pub path: Option<Stated>,
}

/// A stated distance.
#[derive(Debug, Clone, PartialEq)]
pub struct Stated {
    /// The distance, mm.
    pub mm: f64,
    /// Standard deviation along each axis, mm.
    pub axis_std_mm: f64,
    /// How far it may be trusted.
    pub grade: Grade,
    /// Who says so.
    pub source: String,
    /// Speed at which it holds, mm/s; `None` where that is not said.
    pub speed_mm_per_s: Option<f64>,
    /// Payload with which it holds, kg; `None` where that is not said.
    pub payload_kg: Option<f64>,
    /// Where it is measured from.
    pub frame: AccuracyFrame,
}

impl Accuracy {
    /// What commands are off by along a path: AT or AP, of both the larger, never their sum; `None` if neither is known.
    pub fn systematic(&self) -> Option<&Stated> {
        let stated = self.path.iter().chain(&self.pose);
        stated.max_by(|one, other| one.axis_std_mm.total_cmp(&other.axis_std_mm))
    }

    /// Whether geometric errors are in [`Self::systematic`].
    pub fn has_geometry(&self) -> bool {
        self.systematic().is_some_and(|own| own.frame == AccuracyFrame::Base)
    }
}

/// Checks the table `accuracy` at `check`.
pub(super) fn resolve(spec: Option<&AccuracySpec>, check: &Check) -> Result<Accuracy> {
    let Some(spec) = spec else { return Ok(Accuracy::default()) };
    let stated = |key: &str, spec: &Option<StatedSpec>, factor: f64| -> Result<Option<Stated>> {
        let Some(spec) = spec else { return Ok(None) };
        let check = check.key(key);
        let mm = check.key("mm").positive(spec.mm)?;
        let factor = check.key("coverage_factor").optional_positive(spec.coverage_factor)?.unwrap_or(factor);
        Ok(Some(Stated {
            mm,
            axis_std_mm: mm / factor,
            grade: spec.grade,
            source: spec.source.clone(),
            speed_mm_per_s: check.key("speed_mm_per_s").optional_positive(spec.speed_mm_per_s)?,
            payload_kg: spec.payload_kg.map(|own| check.key("payload_kg").not_negative(own)).transpose()?,
            frame: spec.frame,
        }))
    };
    if spec.path.as_ref().is_some_and(|own| own.speed_mm_per_s.is_none()) {
        return check
            .key("path.speed_mm_per_s")
            .fail("missing: expected the speed at which this path accuracy (AT) holds".into());
    }
    Ok(Accuracy {
        pose: stated("pose", &spec.pose, ACCURACY_FACTOR)?,
        repeatability: stated("repeatability", &spec.repeatability, RP_FACTOR)?,
        path: stated("path", &spec.path, ACCURACY_FACTOR)?,
    })
}
