//! What bends between P and the tool tip, from a machine file as written.

use nalgebra::{Matrix3, Matrix6};

use super::elastic_constants;
use crate::{
    input::{check::Check, error::Result},
    machine::{
        section::{Section, beam_stiffness},
        spec::{CutterSpec, MachineSpec},
    },
};

/// Compliance at T, in its axes; `None` without a tool that bends.
pub(super) fn compliance(spec: &MachineSpec, check: &Check) -> Result<Option<Box<Matrix6<f64>>>> {
    let Some(tool) = &spec.platform.tool else { return Ok(None) };
    let given = tool.compliance.as_ref().map(|rows| check.key("compliance_mm_rad_N").positive_definite(rows));
    let cutter = tool.cutter.as_ref().map(|cutter| cantilever(cutter, spec, &check.key("cutter")));
    match (given.transpose()?, cutter.transpose()?) {
        (Some(given), Some(cutter)) => Ok(Some(Box::new(given + cutter))),
        (Some(one), None) | (None, Some(one)) => Ok(Some(Box::new(one))),
        (None, None) => check.fail("give compliance_mm_rad_N, cutter or both".into()),
    }
}

/// Compliance of the end of a round cantilever along z.
fn cantilever(cutter: &CutterSpec, spec: &MachineSpec, check: &Check) -> Result<Matrix6<f64>> {
    let diameter = check.key("diameter_mm").positive(cutter.diameter_mm)?;
    let length = check.key("stick_out_mm").positive(cutter.stick_out_mm)?;
    let material = match spec.material.get(&cutter.material) {
        Some(material) => elastic_constants(&cutter.material, material, &check.root())?,
        None => {
            let known = spec.material.keys().map(String::as_str).collect::<Vec<_>>().join(", ");
            let known = if known.is_empty() { "none".into() } else { known };
            let problem = format!("no material is called \"{}\"; there are: {known}", cutter.material);
            return check.key("material").fail(problem);
        }
    };
    let stiffness = beam_stiffness(&Section::Round { diameter }, &material, length);
    let Some(along_x) = stiffness.cholesky().map(|factor| factor.inverse()) else {
        return check.fail("has no stiffness in some direction, by these dimensions".into());
    };
    // From x along the beam to z along the tool.
    let axes = Matrix3::new(0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0);
    let mut turn = Matrix6::zeros();
    turn.fixed_view_mut::<3, 3>(0, 0).copy_from(&axes);
    turn.fixed_view_mut::<3, 3>(3, 3).copy_from(&axes);
    Ok(turn * along_x * turn.transpose())
}
