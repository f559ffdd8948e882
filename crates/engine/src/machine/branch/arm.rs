//! Six-axis arms with a spherical wrist: which machines are, and on which branch they stand.
//!
//! Axes 1 and 2 are perpendicular, 2 and 3 parallel, and 4, 5 and 6 meet in the wrist centre; offsets are free (those of
//! ortho-parallel arms, Brandstötter, Angerer and Hofbaur 2014). The determinant of such an arm's Jacobian is the product of three factors:
//! how far the wrist centre is ahead of axis 1, the sine of the elbow's bend and that of the wrist's. Their signs are the branch.

use nalgebra::{Rotation3, Unit, Vector2, Vector3};
use serde::Serialize;

use super::Branch;
use crate::{
    machine::{Chain, Configuration, Machine, Motion, MoveScrew},
    spatial::Pose,
};

/// An arm is taken for one of these where lengths and angles differ by no more, as shares of its characteristic length and in rad. What the closed
/// form then leaves, our own closure equations take away.
const FITS: f64 = 1e-4;
/// A length that is none, as a share of the characteristic length.
const NO_LENGTH: f64 = 1e-9;
/// A posture this near to a singularity stands on both branches that meet there: a share of the characteristic length, or a sine.
pub(super) const ON_BOTH: f64 = 1e-9;

/// Axis of a joint, a line in O axes, mm.
#[derive(Debug, Clone, Copy)]
pub(super) struct Axis {
    pub direction: Vector3<f64>,
    pub point: Vector3<f64>,
}

impl Axis {
    /// Rotation about the axis by `angle` rad.
    pub fn rotation(&self, angle: f64) -> Rotation3<f64> {
        Rotation3::from_axis_angle(&Unit::new_unchecked(self.direction), angle)
    }
}

/// How far an arm is from the three singularities between its branches.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Clearance {
    /// Distance of the wrist centre ahead of axis 1, mm; negative behind it.
    pub shoulder_mm: f64,
    /// Bend of the elbow, from where shoulder, elbow and wrist centre are in line, degrees; negative on a branch `down`.
    pub elbow_deg: f64,
    /// Bend of the wrist, from where axis 6 leads on along axis 4, degrees; negative on a branch `flip`.
    pub wrist_deg: f64,
}

/// Geometry of a six-axis arm with all its joints at zero and what carries it as at home; O axes, mm.
#[derive(Debug, Clone)]
pub(in crate::machine) struct Arm {
    /// Index of the first of its six drives.
    pub(super) first: usize,
    pub(super) axes: [Axis; 6],
    pub(super) wrist_centre: Vector3<f64>,
    /// Pose of P with all joints at zero.
    pub(super) zero: Pose,
    /// Unit vector along axis 1, away from the base.
    pub(super) up: Vector3<f64>,
    /// Unit vector across axis 1, to the front.
    pub(super) ahead: Vector3<f64>,
    /// +1 where axes 4 and 6 both lead towards the tool or both away from it, −1 otherwise.
    alignment: f64,
    /// Sense of axis 5 in which its drive counts, +1 or −1.
    wrist_sense: f64,
    scale: f64,
}

impl Arm {
    /// Recognises `machine`, assembled at home, as a six-axis arm with a spherical wrist; `None` if it is none.
    pub fn recognise(machine: &Machine) -> Option<Self> {
        let [chain] = machine.chains.as_slice() else { return None };
        let first = chain.drives.len().checked_sub(6)?;
        let is_revolute = chain.drives[first..].iter().all(|drive| drive.motion == Motion::Revolute);
        if !chain.passive.is_empty() || !is_revolute {
            return None;
        }
        let mut values = vec![0.0; chain.virtual_count];
        chain.add_joint_positions(&machine.home.drives, &mut values);
        let at_home = joint_angles(chain, first, &values);
        for drive in &chain.drives[first..] {
            values[drive.coordinate] = 0.0;
        }
        let mut screws: Vec<MoveScrew> = Vec::new();
        let zero = chain.forward(&values, &mut screws);
        let axis = |joint: usize| -> Option<Axis> {
            let coordinate = chain.drives[first + joint].coordinate;
            let twist = screws.iter().find(|screw| screw.coordinate == coordinate)?.twist;
            let direction = twist.angular.normalize();
            Some(Axis { direction, point: zero.translation - twist.linear.cross(&direction) })
        };
        let axes = [axis(0)?, axis(1)?, axis(2)?, axis(3)?, axis(4)?, axis(5)?];
        let base = chain.route.base.translation;
        let mut arm = Self::with_axes(first, axes, zero, base, machine.characteristic_length)?;
        let length = |length: f64| if length.abs() > NO_LENGTH * machine.characteristic_length { length } else { 0.0 };
        let offset = length(arm.ahead.dot(&(axes[1].point - axes[0].point)));
        // Where axis 2 meets axis 1, the front is on the side of home.
        let side = if offset == 0.0 { arm.branch_factors(&at_home)[0] } else { offset };
        if side < 0.0 {
            arm.ahead = -arm.ahead;
        }
        let forearm = sign_of(length(axes[3].direction.dot(&arm.forearm())));
        let hand = sign_of(length(axes[5].direction.dot(&(zero.translation - arm.wrist_centre))));
        arm.alignment = forearm * hand;
        arm.wrist_sense = chain.shown_sign(first + 4);
        Some(arm)
    }

