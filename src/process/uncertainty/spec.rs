//! The table `[uncertainty]` as written, before it is checked: units in the keys, unknown keys refused.

use serde::Deserialize;

/// What is not known exactly of a machine and of the force on its tool.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct UncertaintySpec {
    /// Whether parameters of the machine that are not named here vary as its file says, as they do if nothing is given.
    pub machine: Option<MachineUncertaintySpec>,
    /// File with the covariance of identified parameters, relative to the study's folder.
    pub covariance: Option<String>,
    /// Parameters of the machine, by name.
    #[serde(default)]
    pub parameter: Vec<ParameterUncertaintySpec>,
    /// Errors of chains: tolerances of manufacturing and assembly.
    #[serde(default)]
    pub chain_error: Vec<ChainErrorToleranceSpec>,
    /// The process; exact if not given.
    pub process: Option<ProcessUncertaintySpec>,
    /// What the model leaves out; as the machine is known if not given.
    pub model: Option<ModelUncertaintySpec>,
    /// Number from which the draws are made; 0 if not given.
    #[serde(default)]
    pub seed: u32,
}

/// Source of the spread of machine parameters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MachineUncertaintySpec {
    /// Intervals of `[[provenance]]`, and where a stiffness or mass has none, a default by its grade.
    Provenance,
    /// What is not named is taken as exact.
    Exact,
}

/// The distribution of a quantity; exactly one key.
#[derive(Debug, Clone, Copy, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SpreadSpec {
    /// Standard deviation, in the unit of the quantity.
    pub std: Option<f64>,
    /// Standard deviation over the nominal value.
    pub relative_std: Option<f64>,
    /// Interval that holds 95 %, in the unit of the quantity.
    pub interval_95: Option<[f64; 2]>,
    /// Interval with equal probability everywhere, in the unit of the quantity.
    pub uniform: Option<[f64; 2]>,
}

/// The distribution of parameters of the machine.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ParameterUncertaintySpec {
    /// Name of a parameter, in which `*` stands for any letters but a dot.
    pub name: String,
    /// Whether chains that are mounted several times have the same value; each mounting varies by itself if not.
    #[serde(default)]
    pub shared: bool,
    /// As in [`SpreadSpec`].
    pub std: Option<f64>,
    /// As in [`SpreadSpec`].
    pub relative_std: Option<f64>,
    /// As in [`SpreadSpec`].
    pub interval_95: Option<[f64; 2]>,
    /// As in [`SpreadSpec`].
    pub uniform: Option<[f64; 2]>,
}

/// Tolerances of the errors of chains; each component varies by itself.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ChainErrorToleranceSpec {
    /// Name of the chain, in which `*` stands for any letters.
    pub chain: String,
    /// Turn of the whole chain about the axis of its first drive.
    pub turn_about_drive_axis_deg: Option<SpreadSpec>,
    /// Displacement of the chain's first frame, along each of its axes.
    pub base_translation_mm: Option<SpreadSpec>,
    /// Rotation vector of the chain's first frame, about each of its axes.
    pub base_rotation_deg: Option<SpreadSpec>,
    /// Displacement of the chain's last frame, along each of its axes.
    pub end_translation_mm: Option<SpreadSpec>,
    /// Rotation vector of the chain's last frame, about each of its axes.
    pub end_rotation_deg: Option<SpreadSpec>,
    /// Zero-point error of each drive of the chain.
    pub drive_offsets_mm_or_deg: Option<SpreadSpec>,
}

/// What the model of the machine leaves out.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ModelUncertaintySpec {
    /// Root mean square of what is wrong of a displacement by the cutting force, over its length.
    pub relative_std: f64,
}

/// Standard deviations of the components of the cutting force over their values; a component without one is as well known as the whole.
#[derive(Debug, Clone, Copy, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ForceComponentsSpec {
    /// Tangential force, or its coefficients.
    pub tangential: Option<f64>,
    /// Radial force, or its coefficients.
    pub radial: Option<f64>,
    /// Axial force, or its coefficients.
    pub axial: Option<f64>,
}

/// What is not known of the process.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ProcessUncertaintySpec {
    /// Standard deviation of the cutting force over its value, the same for all of it at once; exact if not given.
    pub force_relative_std: Option<f64>,
    /// Standard deviations of the components of the cutting force over their values, each by itself; all vary together if not given.
    pub force_component_relative_std: Option<ForceComponentsSpec>,
    /// Share by which the force of a worn tool may be above that of a sharp one, for which the nominal force holds; tools stay sharp if not given.
    pub wear_force_increase: Option<f64>,
    /// Whether force and wear of each tool of the program vary by themselves; one factor for the whole program if not.
    #[serde(default)]
    pub force_per_tool: bool,
    /// Error of the tool's length; exact if not given.
    pub tool_length_mm: Option<SpreadSpec>,
    /// Error of where the workpiece stands, along each of the base's axes; exact if not given.
    pub workpiece_position_mm: Option<SpreadSpec>,
    /// Error of how the workpiece is turned about its origin: rotation vector, about each of the base's axes; exact if not given.
    pub workpiece_rotation_deg: Option<SpreadSpec>,
}
