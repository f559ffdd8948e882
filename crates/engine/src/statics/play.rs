//! Play of the tool tip that equilibrium does not show: backlash and static friction of the drives.
//!
//! A joint stands anywhere within its backlash `b`, and static friction up to `τ` holds it `τ/k` beside where its spring would have
//! it. Both are motions of the joint, and the drives' sensitivities carry them to the tool: the interval is
//! `Σ |∂p/∂joint| (b + τ/k)`, component by component, to first order.

use nalgebra::{DMatrix, Matrix6xX, Vector3, Vector6};

use super::state::State;
use crate::{
    machine::{Chain, Drive, Machine},
    spatial::Pose,
};

impl Drive {
    /// Largest deviation of the joint to either side by backlash and static friction, mm or rad.
    fn half_play(&self) -> f64 {
        self.backlash + self.friction / self.stiffness
    }
}

/// Half the interval in which backlash and friction let the tool tip stand, along the axes of O, mm; `None` where no drive has any or
/// joints do not follow from drives one by one. `twists`: those of P at `pose` per unit motion of each drive,
/// [`Outcome::drive_sensitivity`](super::Outcome::drive_sensitivity).
pub fn tool_play(machine: &Machine, pose: &Pose, twists: &Matrix6xX<f64>) -> Option<Vector3<f64>> {
    if machine.drives().all(|(_, drive)| drive.half_play() == 0.0) {
        return None;
    }
    let lever = pose.rotation * machine.tool_tip;
    let mut interval = Vector3::zeros();
    for (twist, (_, drive)) in joint_twists(machine, twists)?.iter().zip(machine.drives()) {
        let (linear, angular) = (twist.fixed_rows::<3>(0), twist.fixed_rows::<3>(3));
        interval += (linear + angular.cross(&lever)).abs() * drive.half_play();
    }
    Some(interval)
}

/// Twist of P (mm, rad in O axes) per mm or rad of backlash of each drive, which presses its joint to one side; zero where the drive
/// carries nothing. `None` where joints do not follow from drives one by one.
pub fn lost_motions(machine: &Machine, state: &State, twists: &Matrix6xX<f64>) -> Option<Vec<Vector6<f64>>> {
    let sides = machine.drives().map(|(chain, drive)| {
        let deflection = state.chains[chain].coordinates[drive.coordinate];
        if deflection.abs() > PRESSED { deflection.signum() } else { 0.0 }
    });
    Some(joint_twists(machine, twists)?.into_iter().zip(sides).map(|(twist, side)| twist * side).collect())
}

/// A drive's spring that is bent by less than this, mm or rad, presses to neither side: rounding.
const PRESSED: f64 = 1e-12;

/// Twist of P per unit motion of each driven joint, in machine order; `None` where joints do not follow from drives one by one.
fn joint_twists(machine: &Machine, twists: &Matrix6xX<f64>) -> Option<Vec<Vector6<f64>>> {
    let mut all = Vec::with_capacity(machine.drive_count());
    for chain in &machine.chains {
        let commands = commands_per_joint(chain)?;
        let first = all.len();
        for joint in 0..chain.drives.len() {
            let each =
                (0..chain.drives.len()).map(|command| twists.column(first + command) * commands[(command, joint)]);
            all.push(each.sum());
        }
    }
    Some(all)
}

/// Commands of the drives (rows) that move one joint (columns) alone; `None` where the coupling has no inverse.
fn commands_per_joint(chain: &Chain) -> Option<DMatrix<f64>> {
    match &chain.coupling {
        None => Some(DMatrix::identity(chain.drives.len(), chain.drives.len())),
        Some(coupling) => coupling.per_shown.clone().try_inverse(),
    }
}
