//! The redundancy angle γ: the rotation of the platform about the tool's axis, which a rotating tool leaves free; how it is chosen.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use crate::FOR_PAGES;

/// How the redundancy angle γ of the points of a path is chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum GammaChoice {
    /// The orientation that the path gives.
    #[default]
    AsProgrammed,
    /// The best γ that is the same at all points.
    BestConstant,
    /// The best γ at each point.
    Best,
}

impl GammaChoice {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::AsProgrammed, Self::BestConstant, Self::Best];

    /// Returns the choice's word in files.
    #[must_use]
    pub fn label(self) -> &'static str {
        match self {
            Self::AsProgrammed => "as_programmed",
            Self::BestConstant => "best_constant",
            Self::Best => "best",
        }
    }

    /// Describes the choice in words.
    #[must_use]
    pub fn text(self) -> &'static str {
        match self {
            Self::AsProgrammed => "as programmed",
            Self::BestConstant => "the best that is the same at all points",
            Self::Best => "the best at each point",
        }
    }
}

/// Which component of the loaded tool's deviation from its path counts as the cost of γ.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RedundancyCost {
    /// The whole deviation.
    #[default]
    Deflection,
    /// The component across the direction of motion: along it, the tool is only early or late.
    AcrossPath,
    /// The component across the direction of motion and the tool's axis, normal to the wall that the side of the tool leaves; where the
    /// motion is along the tool's axis, the whole component across it.
    AcrossSurface,
}

/// Sine of the angle below which a motion is along the tool's axis.
const ALONG_AXIS: f64 = 1e-6;

impl RedundancyCost {
    /// Returns the cost's word in files.
    #[must_use]
    pub fn label(self) -> &'static str {
        match self {
            Self::Deflection => "deflection",
            Self::AcrossPath => "across_path",
            Self::AcrossSurface => "across_surface",
        }
    }

    /// Returns the part of the position error `error` that counts as cost, mm, for a motion along the unit vector `along` with the tool
    /// axis `axis`, all in the same axes.
    #[must_use]
    pub fn deviation(self, error: &Vector3<f64>, along: Vector3<f64>, axis: Vector3<f64>) -> f64 {
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

    /// Describes in words what is minimised.
    #[must_use]
    pub fn text(self) -> &'static str {
        match self {
            Self::Deflection => "distance from the path",
            Self::AcrossPath => "distance from the path across the motion",
            Self::AcrossSurface => "distance from the wall that the side of the tool leaves",
        }
    }
}

/// Which statistic of the cost over the points of a path is minimised.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RedundancyObjective {
    /// The root mean square.
    #[default]
    Rms,
    /// The largest; among choices with the same largest, the root mean square.
    Worst,
}

/// The settings for choosing the redundancy angle γ, the rotation from the orientation that the path gives, about z of the tool
/// frame, which points from the spindle to the tip.
#[derive(Debug, Clone, PartialEq)]
pub struct RedundancySettings {
    /// How γ is chosen.
    pub gamma: GammaChoice,
    /// The cost at a point.
    pub cost: RedundancyCost,
    /// The statistic of the cost over the path.
    pub objective: RedundancyObjective,
    /// Step between neighbouring angles of the search lattice, degrees.
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
    /// γ as programmed, and the defaults of process files for a search.
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
    /// Whether γ is searched for, not taken from the path; never on pages, which are small and have no threads for the search.
    #[must_use]
    pub fn is_sought(&self) -> bool {
        !FOR_PAGES && self.gamma != GammaChoice::AsProgrammed
    }
}
