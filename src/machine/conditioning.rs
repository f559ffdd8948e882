//! How far a machine is from a singularity, whatever its kind.

use super::{Configuration, Coordinate, Machine, Motion};

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
}
