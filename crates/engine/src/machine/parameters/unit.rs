//! Units of parameters, as keys of machine files end with them and as readers see them.

use std::fmt;

use serde::{Serialize, Serializer};

/// The unit of a parameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Unit {
    in_files: &'static str,
    shown: &'static str,
}

impl Unit {
    /// A ratio, or a component of a direction.
    pub const ONE: Unit = Unit { in_files: "", shown: "" };
    /// Lengths and positions.
    pub const MM: Unit = Unit { in_files: "mm", shown: "mm" };
    /// Angles.
    pub const DEG: Unit = Unit { in_files: "deg", shown: "°" };
    /// Masses.
    pub const KG: Unit = Unit { in_files: "kg", shown: "kg" };
    /// Gravity.
    pub const M_PER_S2: Unit = Unit { in_files: "m_per_s2", shown: "m/s²" };
    /// Forces.
    pub const N: Unit = Unit { in_files: "N", shown: "N" };
    /// Moments.
    pub const NMM: Unit = Unit { in_files: "Nmm", shown: "N·mm" };
    /// Stiffness of prismatic joints and springs.
    pub const N_PER_MM: Unit = Unit { in_files: "N_per_mm", shown: "N/mm" };
    /// Stiffness of revolute joints.
    pub const NMM_PER_RAD: Unit = Unit { in_files: "Nmm_per_rad", shown: "N·mm/rad" };
    /// Elastic constants.
    pub const N_PER_MM2: Unit = Unit { in_files: "N_per_mm2", shown: "N/mm²" };
    /// Force of a link's end by its turn, or moment by its displacement.
    pub const N_PER_RAD: Unit = Unit { in_files: "N_per_rad", shown: "N/rad" };
    /// Displacement of a link's end by a force.
    pub const MM_PER_N: Unit = Unit { in_files: "mm_per_N", shown: "mm/N" };
    /// Turn of a link's end by a force, or displacement by a moment.
    pub const RAD_PER_N: Unit = Unit { in_files: "rad_per_N", shown: "rad/N" };
    /// Turn of a link's end by a moment.
    pub const RAD_PER_NMM: Unit = Unit { in_files: "rad_per_Nmm", shown: "rad/(N·mm)" };

    /// Ending of keys and columns with this unit; empty for a plain number.
    pub fn in_files(self) -> &'static str {
        self.in_files
    }

    /// Whether it is that of a stiffness or an elastic constant, of which a zero means nothing.
    pub fn is_stiffness(self) -> bool {
        [Self::N_PER_MM, Self::NMM_PER_RAD, Self::N_PER_MM2].contains(&self)
    }

    /// Key of a field with this unit in machine files.
    pub(super) fn key(self, field: &str) -> String {
        if self.in_files.is_empty() || self.in_files == field {
            return field.into();
        }
        format!("{field}_{}", self.in_files)
    }
}

/// As readers see it.
impl fmt::Display for Unit {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(self.shown)
    }
}

impl Serialize for Unit {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.in_files)
    }
}
