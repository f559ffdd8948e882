//! What a program of poses does not say itself: where its bases stand, how its tool is turned, what its external axes
//! are.

use std::collections::BTreeMap;

use nalgebra::{Isometry3, UnitQuaternion};

/// What a program of poses does not say itself.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct RobotOptions {
    /// Orientation of the frame of the tool, as the program has it, in the platform or flange: `R_PN`. Of a tool that
    /// the program defines itself, its own counts.
    pub tool_rotation: UnitQuaternion<f64>,
    /// Poses in the workpiece frame W, mm, of bases or work objects by their names, small letters: `base_data[3]`,
    /// `wobj1`; `world` is the frame in which the program itself says where its bases are.
    pub bases: BTreeMap<String, Isometry3<f64>>,
    /// What the external axes E1, E2, … of the program move, as columns of a path name it: `external_rail_mm`. Those
    /// that are not named must stand still.
    pub external_axes: Vec<String>,
    /// Subprograms, by names in small letters, that do not move the tool.
    pub calls_kept: Vec<String>,
}

impl RobotOptions {
    /// The name under which `bases` has the frame in which a program says where its bases are.
    pub const WORLD: &'static str = "world";
}
