//! Directions of the tool that a map of turns looks at.

use std::f64::consts::TAU;

use nalgebra::Vector3;

use super::spec::{ConeSpec, TurnMapSpec};
use crate::{
    input::{check::Check, error::Result},
    machine::Machine,
    spatial::{frame_about, rotation_exp},
};

/// Most directions of a map.
const MOST: usize = 64;
/// Directions around a cone if the study does not say how many.
const AROUND: usize = 8;

/// The directions from the tip to the spindle, unit vectors in O.
pub(super) fn axes(spec: &TurnMapSpec, machine: &Machine, check: &Check) -> Result<Vec<Vector3<f64>>> {
    match (&spec.tool_axes, &spec.cone) {
        (Some(_), Some(_)) => check.key("cone").fail("give one of tool_axes and cone".into()),
        (Some(given), None) => {
            let check = check.key("tool_axes");
            if given.is_empty() || given.len() > MOST {
                return check.fail(format!("must have 1 to {MOST} directions, got {}", given.len()));
            }
            given.iter().enumerate().map(|(index, axis)| direction(*axis, &check.item(index))).collect()
        }
        (None, Some(cone)) => around(cone, &check.key("cone")),
        (None, None) => Ok(vec![-(machine.home.pose.rotation * machine.tool_axes.column(2)).normalize()]),
    }
}

fn direction(given: [f64; 3], check: &Check) -> Result<Vector3<f64>> {
    let given = check.finite(given)?;
    given.try_normalize(1e-9).map_or_else(|| check.fail("has no length: expected a direction".into()), Ok)
}

fn around(cone: &ConeSpec, check: &Check) -> Result<Vec<Vector3<f64>>> {
    let about = direction(cone.about, &check.key("about"))?;
    let half = cone.half_angle_deg;
    if !(half > 0.0 && half <= 180.0) {
        return check.key("half_angle_deg").fail(format!("must be above 0 and at most 180, got {half}"));
    }
    let count = cone.around.unwrap_or(AROUND);
    if !(1..MOST).contains(&count) {
        return check.key("around").fail(format!("must be 1 to {}, got {count}", MOST - 1));
    }
    let (frame, (sin, cos)) = (frame_about(about), half.to_radians().sin_cos());
    let on_rim = |k: usize| {
        let rim = frame * Vector3::new(sin, 0.0, cos);
        rotation_exp(about * (TAU * k as f64 / count as f64)) * rim
    };
    Ok(std::iter::once(about).chain((0..count).map(on_rim)).collect())
}
