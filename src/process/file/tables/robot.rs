//! The table `robot_program` of a process file: what robot programs do not say themselves, as written and checked.

use std::collections::BTreeMap;

use nalgebra::{Isometry3, Translation3, UnitQuaternion};
use serde::Deserialize;

use crate::{
    input::{check::Check, error::Result},
    machine::ExternalAxes,
    toolpath::robot::{CutcomPoints, RobotOptions, rotation_of_abc},
};

/// The table `robot_program`: what a robot or APT program does not say itself.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RobotSpec {
    /// A, B, C of the programmed tool frame in the platform or flange, `R_z(A) R_y(B) R_x(C)`; 0 if not given.
    pub tool_rotation_deg: Option<[f64; 3]>,
    /// Poses of bases or work objects in W, by name.
    #[serde(default)]
    pub bases: BTreeMap<String, BaseSpec>,
    /// The path columns that E1, E2, … of the program move.
    #[serde(default)]
    pub external_axes: Vec<String>,
    /// Subprograms that do not move the tool.
    #[serde(default)]
    pub calls_kept: Vec<String>,
    /// What points of APT under CUTCOM are.
    pub cutcom_points: Option<CutcomSpec>,
    /// Whether what the program says of the posture of the arm is ignored, and stays as it is.
    #[serde(default)]
    pub ignore_configuration: bool,
}

/// What points of APT under CUTCOM are, as written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CutcomSpec {
    /// The tool centre.
    ToolCentre,
    /// The contour.
    Contour,
}

/// The pose of a base or work object in W, as written.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BaseSpec {
    /// Origin of the base in W.
    pub origin_mm: [f64; 3],
    /// Angles A, B, C of the base, in the convention of `tool_rotation_deg`.
    #[serde(default)]
    pub rotation_deg: [f64; 3],
}

/// Checks the table and converts it to options for reading programs.
pub(crate) fn options(spec: &RobotSpec, is_tool_stationary: bool, check: &Check) -> Result<RobotOptions> {
    let rotation = |check: &Check, degrees: [f64; 3]| -> Result<UnitQuaternion<f64>> {
        Ok(rotation_of_abc(check.finite(degrees)?.into()))
    };
    let mut bases = BTreeMap::new();
    for (name, base) in &spec.bases {
        let check = check.key(&format!("bases.\"{name}\""));
        let origin = Translation3::from(check.key("origin_mm").finite(base.origin_mm)?);
        let orientation = rotation(&check.key("rotation_deg"), base.rotation_deg)?;
        bases.insert(name.to_ascii_lowercase(), Isometry3::from_parts(origin, orientation));
    }
    let check_axes = check.key("external_axes");
    if spec.external_axes.len() > ExternalAxes::MOST {
        return check_axes.fail(format!(
            "has {} names: at most {} are expected",
            spec.external_axes.len(),
            ExternalAxes::MOST
        ));
    }
    for name in &spec.external_axes {
        let drive = name.strip_prefix("external_");
        let drive = drive.and_then(|drive| drive.strip_suffix("_mm").or(drive.strip_suffix("_deg")));
        if drive.is_none_or(str::is_empty) {
            return check_axes
                .fail(format!("has \"{name}\": names such as external_rail_mm or external_table_deg are expected"));
        }
    }
    Ok(RobotOptions {
        tool_rotation: match spec.tool_rotation_deg {
            Some(angles) => Some(rotation(&check.key("tool_rotation_deg"), angles)?),
            None => None,
        },
        bases,
        is_tool_stationary,
        external_axes: spec.external_axes.clone(),
        calls_kept: spec.calls_kept.iter().map(|name| name.to_ascii_lowercase()).collect(),
        cutcom_points: spec.cutcom_points.map(|points| match points {
            CutcomSpec::ToolCentre => CutcomPoints::ToolCentre,
            CutcomSpec::Contour => CutcomPoints::Contour,
        }),
        ignores_configuration: spec.ignore_configuration,
    })
}
