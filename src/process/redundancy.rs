//! The turn of the platform about the tool's axis, which a rotating tool leaves free: whether it is sought, and within what.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// Which turn about the tool's axis the points of a path have.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum GammaChoice {
    /// The one that the path gives.
    #[default]
    AsProgrammed,
    /// The same turn from it at all points, the best there is.
    BestConstant,
    /// A γ at each point, the best there is.
    Best,
}

impl GammaChoice {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::AsProgrammed, Self::BestConstant, Self::Best];

    /// Word in files.
    #[must_use]
    pub fn label(self) -> &'static str {
        match self {
            Self::AsProgrammed => "as_programmed",
            Self::BestConstant => "best_constant",
            Self::Best => "best",
        }
    }

    /// What it is, in words.
    #[must_use]
    pub fn words(self) -> &'static str {
        match self {
            Self::AsProgrammed => "as programmed",
            Self::BestConstant => "the best that is the same at all points",
            Self::Best => "the best at each point",
        }
    }
}

/// What of the loaded tool's distance from its path counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RedundancyCost {
    /// All of it.
    #[default]
    Deflection,
    /// What is across the direction of motion: along it, the tool is only early or late.
    AcrossPath,
    /// What is across the direction of motion and the tool's axis: normal to the wall that the side of the tool leaves. All that is
    /// across the direction of motion, where that is along the tool's axis.
    AcrossSurface,
}

/// Sine of the angle below which a motion is along the tool's axis.
const ALONG_AXIS: f64 = 1e-6;

impl RedundancyCost {
    /// Word in files.
    #[must_use]
    pub fn label(self) -> &'static str {
        match self {
            Self::Deflection => "deflection",
            Self::AcrossPath => "across_path",
            Self::AcrossSurface => "across_surface",
        }
    }

    /// What counts of `error`, mm, where the tool moves along the unit vector `along` and its axis is `axis`, all in the same axes.
    #[must_use]
    pub fn of(self, error: &Vector3<f64>, along: Vector3<f64>, axis: Vector3<f64>) -> f64 {
        let across = error - along * along.dot(error);
        match self {
            Self::Deflection => error.norm(),
            Self::AcrossPath => across.norm(),
            Self::AcrossSurface => {
                let normal = along.cross(&axis).try_normalize(ALONG_AXIS);
                normal.map_or(across.norm(), |normal| normal.dot(error).abs())
            }
        }
    }

    /// What is made small, in words.
    #[must_use]
    pub fn words(self) -> &'static str {
        match self {
            Self::Deflection => "distance from the path",
            Self::AcrossPath => "distance from the path across the motion",
            Self::AcrossSurface => "distance from the wall that the side of the tool leaves",
        }
    }
}

/// Over the points of a path, what is made small.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RedundancyObjective {
    /// The root mean square.
    #[default]
    Rms,
    /// The largest; among turns that have the same, the root mean square.
    Worst,
}

/// How the turn about the tool's axis is chosen. γ is the turn from the orientation that the path gives, about z of the tool frame,
/// which points from the spindle to the tip.
#[derive(Debug, Clone, PartialEq)]
pub struct RedundancySettings {
    /// Whether it is sought.
    pub gamma: GammaChoice,
    /// What counts at a point.
    pub cost: RedundancyCost,
    /// What counts of the path.
    pub objective: RedundancyObjective,
    /// Between neighbouring turns of the lattice, degrees.
    pub step_deg: f64,
    /// Least and largest γ, degrees.
    pub range_deg: [f64; 2],
    /// Most change of γ per length of the path, degrees per mm.
    pub max_step_deg_per_mm: f64,
    /// Least inverse condition number of the Jacobian, see [`Machine::conditioning`](crate::machine::Machine::conditioning).
    pub min_singularity_distance: f64,
    /// Least distance of each drive and joint from the ends of its travel, mm or degrees: room for corrections.
    pub travel_margin: f64,
    /// Fastest motion of each drive at the programmed feed, degrees per second; none if empty.
    pub speed_limits_deg_per_s: Vec<f64>,
}

impl Default for RedundancySettings {
    fn default() -> Self {
        Self {
            gamma: GammaChoice::AsProgrammed,
            cost: RedundancyCost::Deflection,
            objective: RedundancyObjective::Rms,
            step_deg: 5.0,
            range_deg: [-180.0, 180.0],
            max_step_deg_per_mm: 5.0,
            min_singularity_distance: 0.01,
            travel_margin: 0.5,
            speed_limits_deg_per_s: Vec::new(),
        }
    }
}

impl RedundancySettings {
    /// Whether another turn than that of the path is sought.
    #[must_use]
    pub fn is_sought(&self) -> bool {
        self.gamma != GammaChoice::AsProgrammed
    }
}