    /// Arm with these `axes` and pose `zero` of P at zero joints, its base at `base` (O, mm); `None` unless its wrist is spherical.
    fn with_axes(first: usize, axes: [Axis; 6], zero: Pose, base: Vector3<f64>, scale: f64) -> Option<Self> {
        let [a1, a2, a3, a4, a5, a6] = axes.map(|axis| axis.direction);
        let wrist_centre = meeting_point(&axes[3], &axes[4])?;
        let beside = wrist_centre - axes[5].point;
        let is_arm = a1.dot(&a2).abs() < FITS
            && a2.cross(&a3).norm() < FITS
            && (beside - a6 * a6.dot(&beside)).norm() < FITS * scale
            && a4.cross(&a5).norm() > FITS
            && a5.cross(&a6).norm() > FITS;
        let height = a1.dot(&(axes[1].point - base));
        let up = if height < -NO_LENGTH * scale { -a1 } else { a1 };
        let ahead = a2.cross(&up).normalize();
        let arm = Self { first, axes, wrist_centre, zero, up, ahead, alignment: 1.0, wrist_sense: 1.0, scale };
        let shortest = arm.in_plane(arm.elbow() - axes[1].point).norm().min(arm.in_plane(arm.forearm()).norm());
        (is_arm && shortest > FITS * scale).then_some(arm)
    }

    /// Position of the elbow (axis 3) with all joints at zero, O, mm.
    pub(super) fn elbow(&self) -> Vector3<f64> {
        self.axes[2].point
    }

    /// Vector from the elbow to the wrist centre with all joints at zero, O axes, mm.
    pub(super) fn forearm(&self) -> Vector3<f64> {
        self.wrist_centre - self.elbow()
    }

    /// Vector from the shoulder (axis 2) to the elbow with all joints at zero, O axes, mm.
    pub(super) fn upper_arm(&self) -> Vector3<f64> {
        self.elbow() - self.axes[1].point
    }

    /// Unit vector in O about which "up" turns into "ahead": the direction of axes 2 and 3, or the opposite one.
    pub(super) fn across(&self) -> Vector3<f64> {
        self.up.cross(&self.ahead)
    }

    /// +1 where a positive turn about `axis` turns "up" into "ahead", −1 otherwise.
    pub(super) fn sense_across(&self, axis: &Axis) -> f64 {
        sign_of(axis.direction.dot(&self.across()))
    }

    /// Components of `vector` (O axes) along "up" and "ahead", in its unit.
    pub(super) fn in_plane(&self, vector: Vector3<f64>) -> Vector2<f64> {
        Vector2::new(self.up.dot(&vector), self.ahead.dot(&vector))
    }

    /// Bend of the wrist with joint 5 at `angle`, rad: 0 where axis 6 leads on along axis 4.
    pub(super) fn wrist_bend(&self, angle: f64) -> f64 {
        let [a4, a5] = [self.axes[3].direction, self.axes[4].direction];
        let a6 = self.axes[4].rotation(angle) * self.axes[5].direction;
        let along = a4.dot(&a6) - a5.dot(&a4) * a5.dot(&a6);
        libm::atan2(a5.dot(&a4.cross(&a6)) * self.alignment * self.wrist_sense, along * self.alignment)
    }

