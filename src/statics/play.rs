//! Where the tool may stand that equilibrium does not tell: backlash and static friction of the drives.
//!
//! A joint stands anywhere within its backlash `b`, and static friction up to `τ` holds it `τ/k` beside where its spring would have
//! it. Both are motions of the joint, and the drives' sensitivities carry them to the tool: the interval is
//! `Σ |∂p/∂joint| (b + τ/k)`, component by component, to first order.

use nalgebra::{DMatrix, Matrix6xX, Vector3};

use crate::{
    machine::{Chain, Drive, Machine},
    spatial::Pose,
};

impl Drive {
    /// How far the joint may stand to either side, mm or rad.
    fn play(&self) -> f64 {
        self.backlash + self.friction / self.stiffness
    }
}

/// Half the interval in which the tool tip may stand by backlash and friction, along the axes of O, mm; `None` where no drive
/// has any. `twists`: those of P at `pose` per unit motion of each drive,
/// [`Outcome::drive_sensitivity`](super::Outcome::drive_sensitivity).
pub fn tool_play(machine: &Machine, pose: &Pose, twists: &Matrix6xX<f64>) -> Option<Vector3<f64>> {
    if machine.drives().all(|(_, drive)| drive.play() == 0.0) {
        return None;
    }
    let lever = pose.rotation * machine.tool_tip;
    let mut interval = Vector3::zeros();
    let mut first = 0;
    for chain in &machine.chains {
        let commands = commands_per_joint(chain)?;
        for (joint, drive) in chain.drives.iter().enumerate() {
            let mut moved = Vector3::zeros();
            for command in 0..chain.drives.len() {
                let twist = twists.column(first + command) * commands[(command, joint)];
                let (linear, angular) = (twist.fixed_rows::<3>(0), twist.fixed_rows::<3>(3));
                moved += linear + angular.cross(&lever);
            }
            interval += moved.abs() * drive.play();
        }
        first += chain.drives.len();
    }
    Some(interval)
}

/// What each drive would be commanded (rows) to move one joint (columns) alone.
fn commands_per_joint(chain: &Chain) -> Option<DMatrix<f64>> {
    match &chain.coupling {
        None => Some(DMatrix::identity(chain.drives.len(), chain.drives.len())),
        Some(coupling) => coupling.per_shown.clone().try_inverse(),
    }
}
