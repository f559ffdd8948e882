//! A point of the platform tracked to a position, on machines with a parasitic rotation of the platform.
//!
//! Where the drives do not control all rotations, the platform may turn as it moves: a Tricept tilts, an arm with a free turn
//! has the orientation that leaves its drives nearest to home. A point beside P then moves by more than P does, and where P has
//! to stand for it is sought: `p + R(p) r` is the position wanted, along the axes that the drives control.

use nalgebra::{Matrix3, Vector3};

use super::{Configuration, Machine, Unreachable};
use crate::spatial::Pose;

/// A distance below this share of the machine's characteristic length is none.
const MET: f64 = 1e-13;
/// A distance above this share of the machine's characteristic length is too much where the search ends.
const MISSED: f64 = 1e-9;
/// Places of P tried.
const MAX_STEPS: usize = 40;
/// How far the machine is moved to see whether its platform turns, as shares of its characteristic length, and the direction.
const TRIALS: [f64; 4] = [0.02, -0.02, 0.005, -0.005];
const TRIAL_WAY: [f64; 3] = [0.61, -0.52, 0.43];

impl Machine {
    /// Whether rotations of the platform that the drives do not control change as it moves, seen at home and beside it.
    pub(super) fn rotates_parasitically(&self) -> bool {
        let is_still = |at: &Configuration| self.uncontrolled_turn(at) <= super::mobility::MOVES;
        if !is_still(&self.home) {
            return true;
        }
        let beside = TRIALS.iter().find_map(|share| {
            let way = Vector3::from(TRIAL_WAY) * (share * self.characteristic_length);
            let asked = self.controllable_position(self.home.pose.translation + way);
            self.unlimited_inverse_kinematics_from(&self.home, &self.pose_at(asked)).ok()
        });
        beside.is_some_and(|at| !is_still(&at))
    }

    /// Inverse kinematics of `point` (platform axes from P, mm) at where it is when P stands at `asked`, as far as the drives
    /// control its translations; the others of P stay where they are at home. Rotations that are controlled are those of
    /// `asked`, the others follow. The search begins at `near`.
    ///
    /// # Errors
    /// A place of P on the way that cannot be reached, or [`Unreachable::Turned`].
    pub fn track(&self, point: Vector3<f64>, asked: &Pose, near: &Configuration) -> Result<Configuration, Unreachable> {
        let target = asked.transform(point);
        let mut at = near.clone();
        let mut place = self.controllable_position(target - at.pose.rotation * point);
        // What the place has to change by per change of the point: without turning, the same (Broyden's method).
        let mut inverse = Matrix3::identity();
        let mut last: Option<(Vector3<f64>, Vector3<f64>)> = None;
        let (mut best, mut least) = (None, f64::INFINITY);
        for _ in 0..MAX_STEPS {
            let pose = Pose { translation: place, ..*asked };
            at = self.inverse_kinematics_from(&at, &pose).or_else(|_| self.inverse_kinematics(&pose))?;
            let reached = Pose { translation: place, ..at.pose }.transform(point) - target;
            let missed = Vector3::from_fn(|i, _| if self.controls_translation(i) { reached[i] } else { 0.0 });
            let distance = missed.norm();
            if distance < least {
                (best, least) = (Some(at.clone()), distance);
            } else if least <= MISSED * self.characteristic_length {
                break;
            }
            if distance <= MET * self.characteristic_length {
                break;
            }
            if let Some((step, before)) = last {
                let change = missed - before;
                let row = step.transpose() * inverse;
                let along = (row * change)[0];
                if along.abs() > f64::EPSILON * step.norm_squared() {
                    inverse += (step - inverse * change) * row / along;
                }
            }
            let step = -(inverse * missed);
            last = Some((step, missed));
            place += step;
        }
        match best {
            Some(at) if least <= MISSED * self.characteristic_length => Ok(at),
            _ => Err(Unreachable::Turned { beside_mm: least }),
        }
    }

    /// Checks that the tool tip at `at`, which meets the pose `asked` as far as the drives control, is where that pose has it.
    ///
    /// # Errors
    /// [`Unreachable::Uncontrolled`] if P is off in an uncontrolled direction, [`Unreachable::Turned`] if the rotation takes the tip away.
    pub fn check_tracked(&self, asked: &Pose, at: &Configuration) -> Result<(), Unreachable> {
        self.check_uncontrolled(asked.translation, at)?;
        let beside_mm = ((at.pose.rotation - asked.rotation) * self.tool_tip).norm();
        if beside_mm > super::task_space::SAME_PLACE * self.characteristic_length {
            return Err(Unreachable::Turned { beside_mm });
        }
        Ok(())
    }
}
