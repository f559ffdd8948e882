//! How the tool stands at a point of a path.

use nalgebra::{UnitQuaternion, Vector3};

use crate::spatial::rotation_exp;

/// How the tool stands, in the axes of the workpiece frame W.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Orientation {
    /// Direction of its axis, a unit vector from its tip to the spindle. The turn about it is free.
    ToolAxis(Vector3<f64>),
    /// Orientation of the platform, or of the flange of an arm: `R_WP`.
    Platform(UnitQuaternion<f64>),
}

/// How far from its orientation the tool may stand within a written motion where orientations are corrected, rad.
pub(crate) const WRITTEN_RAD: f64 = 1e-4;

/// Sine of the angle below which two axes are parallel.
const PARALLEL: f64 = 1e-12;

impl Orientation {
    /// The angle by which the tool is turned from here to `other`, rad; 0 where one is an axis and the other is not.
    #[must_use]
    pub fn angle_to(&self, other: &Self) -> f64 {
        match (self, other) {
            (Orientation::ToolAxis(a), Orientation::ToolAxis(b)) => a.cross(b).norm().atan2(a.dot(b)),
            (Orientation::Platform(a), Orientation::Platform(b)) => a.angle_to(b),
            _ => 0.0,
        }
    }

    /// The orientation at the share `t` of the least turn from here to `other`; `other` where one is an axis and the other is not.
    #[must_use]
    pub fn towards(&self, other: &Self, t: f64) -> Self {
        match (self, other) {
            (Orientation::ToolAxis(a), Orientation::ToolAxis(b)) => {
                let turn = least_turn(*a, *b) * t;
                Orientation::ToolAxis((rotation_exp(turn) * a).normalize())
            }
            (Orientation::Platform(a), Orientation::Platform(b)) => Orientation::Platform(a.rotation_to(b).powf(t) * a),
            _ => *other,
        }
    }
}

/// The rotation vector (rad) of the least turn that takes the unit vector `a` to `b`; where they are opposite, about any axis
/// across them.
pub(crate) fn least_turn(a: Vector3<f64>, b: Vector3<f64>) -> Vector3<f64> {
    let across = a.cross(&b);
    let angle = across.norm().atan2(a.dot(&b));
    let axis = across.try_normalize(PARALLEL).or_else(|| {
        let other = if a.x.abs() < 0.5 { Vector3::x() } else { Vector3::y() };
        a.cross(&other).try_normalize(PARALLEL)
    });
    axis.map_or_else(Vector3::zeros, |axis| axis * angle)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn unit() -> impl Strategy<Value = Vector3<f64>> {
        let number = || -1.0..1.0f64;
        (number(), number(), number())
            .prop_map(|(x, y, z)| Vector3::new(x, y, z))
            .prop_filter("too short", |v| v.norm() > 0.1)
            .prop_map(|v| v.normalize())
    }

    proptest! {
        #![proptest_config(crate::cases::cases(128))]

        #[test]
        fn a_tool_turns_evenly_from_one_orientation_to_the_next(a in unit(), b in unit(), c in unit(), t in 0.0..1.0f64) {
            prop_assume!(a.dot(&b) > -0.999);
            let quaternion = |v: Vector3<f64>| Orientation::Platform(UnitQuaternion::from_scaled_axis(v * 1.5));
            let pairs = [(Orientation::ToolAxis(a), Orientation::ToolAxis(b)), (quaternion(a), quaternion(c))];
            for (from, to) in pairs {
                let between = from.towards(&to, t);
                prop_assert!((from.angle_to(&between) - t * from.angle_to(&to)).abs() < 1e-7);
                prop_assert!((between.angle_to(&to) - (1.0 - t) * from.angle_to(&to)).abs() < 1e-7);
            }
        }

        #[test]
        fn the_least_turn_leads_there(a in unit(), b in unit()) {
            prop_assert!((rotation_exp(least_turn(a, b)) * a - b).norm() < 1e-12);
            prop_assert!((rotation_exp(least_turn(a, -a)) * a + a).norm() < 1e-12);
            prop_assert_eq!(least_turn(a, a).norm() < 1e-7, true);
        }
    }
}
