//! A machine as lines in space: what a drawing of it needs, and nothing of its stiffness.

use serde::{Deserialize, Serialize};

/// Positions in O, mm, joined in order.
pub type Polyline = Vec<[f64; 3]>;

/// The lines of a machine in one configuration. Configurations of the same machine give the same lines, point by point.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Skeleton {
    /// One per chain.
    pub chains: Vec<ChainSkeleton>,
    /// P, mm.
    pub platform_mm: [f64; 3],
    /// Unit vectors of the platform's axes.
    pub platform_axes: [[f64; 3]; 3],
    /// T, mm.
    pub tool_tip_mm: [f64; 3],
    /// Mass that moves with P.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub platform_mass: Option<MassMark>,
}

impl Skeleton {
    /// Springs between points of all chains, chain after chain.
    pub fn springs(&self) -> impl Iterator<Item = &Polyline> {
        self.chains.iter().flat_map(|chain| &chain.springs)
    }

    /// Masses of all chains, that of the platform last.
    pub fn masses(&self) -> impl Iterator<Item = &MassMark> {
        self.chains.iter().flat_map(|chain| &chain.masses).chain(&self.platform_mass)
    }
}

/// A body in one configuration, as a drawing needs it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BodyOutline {
    /// Its name.
    pub name: String,
    /// Whether it moves with the machine; otherwise it stands, or moves with the workpiece.
    pub is_moving: bool,
    /// For each of its convex shapes points in O, mm, whose hull it nearly is.
    pub shapes_mm: Vec<Polyline>,
}

/// The lines of one chain, from base to platform.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ChainSkeleton {
    /// Its name.
    pub name: String,
    /// Rigid and elastic lengths; the way of a prismatic joint is not among them.
    pub links: Vec<Polyline>,
    /// Its joints.
    pub joints: Vec<JointMark>,
    /// Its springs between points, from end to end.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub springs: Vec<Polyline>,
    /// Its masses.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub masses: Vec<MassMark>,
}

/// A mass of a chain.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MassMark {
    /// Where its centre is, mm.
    pub position_mm: [f64; 3],
    /// Mass, kg.
    pub kilograms: f64,
}

/// A joint of a chain.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct JointMark {
    /// Its name.
    pub name: String,
    /// Whether it is driven.
    pub is_drive: bool,
    /// Whether it slides; otherwise it rotates.
    pub slides: bool,
    /// Where it stands, mm.
    pub position_mm: [f64; 3],
    /// Unit vector along or about which it moves.
    pub axis: [f64; 3],
    /// Coordinate, mm or degrees; of a drive, what it shows.
    pub value: f64,
    /// Smallest and largest coordinate, mm or degrees, where the machine has limits.
    pub limits: Option<[f64; 2]>,
}