    /// Distances from the shoulder, elbow and wrist singularities at `joints` (rad): a share of the characteristic length, and two angles, rad.
    fn singularity_distances(&self, joints: &[f64; 6]) -> [f64; 3] {
        let turned = |vector: Vector2<f64>, axis: &Axis, angle: f64| {
            let (sin, cos) = libm::sincos(angle * self.sense_across(axis));
            Vector2::new(vector.x * cos - vector.y * sin, vector.x * sin + vector.y * cos)
        };
        let upper = self.in_plane(self.upper_arm());
        let fore = turned(self.in_plane(self.forearm()), &self.axes[2], joints[2]);
        let elbow = libm::atan2(upper.x * fore.y - upper.y * fore.x, upper.dot(&fore));
        let shoulder = self.ahead.dot(&(self.axes[1].point - self.axes[0].point));
        let shoulder = shoulder + turned(upper + fore, &self.axes[1], joints[1]).y;
        [shoulder / self.scale, elbow, self.wrist_bend(joints[4])]
    }

    /// Factors of the Jacobian's determinant at `joints` (rad), whose signs are the branch: a share of the characteristic length, sines.
    pub(super) fn branch_factors(&self, joints: &[f64; 6]) -> [f64; 3] {
        let [shoulder, elbow, wrist] = self.singularity_distances(joints);
        [shoulder, libm::sin(elbow), libm::sin(wrist)]
    }
}

/// Sign of `value`, +1 or −1.
fn sign_of(value: f64) -> f64 {
    if value < 0.0 { -1.0 } else { 1.0 }
}

/// Point where two axes meet, O, mm, halfway between them where they miss one another; `None` where they are parallel.
fn meeting_point(one: &Axis, other: &Axis) -> Option<Vector3<f64>> {
    let normal = one.direction.cross(&other.direction);
    if normal.norm() < FITS {
        return None;
    }
    let along = (other.point - one.point).cross(&other.direction).dot(&normal) / normal.norm_squared();
    let on_one = one.point + one.direction * along;
    let back = (on_one - other.point).dot(&other.direction);
    Some((on_one + other.point + other.direction * back) * 0.5)
}

/// Angles of the joints of the six drives from `first` on, at the chain coordinates `values`, rad.
pub(super) fn joint_angles(chain: &Chain, first: usize, values: &[f64]) -> [f64; 6] {
    std::array::from_fn(|joint| values[chain.drives[first + joint].coordinate])
}

impl Machine {
    /// Index of the first of the six drives of a six-axis arm with a spherical wrist; `None` for other machines.
    pub(crate) fn first_arm_drive(&self) -> Option<usize> {
        self.arm.as_ref().map(|arm| arm.first)
    }

    /// Angles of the joints of the arm at the configuration `at`, rad.
    fn arm_joints(&self, arm: &Arm, at: &Configuration) -> [f64; 6] {
        let chain = &self.chains[0];
        let mut values = vec![0.0; chain.virtual_count];
        chain.add_joint_positions(&at.drives, &mut values);
        joint_angles(chain, arm.first, &values)
    }

    /// Factors whose signs are the branch at `at`; `None` unless the machine is a six-axis arm.
    pub(super) fn branch_factors(&self, at: &Configuration) -> Option<[f64; 3]> {
        let arm = self.arm.as_ref()?;
        Some(arm.branch_factors(&self.arm_joints(arm, at)))
    }

    /// The branch on which the machine stands at `at`; `None` unless it is an arm with a spherical wrist: six revolute joints at the end of a
    /// serial chain, axes 1 and 2 perpendicular, 2 and 3 parallel, 4 to 6 through one point.
    pub fn branch_of(&self, at: &Configuration) -> Option<Branch> {
        self.branch_factors(at).map(Branch::from_signs)
    }

    /// How far the machine at `at` is from the singularities between its branches; `None` unless it is an arm with a spherical wrist.
    pub fn clearance(&self, at: &Configuration) -> Option<Clearance> {
        let arm = self.arm.as_ref()?;
        let [shoulder, elbow, wrist] = arm.singularity_distances(&self.arm_joints(arm, at));
        Some(Clearance {
            shoulder_mm: shoulder * arm.scale,
            elbow_deg: elbow.to_degrees(),
            wrist_deg: wrist.to_degrees(),
        })
    }
}
