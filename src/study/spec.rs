//! A study file as written: raw, units in the keys, unknown keys refused. Checked by [`super::Study`].

use serde::Deserialize;

use crate::{
    process::{
        ForceLaw,
        file::{chain_errors::ChainErrorSpec, spec::CompensateSpec},
    },
    study::{
        placement::spec::PlacementStudySpec, superposition::spec::SuperpositionSpec, validation::spec::ValidationSpec,
    },
};

/// The whole file.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StudySpec {
    /// Version of the file format; 1.
    pub schema: u32,
    /// What the study is to answer, in one sentence.
    pub question: String,
    /// A built-in machine, or a machine file relative to the study's folder.
    pub machine: String,
    /// The cutting force of a workspace map or superposition study.
    pub milling: Option<MillingSpec>,
    /// Manufacturing and assembly errors of a workspace map or superposition study; chains not named are
    /// nominal.
    #[serde(default)]
    pub chain_error: Vec<ChainErrorSpec>,
    /// Deflection and corrections on a grid over the workspace. A study has exactly one of this and the
    /// following.
    pub workspace_map: Option<WorkspaceMapSpec>,
    /// Deflection and corrections along a path.
    pub path: Option<PathSpec>,
    /// Where a workpiece should stand.
    pub placement: Option<PlacementStudySpec>,
    /// Quoted numbers beside ours.
    pub validation: Option<ValidationSpec>,
    /// Whether displacements by single sources may be added.
    pub superposition: Option<SuperpositionSpec>,
}

/// A path and its process.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PathSpec {
    /// Process file, relative to the study's folder: placement, cutting force, chain errors.
    pub process: String,
    /// A full circle in the xy-plane. A path has this, `line` or `file`.
    pub circle: Option<CircleSpec>,
    /// A straight line. A path has this, `circle` or `file`.
    pub line: Option<LineSpec>,
    /// A program, relative to the study's folder. A path has this, `circle` or `line`.
    pub file: Option<String>,
    /// Methods compared, by name; all of them if not given.
    pub methods: Option<Vec<String>>,
}

/// A straight line in the workpiece frame, split as the process says.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LineSpec {
    /// First point.
    pub start_mm: [f64; 3],
    /// Last point.
    pub end_mm: [f64; 3],
}

/// A full circle in the xy-plane of the workpiece, counter-clockwise.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CircleSpec {
    /// Centre; a circle has this or `centre_point`.
    pub centre_mm: Option<[f64; 3]>,
    /// Named point of the machine as the centre.
    pub centre_point: Option<String>,
    /// Diameter.
    pub diameter_mm: f64,
    /// Points along it, both ends included.
    pub points: usize,
}

/// Groove milling, eqs. (16) and (17), in the frame of the tool: see [`crate::process::MillingForce`].
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MillingSpec {
    /// F_r.
    #[serde(rename = "radial_force_N")]
    pub radial_force: f64,
    /// F_t.
    #[serde(rename = "tangential_force_N")]
    pub tangential_force: f64,
    /// F_z.
    #[serde(rename = "axial_force_N")]
    pub axial_force: f64,
    /// `rotated` (default) or `printed`.
    #[serde(default)]
    pub law: ForceLaw,
    /// Step between tool angles over one turn; 10° if not given.
    #[serde(default = "default_phi_step")]
    pub phi_step_deg: f64,
}

fn default_phi_step() -> f64 {
    10.0
}

pub(super) fn default_grid() -> [usize; 3] {
    [11; 3]
}

/// A grid over the workspace box.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WorkspaceMapSpec {
    /// Number of grid points along x, y, z, both ends included; 11 × 11 × 11 if not given.
    #[serde(default = "default_grid")]
    pub grid: [usize; 3],
    /// Lower corner; the machine's workspace if not given.
    pub min_mm: Option<[f64; 3]>,
    /// Upper corner; the machine's workspace if not given.
    pub max_mm: Option<[f64; 3]>,
    /// What compensation puts right.
    #[serde(default)]
    pub compensate: CompensateSpec,
    /// Heights of the slices drawn; the grid plane nearest to each is shown.
    pub slices_z_mm: Vec<f64>,
}
