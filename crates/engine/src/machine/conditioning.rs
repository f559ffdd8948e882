//! How far a machine is from a singularity, whatever its kind.

use nalgebra::{Matrix6, Vector6};

use super::{Configuration, Coordinate, Machine, Motion, MoveScrew};

impl Machine {
    /// Inverse condition number of the Jacobian between the drives and the controlled task coordinates at `at`: its smallest singular
    /// value as a share of the largest, revolute joints and rotations in mm at the [characteristic length](crate::machine::Model::characteristic_length).
    /// 0 where the machine is singular, be it that the drives do not hold the platform or that they cannot move it in some way, and 1 where all
    /// directions are alike (the local conditioning index of Gosselin and Angeles 1991). Redundant drives move as little as they can.
    pub fn conditioning(&self, at: &Configuration) -> f64 {
        let Some(mut jacobian) = self.drive_jacobian(at) else { return 0.0 };
        for (mut row, (_, drive)) in jacobian.row_iter_mut().zip(self.drives()) {
            if drive.motion == Motion::Revolute {
                row *= self.characteristic_length;
            }
        }
        for (mut column, coordinate) in jacobian.column_iter_mut().zip(&self.controls) {
            if matches!(coordinate, Coordinate::Rotation(_)) {
                column /= self.characteristic_length;
            }
        }
        if !jacobian.iter().all(|entry| entry.is_finite()) {
            return 0.0;
        }
        let values = jacobian.singular_values();
        let (least, most) = (values.min(), values.max());
        if most > 0.0 { least / most } else { 0.0 }
    }

    /// Whether [`Machine::conditioning`] is at least `least`; quick for an arm with a spherical wrist whose six revolute joints control all six coordinates.
    pub fn is_conditioned(&self, at: &Configuration, least: f64) -> bool {
        if least <= 0.0 {
            return true;
        }
        let Some(jacobian) = self.arm_jacobian(at) else { return self.conditioning(at) >= least };
        // What singular values are at least and at most.
        let bound = jacobian.try_inverse().map_or(0.0, |inverse| 1.0 / (jacobian.norm() * inverse.norm()));
        bound >= least || inverse_condition(&jacobian) >= least
    }

    /// Motion of P (rows; shares of the characteristic length, rad) per motion of each drive; `None` unless an arm controls all six.
    fn arm_jacobian(&self, at: &Configuration) -> Option<Matrix6<f64>> {
        let first = self.first_arm_drive().filter(|_| self.controls.len() == 6)?;
        let chain = &self.chains[0];
        let mut values = Vec::with_capacity(chain.virtual_count);
        chain.rigid_values(&at.drives, &[], &mut values);
        let mut screws: Vec<MoveScrew> = Vec::new();
        chain.forward(&values, &mut screws);
        let mut joints = Matrix6::zeros();
        for (column, drive) in chain.drives[first..].iter().enumerate() {
            let twist = screws.iter().find(|screw| screw.coordinate == drive.coordinate)?.twist;
            let [v, w] = [twist.linear / self.characteristic_length, twist.angular];
            joints.set_column(column, &Vector6::new(v.x, v.y, v.z, w.x, w.y, w.z));
        }
        let coupled = Matrix6::from_fn(|joint, drive| chain.joint_per_drive(first + joint, first + drive));
        Some(joints * coupled)
    }
}

/// Smallest singular value of `matrix` as a share of the largest.
fn inverse_condition(matrix: &Matrix6<f64>) -> f64 {
    let values = matrix.singular_values();
    let (least, most) = (values.min(), values.max());
    if most > 0.0 { least / most } else { 0.0 }
}
