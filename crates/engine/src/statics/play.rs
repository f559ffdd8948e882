//! Play of the tool tip that equilibrium does not show: backlash and static friction of the drives.
//!
//! A joint stands anywhere within half its backlash, `b`, to either side, and static friction up to `τ` holds it `τ/k` beside where its spring would have
//! it. Both are motions of the joint, and the drives' sensitivities carry them to the tool: the interval is
//! `Σ |∂p/∂joint| (b + τ/k)`, component by component, to first order. A drive force beyond `τ` presses the joint to one side of its backlash,
//! where it stands `b` beside its spring: a motion that is known, and the same as one of the command.

use nalgebra::{DMatrix, DVector, Matrix6xX, Vector3, Vector6};

use super::state::State;
use crate::{
    machine::{Chain, Drive, Machine},
    spatial::Pose,
};

impl Drive {
    /// Largest deviation of the joint to either side by static friction and, where it `is_open`, by backlash, mm or rad.
    fn half_play(&self, is_open: bool) -> f64 {
        (if is_open { self.half_backlash } else { 0.0 }) + self.friction / self.stiffness
    }
}

/// Half the interval in which backlash and friction let the tool tip stand, along the axes of O, mm; `None` where no drive has any or
/// joints do not follow from drives one by one. `twists`: those of P at `pose` per unit motion of each drive,
/// [`Outcome::drive_sensitivity`](super::Outcome::drive_sensitivity).
pub fn tool_play(machine: &Machine, pose: &Pose, twists: &Matrix6xX<f64>) -> Option<Vector3<f64>> {
    open_play(machine, pose, twists, &[])
}

/// [`tool_play`] where drives are pressed to `sides`, see [`loaded_flanks`]: of a drive that is pressed to a side the friction alone counts. No
/// `sides`: every drive is open. `None` as of [`tool_play`].
pub fn open_play(machine: &Machine, pose: &Pose, twists: &Matrix6xX<f64>, sides: &[i8]) -> Option<Vector3<f64>> {
    if !has_play(machine) {
        return None;
    }
    let lever = pose.rotation * machine.tool_tip;
    let mut interval = Vector3::zeros();
    for (i, (twist, (_, drive))) in joint_twists(machine, twists)?.iter().zip(machine.drives()).enumerate() {
        let (linear, angular) = (twist.fixed_rows::<3>(0), twist.fixed_rows::<3>(3));
        let is_open = sides.get(i).is_none_or(|side| *side == 0);
        interval += (linear + angular.cross(&lever)).abs() * drive.half_play(is_open);
    }
    Some(interval)
}

/// Whether a drive has backlash or static friction.
pub fn has_play(machine: &Machine) -> bool {
    machine.drives().any(|(_, drive)| drive.half_play(true) != 0.0)
}

/// Side of its backlash to which each drive is pressed in the equilibrium `state`, machine order: 1 the way its joint grows, −1 the other way, 0
/// where it is open. A drive is pressed by a force that its friction does not hold, so that whatever the friction does, the joint bears on that
/// side. Less than a thousandth of the largest drive force presses nothing: it may be rounding (torques count at the characteristic length).
pub fn loaded_flanks(machine: &Machine, state: &State) -> Vec<i8> {
    let deflected = || {
        machine.drives().map(|(chain, drive)| {
            let unit = drive.motion.choose(1.0, machine.characteristic_length);
            let deflected = state.chains[chain].coordinates[drive.coordinate];
            (drive, unit, deflected, (drive.stiffness * deflected).abs())
        })
    };
    let largest = deflected().map(|(_, unit, _, force)| force / unit).fold(0.0, f64::max);
    let side = |(drive, unit, deflected, force): (&Drive, f64, f64, f64)| {
        let is_pressed =
            deflected.abs() * unit > LEAST_DEFLECTION && force > f64::max(drive.friction, LEAST * largest * unit);
        if is_pressed { deflected.signum() as i8 } else { 0 }
    };
    deflected().map(side).collect()
}

/// Change of all commands, mm or rad, machine order, that would move each joint as far as its backlash does on the side that `sides` gives: by
/// that many times half of it. `None` where joints do not follow from drives one by one.
pub fn flank_commands(machine: &Machine, sides: &[i8]) -> Option<Vec<f64>> {
    let mut all = Vec::with_capacity(sides.len());
    for chain in &machine.chains {
        let own =
            sides[all.len()..].iter().zip(&chain.drives).map(|(side, drive)| f64::from(*side) * drive.half_backlash);
        all.extend((commands_per_joint(chain)? * DVector::from_iterator(chain.drives.len(), own)).iter());
    }
    Some(all)
}

/// A drive's spring that is deflected by less than this, mm (angles at the characteristic length), presses to neither side: the solver's tolerance.
const LEAST_DEFLECTION: f64 = 1e-9;

/// Share of the largest drive force that must press a drive for its side to count.
const LEAST: f64 = 1e-3;

/// Twist of P (mm, rad in O axes) per mm or rad of half the backlash of each drive, which presses its joint to one side; zero where the drive
/// carries nothing. `None` where joints do not follow from drives one by one.
pub fn lost_motions(machine: &Machine, state: &State, twists: &Matrix6xX<f64>) -> Option<Vec<Vector6<f64>>> {
    let sides = machine.drives().map(|(chain, drive)| {
        let deflection = state.chains[chain].coordinates[drive.coordinate];
        if deflection.abs() > PRESSED { deflection.signum() } else { 0.0 }
    });
    Some(joint_twists(machine, twists)?.into_iter().zip(sides).map(|(twist, side)| twist * side).collect())
}

/// A drive's spring that is deflected by less than this, mm or rad, presses to neither side: rounding.
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
