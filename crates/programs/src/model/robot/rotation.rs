//! Orientations as robot languages write them: A, B, C in degrees, a quaternion, or the tool axis.

use std::f64::consts::TAU;

use nalgebra::{Quaternion, Unit, UnitQuaternion, Vector3};

use crate::model::{
    Orientation,
    robot::{Component, Frames, Language, RobotFault, Target},
};

/// Lengths of quaternions and axes may differ from 1 by as much.
const NOT_UNIT: f64 = 1e-2;
/// Cosine of B below which A and C are not unique.
const LEAST_COSINE: f64 = 1e-9;

/// Returns the rotation `R_z(A) R_y(B) R_x(C)` for the angles A, B, C in degrees (KUKA's convention).
#[must_use]
pub fn rotation_of_abc([a, b, c]: [f64; 3]) -> UnitQuaternion<f64> {
    UnitQuaternion::from_euler_angles(c.to_radians(), b.to_radians(), a.to_radians())
}

/// Returns the angles A, B, C of a rotation in degrees, A and C within ±180; near B = ±90°, where they are not unique, C is `c_deg`.
#[must_use]
pub fn abc_of_rotation(rotation: &UnitQuaternion<f64>, c_deg: f64) -> [f64; 3] {
    let m = rotation.to_rotation_matrix();
    let cosine = libm::hypot(m[(0, 0)], m[(1, 0)]);
    let b = libm::atan2(-m[(2, 0)], cosine);
    let (a, c) = if cosine > LEAST_COSINE {
        (libm::atan2(m[(1, 0)], m[(0, 0)]), libm::atan2(m[(2, 1)], m[(2, 2)]))
    } else {
        // R_z(A) R_y(±90°) R_x(C) depends on A ∓ C alone.
        let c = c_deg.to_radians();
        (libm::atan2(-m[(0, 1)], m[(1, 1)]) + c * b.signum(), c)
    };
    [wrap_to_180_deg(a.to_degrees()), b.to_degrees(), wrap_to_180_deg(c.to_degrees())]
}

/// Returns the angle `degrees` less the full turns that bring it within ±180 degrees.
fn wrap_to_180_deg(degrees: f64) -> f64 {
    degrees - 360.0 * (degrees / 360.0).round()
}

/// Returns the tool orientation at `target` in the workpiece frame W: `before` if the target has no rotation; `None` if it is unknown.
/// Fails if a quaternion or axis is no unit vector, or if some of A, B, C are given near B = ±90°.
pub(crate) fn tool_orientation(
    language: Language,
    target: &Target,
    frames: &Frames,
    before: Option<Orientation>,
) -> Result<Option<Orientation>, RobotFault> {
    let numbers: [Option<f64>; 4] = std::array::from_fn(|entry| target.number(Component::Rotation(entry)));
    if numbers.iter().all(Option::is_none) {
        return Ok(before);
    }
    let platform = |in_base| Some(Orientation::Platform(frames.base.rotation * in_base * frames.tool.inverse()));
    let [a, b, c, d] = numbers.map(Option::unwrap_or_default);
    match language {
        Language::Krl | Language::Ls => {
            let [Some(_), Some(_), Some(_), _] = numbers else {
                let Some(Orientation::Platform(platform)) = before else { return Ok(None) };
                let abc_before = abc_of_rotation(&tool_frame_in_base(&platform, frames), 0.0);
                if libm::cos(abc_before[1].to_radians()).abs() < NEARLY_UPRIGHT {
                    return Err(RobotFault::PartOfOrientation);
                }
                let abc = std::array::from_fn(|entry| numbers[entry].unwrap_or(abc_before[entry]));
                return Ok(Some(Orientation::Platform(
                    frames.base.rotation * rotation_of_abc(abc) * frames.tool.inverse(),
                )));
            };
            Ok(platform(rotation_of_abc([a, b, c])))
        }
        Language::Rapid => {
            let quaternion = Quaternion::new(a, b, c, d);
            check_unit_length("quaternion", quaternion.norm())?;
            Ok(platform(UnitQuaternion::from_quaternion(quaternion)))
        }
        Language::UrScript => Ok(platform(UnitQuaternion::from_scaled_axis(Vector3::new(a, b, c)))),
        Language::Apt => {
            let axis = Vector3::new(a, b, c);
            check_unit_length("tool axis", axis.norm())?;
            Ok(Some(Orientation::ToolAxis(frames.base.rotation * Unit::new_normalize(axis).into_inner())))
        }
    }
}

/// Cosine of B below which a part of A, B, C says too little.
const NEARLY_UPRIGHT: f64 = 1e-4;

/// Checks that a quaternion or axis (`what`) has length 1 to within 1 %.
fn check_unit_length(what: &'static str, length: f64) -> Result<(), RobotFault> {
    if (length - 1.0).abs() <= NOT_UNIT { Ok(()) } else { Err(RobotFault::NotUnit { what, length }) }
}

/// Returns the orientation `R_BN` of the tool frame N in the base B from that of the platform or flange, `R_WP`.
fn tool_frame_in_base(platform: &UnitQuaternion<f64>, frames: &Frames) -> UnitQuaternion<f64> {
    frames.base.rotation.inverse() * platform * frames.tool
}

/// Returns the rotation components to write for `orientation` (W): A, B, C in degrees, a quaternion, i, j, k, or a rotation vector; of equivalent ones those
/// nearest to the components of `old`. Empty where the language cannot say it.
pub(crate) fn rotation_parts(language: Language, orientation: &Orientation, frames: &Frames, old: &Target) -> Vec<f64> {
    let number = |entry| old.number(Component::Rotation(entry)).unwrap_or_default();
    match (language, orientation) {
        (Language::Krl | Language::Ls, Orientation::Platform(platform)) => {
            abc_of_rotation(&tool_frame_in_base(platform, frames), number(2)).to_vec()
        }
        (Language::Rapid, Orientation::Platform(platform)) => {
            let q = tool_frame_in_base(platform, frames);
            let entries = [q.w, q.i, q.j, q.k];
            let along: f64 = (0..4).map(|entry| entries[entry] * number(entry)).sum();
            entries.map(|entry| if along < 0.0 { -entry } else { entry }).to_vec()
        }
        (Language::UrScript, Orientation::Platform(platform)) => {
            // Vectors along one axis that differ by full turns are the same rotation.
            let vector = tool_frame_in_base(platform, frames).scaled_axis();
            let old = Vector3::new(number(0), number(1), number(2));
            let axis =
                vector.try_normalize(LEAST_COSINE).or_else(|| old.try_normalize(LEAST_COSINE)).unwrap_or_default();
            let turns = ((old - vector).dot(&axis) / TAU).round();
            (vector + axis * (turns * TAU)).iter().copied().collect()
        }
        (Language::Apt, Orientation::ToolAxis(axis)) => {
            (frames.base.rotation.inverse() * axis).iter().copied().collect()
        }
        _ => Vec::new(),
    }
}
