//! The tables of cutting forces in a process file, as written.

use serde::Deserialize;

use crate::{process::ForceLaw, toolpath::TurnDirection};

/// A cutting force as written: at most one of its keys.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ForceSpec {
    /// A force that is constant in the frame of the path.
    pub path_frame: Option<PathFrameSpec>,
    /// A load tabulated over the length of the path.
    pub table: Option<TableSpec>,
    /// The mean force of a full slot, from cutting coefficients.
    pub slot_milling: Option<SlotMillingSpec>,
    /// The force of a cut with the side of an end mill.
    pub end_milling: Option<EndMillingSpec>,
    /// Thrust and torque of a twist drill.
    pub drilling: Option<DrillingSpec>,
    /// Whether the load is that of the path's force columns.
    #[serde(default)]
    pub from_path: bool,
}

/// Constant radial, tangential and axial force, eq. (17), with φ from the direction of motion.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PathFrameSpec {
    /// F_r, N.
    #[serde(rename = "radial_force_N")]
    pub radial_force: f64,
    /// F_t, N.
    #[serde(rename = "tangential_force_N")]
    pub tangential_force: f64,
    /// F_z, N.
    #[serde(rename = "axial_force_N")]
    pub axial_force: f64,
    /// `rotated` (default) or `paper_eq17`, which is no rotation: its force does not turn with the path.
    #[serde(default)]
    pub law: ForceLaw,
}

/// The table `table`: a wrench table in a file.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TableSpec {
    /// CSV file, relative to the folder of the process file.
    pub file: String,
}

/// The table `slot_milling`; see [`crate::process::cutting::SlotMilling`].
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SlotMillingSpec {
    /// K_tc.
    #[serde(rename = "tangential_cutting_N_per_mm2")]
    pub tangential_cutting: f64,
    /// K_rc.
    #[serde(rename = "radial_cutting_N_per_mm2")]
    pub radial_cutting: f64,
    /// K_ac.
    #[serde(rename = "axial_cutting_N_per_mm2")]
    pub axial_cutting: f64,
    /// K_te.
    #[serde(rename = "tangential_edge_N_per_mm", default)]
    pub tangential_edge: f64,
    /// K_re.
    #[serde(rename = "radial_edge_N_per_mm", default)]
    pub radial_edge: f64,
    /// K_ae.
    #[serde(rename = "axial_edge_N_per_mm", default)]
    pub axial_edge: f64,
    /// a.
    pub axial_depth_mm: f64,
    /// N.
    pub teeth: u32,
    /// c; from feed and spindle speed of the path if not given.
    pub feed_per_tooth_mm: Option<f64>,
    /// Which way the spindle turns, seen from the spindle.
    #[serde(default)]
    pub spindle: SpindleSpec,
}

impl SlotMillingSpec {
    /// Returns the cutting coefficients, which a slot has among its other keys, as a table of their own.
    pub(super) fn coefficients(&self) -> CoefficientsSpec {
        CoefficientsSpec {
            tangential_cutting: self.tangential_cutting,
            radial_cutting: self.radial_cutting,
            axial_cutting: self.axial_cutting,
            tangential_edge: self.tangential_edge,
            radial_edge: self.radial_edge,
            axial_edge: self.axial_edge,
        }
    }
}

/// The table `end_milling`; see [`crate::process::cutting::EndMilling`].
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EndMillingSpec {
    /// D.
    pub diameter_mm: Option<f64>,
    /// N.
    pub teeth: Option<u32>,
    /// a.
    pub axial_depth_mm: Option<f64>,
    /// b.
    pub radial_width_mm: Option<f64>,
    /// Up or down milling; not needed where the cut is as wide as the cutter.
    pub cut: Option<CutSpec>,
    /// c; from feed and spindle speed of the path if not given.
    pub feed_per_tooth_mm: Option<f64>,
    /// Which way the spindle turns, seen from the spindle.
    #[serde(default)]
    pub spindle: SpindleSpec,
    /// Whether the load is the mean or the peak of a revolution.
    #[serde(default)]
    pub load: MeanOrPeakSpec,
    /// Coefficients: these, Kienzle's law or a material.
    pub coefficients: Option<CoefficientsSpec>,
    /// Kienzle's law.
    pub kienzle: Option<KienzleSpec>,
    /// A material of `materials.toml`.
    pub material: Option<String>,
    /// Radial force as a share of the tangential one, with Kienzle's law.
    pub radial_ratio: Option<f64>,
    /// Axial force as a share of the tangential one, with Kienzle's law; 0 if not given.
    pub axial_ratio: Option<f64>,
}

/// Average cutting coefficients as written: K_c in N/mm², K_e in N/mm.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CoefficientsSpec {
    /// K_tc.
    #[serde(rename = "tangential_cutting_N_per_mm2")]
    pub tangential_cutting: f64,
    /// K_rc.
    #[serde(rename = "radial_cutting_N_per_mm2")]
    pub radial_cutting: f64,
    /// K_ac.
    #[serde(rename = "axial_cutting_N_per_mm2")]
    pub axial_cutting: f64,
    /// K_te.
    #[serde(rename = "tangential_edge_N_per_mm", default)]
    pub tangential_edge: f64,
    /// K_re.
    #[serde(rename = "radial_edge_N_per_mm", default)]
    pub radial_edge: f64,
    /// K_ae.
    #[serde(rename = "axial_edge_N_per_mm", default)]
    pub axial_edge: f64,
}

/// The coefficients of Kienzle's law as written.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct KienzleSpec {
    /// k_c1.1, N/mm².
    #[serde(rename = "specific_force_N_per_mm2")]
    pub specific_force: f64,
    /// m_c, from 0 to below 1.
    pub exponent: f64,
}

/// Up or down milling, as written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CutSpec {
    /// Conventional.
    Up,
    /// Climb.
    Down,
}

/// Which force of a revolution to use, as written.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MeanOrPeakSpec {
    /// The mean.
    #[default]
    Mean,
    /// The largest.
    Peak,
}

/// The table `drilling`; see [`crate::process::cutting::Drilling`].
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DrillingSpec {
    /// D.
    pub diameter_mm: f64,
    /// f; from feed and spindle speed of the path if not given.
    pub feed_per_rev_mm: Option<f64>,
    /// Which way the spindle turns, seen from the spindle.
    #[serde(default)]
    pub spindle: SpindleSpec,
    /// Kienzle's law of the lips: this, a material constant or a material.
    pub kienzle: Option<KienzleSpec>,
    /// The material constant K of twist drills.
    pub material_constant: Option<f64>,
    /// A material of `materials.toml`.
    pub material: Option<String>,
    /// The point angle 2 κ, with Kienzle's law; 118 if not given.
    pub point_angle_deg: Option<f64>,
    /// The thrust ratio q, with Kienzle's law; 0.5 if not given.
    pub thrust_ratio: Option<f64>,
}

/// The spindle's direction of rotation as written, seen from the spindle towards the workpiece.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SpindleSpec {
    /// M3.
    #[default]
    Clockwise,
    /// M4.
    CounterClockwise,
}

impl SpindleSpec {
    /// Converts the word of the file to a direction of rotation.
    pub(super) fn turn(self) -> TurnDirection {
        match self {
            Self::Clockwise => TurnDirection::Clockwise,
            Self::CounterClockwise => TurnDirection::CounterClockwise,
        }
    }
}
