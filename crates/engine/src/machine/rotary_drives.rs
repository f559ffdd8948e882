//! Rotary drives that a program of a machine tool commands by its words A, B and C: those of a head, and those under the workpiece.

use nalgebra::Vector3;

use super::{Configuration, Coordinate, Machine, Motion, refusal};
use crate::{
    input::error::Result,
    spatial::{Pose, rotation_log},
};

/// A rotary drive called A, B or C, with its axis.
#[derive(Debug, Clone, PartialEq)]
pub struct RotaryDrive {
    /// Its name, in capitals.
    pub letter: char,
    /// Its label, as in [`Machine::drive_labels`].
    pub label: String,
    /// Whether it turns the workpiece, and not the tool.
    pub carries: bool,
    /// Direction of its axis in O with all of them at 0, a unit vector about which it turns right-handed what it turns.
    pub about: Vector3<f64>,
    /// A point of its axis in O with all of them at 0, mm.
    pub through: Vector3<f64>,
    /// Least and greatest angle, degrees.
    pub travel_deg: Option<[f64; 2]>,
}

/// The rotary drives of a machine, of the head and of the workpiece carrier each from the base outwards.
#[derive(Debug, Clone, PartialEq)]
pub struct RotaryDrives {
    /// The drives of the workpiece carrier after those of the head.
    pub drives: Vec<RotaryDrive>,
    /// `X_OP` with all of them at 0.
    pub platform: Pose,
    /// The pose of what carries the workpiece with all of them at 0, that of O if nothing does.
    pub carrier: Pose,
}

/// How far a revolute joint is turned to see its axis, rad.
const TRIAL_RAD: f64 = 0.3;
/// How far the platform is moved to see whether it turns, as a share of the characteristic length, and a turn that is none, rad.
const BESIDE: f64 = 0.01;
const STILL_RAD: f64 = 1e-9;

impl Machine {
    /// Rotary drives of the workpiece carrier and, on a machine of one chain, of a head commanded while the other drives control the translations.
    pub fn rotary_drives(&self) -> RotaryDrives {
        let head = if self.with_commanded_head().is_some() { revolute(self) } else { Vec::new() };
        let placed = |drives: &[f64]| self.forward_kinematics(drives).ok().map(|at| at.pose);
        let (mut drives, platform) = axes(self, &head, false, placed).unwrap_or_else(|| (Vec::new(), self.home.pose));
        let Some(carrier) = &self.carrier else { return RotaryDrives { drives, platform, carrier: Pose::identity() } };
        let carried = axes(carrier, &revolute(carrier), true, |drives| Some(carrier.serial_configuration(drives).pose));
        let (carried, at) = carried.unwrap_or_else(|| (Vec::new(), carrier.home.pose));
        drives.extend(carried);
        RotaryDrives { drives, platform, carrier: at }
    }

    /// This machine with the revolute joints called A, B and C of its one chain commanded to home, see [`Machine::with_commanded_drives`]; `None` if there
    /// are none, or they cannot be.
    pub fn with_commanded_head(&self) -> Option<Machine> {
        let head: Vec<usize> = revolute(self).into_iter().map(|(index, _)| index).collect();
        let is_head = self.chains.len() == 1 && !head.is_empty();
        is_head.then(|| self.with_commanded_drives(&self.shown_at_home(&head)).ok()).flatten()
    }

    /// Whether a revolute joint called A, B or C is locked.
    pub(super) fn has_locked_head(&self) -> bool {
        revolute(self).iter().any(|(revolute, _)| self.locked.iter().any(|(index, _)| index == revolute))
    }

    /// Locks drives that turn the platform, see [`Machine::with_locked_drives`]: they decide its rotations, the other drives its translations.
    ///
    /// # Errors
    /// As [`Machine::with_locked_drives`], and where the platform would turn as the other drives move it.
    pub fn with_commanded_drives<N: AsRef<str>>(&self, positions: &[(N, f64)]) -> Result<Machine> {
        let mut machine = self.clone();
        if self.controls.iter().any(|c| matches!(c, Coordinate::Rotation(_))) {
            machine.controls.retain(|c| matches!(c, Coordinate::Translation(_)));
            machine.redundancy = machine.redundancy_at_home();
        }
        let mut machine = machine.with_locked_drives(positions)?;
        if machine.rotates_beside_locked() {
            let names = positions.iter().map(|(name, _)| name.as_ref()).collect::<Vec<_>>().join(", ");
            let problem = format!(
                "with this drive locked, the other drives of machine {} rotate the platform when they move P",
                machine.name
            );
            return Err(refusal(&names, problem));
        }
        machine.has_parasitic_rotation = false;
        machine.definition.is_commanded = true;
        Ok(machine)
    }

    /// Whether the platform rotates as the drives that are not locked translate it.
    fn rotates_beside_locked(&self) -> bool {
        (0..3).any(|axis| {
            let mut beside = self.home.pose;
            beside.translation[axis] += BESIDE * self.characteristic_length;
            let there = self.unlimited_inverse_kinematics_from(&self.home, &beside);
            let turn = |at: Configuration| rotation_log(&self.home.pose.rotation.tr_mul(&at.pose.rotation)).norm();
            there.map_or(true, |at| turn(at) > STILL_RAD)
        })
    }

    /// Whether the locked drives decide the orientation of the platform.
    pub fn is_oriented_by_locked(&self) -> bool {
        let turns = |&(index, _): &(usize, f64)| {
            self.drives().nth(index).is_some_and(|(_, drive)| drive.motion == Motion::Revolute)
        };
        self.locked.iter().any(turns) && !self.controls.iter().any(|c| matches!(c, Coordinate::Rotation(_)))
    }
}

/// Drive index and letter of each revolute joint of `machine` called A, B or C.
fn revolute(machine: &Machine) -> Vec<(usize, char)> {
    let letter = |name: &str| ['A', 'B', 'C'].into_iter().find(|letter| name == letter.to_string());
    let revolute = machine.drives().enumerate().filter(|(_, (_, drive))| drive.motion == Motion::Revolute);
    revolute.filter_map(|(index, (_, drive))| Some((index, letter(&drive.name)?))).collect()
}

/// Axes of `revolute`, and the pose with all of them at 0; `placed` gives the pose in O at drive positions (mm, rad), if there is one.
fn axes(
    machine: &Machine,
    revolute: &[(usize, char)],
    carries: bool,
    placed: impl Fn(&[f64]) -> Option<Pose>,
) -> Option<(Vec<RotaryDrive>, Pose)> {
    let labels = machine.drive_labels();
    let mut at_zero = machine.home.drives.clone();
    revolute.iter().for_each(|&(index, _)| at_zero[index] = 0.0);
    let zero = placed(&at_zero)?;
    let axis = |&(index, letter): &(usize, char)| {
        let mut turned = at_zero.clone();
        turned[index] = TRIAL_RAD;
        let motion = placed(&turned)?.compose(&zero.inverse());
        let about = rotation_log(&motion.rotation).try_normalize(0.5 * TRIAL_RAD)?;
        // The point of the axis nearest to O: a turn moves O by (1 − R) of it.
        let shift = motion.translation - about * about.dot(&motion.translation);
        let through = (shift + about.cross(&shift) / libm::tan(0.5 * TRIAL_RAD)) / 2.0;
        let travel_deg = machine.drives().nth(index)?.1.travel.map(|(low, high)| [low, high].map(f64::to_degrees));
        Some(RotaryDrive { letter, label: labels[index].clone(), carries, about, through, travel_deg })
    };
    Some((revolute.iter().map(axis).collect::<Option<Vec<_>>>()?, zero))
}
