//! How far a machine is from a singularity, whatever its kind.

use nalgebra::{Matrix6, Vector6};

use super::{Configuration, Coordinate, Machine, Motion, MoveScrew};

impl Machine {
    /// Inverse condition number of the Jacobian between the drives and the controlled task coordinates at `at`: its smallest singular
    /// value as a share of the largest, hinges and rotations in mm at [`Machine::reach`](crate::machine::Model::reach). 0 where the
    /// machine is singular, be it that the drives do not hold the platform or that they cannot move it in some way, and 1 where all
    /// directions are alike (the local conditioning index of Gosselin and Angeles 1991). Redundant drives move as little as they can.
    pub fn conditioning(&self, at: &Configuration) -> f64 {
        let Some(mut jacobian) = self.drive_jacobian(at) else { return 0.0 };
        for (mut row, (_, drive)) in jacobian.row_iter_mut().zip(self.drives()) {
            if drive.motion == Motion::Revolute {
                row *= self.reach;
            }
        }
        for (mut column, coordinate) in jacobian.column_iter_mut().zip(&self.controls) {
            if matches!(coordinate, Coordinate::Rotation(_)) {
                column /= self.reach;
            }
        }
        if !jacobian.iter().all(|entry| entry.is_finite()) {
            return 0.0;
        }
        let values = jacobian.singular_values();
        let (least, most) = (values.min(), values.max());
        if most > 0.0 { least / most } else { 0.0 }
    }

    /// [`Machine::conditioning`] of an arm with a spherical wrist that controls all six coordinates by its six hinges, from their axes:
    /// for many postures. `None` for other machines.
    pub(crate) fn arm_conditioning(&self, at: &Configuration) -> Option<f64> {
        let first = self.first_of_arm().filter(|_| self.controls.len() == 6)?;
        let chain = &self.chains[0];
        let mut values = Vec::with_capacity(chain.virtual_count);
        chain.rigid_values(&at.drives, &[], &mut values);
        let mut screws: Vec<MoveScrew> = Vec::new();
        chain.forward(&values, &mut screws);
        let mut joints = Matrix6::zeros();
        for (column, drive) in chain.drives[first..].iter().enumerate() {
            let twist = screws.iter().find(|screw| screw.coordinate == drive.coordinate)?.twist;
            let [v, w] = [twist.linear / self.reach, twist.angular];
            joints.set_column(column, &Vector6::new(v.x, v.y, v.z, w.x, w.y, w.z));
        }
        let coupled = Matrix6::from_fn(|joint, drive| chain.joint_per_drive(first + joint, first + drive));
        let values = (joints * coupled).singular_values();
        let (least, most) = (values.min(), values.max());
        Some(if most > 0.0 { least / most } else { 0.0 })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_axes_of_an_arm_tell_what_its_closure_does() {
        for name in ["fanuc_r2000ic", "kr270"] {
            let machine = Machine::named(name).unwrap();
            for seed in 0..20 {
                let beside = |(k, home): (usize, &f64)| home + 0.4 * ((seed * 7 + k * 3) as f64).sin();
                let drives: Vec<f64> = machine.home.drives.iter().enumerate().map(beside).collect();
                let at = machine.forward_kinematics(&drives).unwrap();
                let (own, of_closure) = (machine.arm_conditioning(&at).unwrap(), machine.conditioning(&at));
                assert!((own - of_closure).abs() < 1e-9 * of_closure.max(1e-3), "{name}: {own} and {of_closure}");
            }
        }
        assert_eq!(
            Machine::named("orthoglide").unwrap().arm_conditioning(&Machine::named("orthoglide").unwrap().home),
            None
        );
    }
}
