//! Drives that a program for machine tools tells where to stand by its words A, B and C: those of a head, and those under the workpiece.

use nalgebra::Vector3;

use super::{Configuration, Coordinate, Machine, Motion, refused};
use crate::{
    input::error::Result,
    spatial::{Pose, rotation_log},
};

/// A hinge called A, B or C.
#[derive(Debug, Clone, PartialEq)]
pub struct RotaryDrive {
    /// Its name, in capitals.
    pub letter: char,
    /// As in [`Machine::drive_labels`].
    pub label: String,
    /// Whether it turns the workpiece, and not the tool.
    pub carries: bool,
    /// Direction of its axis in O with all of them at 0, a unit vector about which it turns right-handed what it turns.
    pub about: Vector3<f64>,
    /// A point of its axis in O with all of them at 0, mm.
    pub through: Vector3<f64>,
}

/// The rotary drives of a machine, those of each kind from its base outwards.
#[derive(Debug, Clone, PartialEq)]
pub struct RotaryDrives {
    /// Those of the workpiece carrier after those of the head.
    pub drives: Vec<RotaryDrive>,
    /// `X_OP` with all of them at 0.
    pub platform: Pose,
    /// The pose of what carries the workpiece with all of them at 0, that of O if nothing does.
    pub carrier: Pose,
}

/// How far a hinge is turned to see its axis, rad.
const TRIAL_RAD: f64 = 0.3;
/// How far the platform is moved to see whether it turns, as a share of the characteristic length, and a turn that is none, rad.
const BESIDE: f64 = 0.01;
const STILL_RAD: f64 = 1e-9;

impl Machine {
    /// Its rotary drives: those of its workpiece carrier, and those of a head (of a machine of one chain) without which its other drives
    /// lead the tool, the platform as they turn it.
    pub fn rotary_drives(&self) -> RotaryDrives {
        let head = if self.has_told_head() { named(self) } else { Vec::new() };
        let placed = |drives: &[f64]| self.forward_kinematics(drives).ok().map(|at| at.pose);
        let (mut drives, platform) = axes(self, &head, false, placed).unwrap_or_else(|| (Vec::new(), self.home.pose));
        let Some(carrier) = &self.carrier else { return RotaryDrives { drives, platform, carrier: Pose::identity() } };
        let carried = axes(carrier, &named(carrier), true, |drives| Some(carrier.serial_posture(drives).pose));
        let (carried, at) = carried.unwrap_or_else(|| (Vec::new(), carrier.home.pose));
        drives.extend(carried);
        RotaryDrives { drives, platform, carrier: at }
    }

    /// Whether its hinges called A, B and C may be commanded.
    fn has_told_head(&self) -> bool {
        let home = |(index, _): (usize, char)| {
            let (_, drive) = self.drives().nth(index)?;
            Some((self.drive_labels().swap_remove(index), drive.motion.shown(self.home.drives[index])))
        };
        let told: Option<Vec<(String, f64)>> = named(self).into_iter().map(home).collect();
        self.chains.len() == 1 && told.is_some_and(|told| !told.is_empty() && self.with_commanded_drives(&told).is_ok())
    }

    /// As [`Machine::with_locked_drives`], of drives that turn the platform: rotations are then theirs, and its other drives control its
    /// translations.
    ///
    /// # Errors
    /// As there, and where the platform would turn as the others move it.
    pub fn with_commanded_drives<N: AsRef<str>>(&self, positions: &[(N, f64)]) -> Result<Machine> {
        let mut machine = self.clone();
        if self.controls.iter().any(|c| matches!(c, Coordinate::Rotation(_))) {
            machine.controls.retain(|c| matches!(c, Coordinate::Translation(_)));
            machine.redundancy = machine.redundancy_at_home();
        }
        let mut machine = machine.with_locked_drives(positions)?;
        if machine.turns_beside_held() {
            let names = positions.iter().map(|(name, _)| name.as_ref()).collect::<Vec<_>>().join(", ");
            let problem = format!("locked, the platform of machine {} turns as the others move it", machine.name);
            return Err(refused(&names, problem));
        }
        machine.turns_with_position = false;
        Ok(machine)
    }

    /// Whether the platform turns as the drives move it that are not locked.
    fn turns_beside_held(&self) -> bool {
        (0..3).any(|axis| {
            let mut beside = self.home.pose;
            beside.translation[axis] += BESIDE * self.characteristic_length;
            let there = self.unlimited_inverse_kinematics_from(&self.home, &beside);
            let turn = |at: Configuration| rotation_log(&self.home.pose.rotation.tr_mul(&at.pose.rotation)).norm();
            there.map_or(true, |at| turn(at) > STILL_RAD)
        })
    }

    /// Whether the commanded drives decide how the platform is turned.
    pub fn is_turned_by_locked(&self) -> bool {
        let turns = |&(index, _): &(usize, f64)| {
            self.drives().nth(index).is_some_and(|(_, drive)| drive.motion == Motion::Revolute)
        };
        self.locked.iter().any(turns) && !self.controls.iter().any(|c| matches!(c, Coordinate::Rotation(_)))
    }
}

/// Its hinges called A, B or C, by their place among its drives.
fn named(machine: &Machine) -> Vec<(usize, char)> {
    let letter = |name: &str| ['A', 'B', 'C'].into_iter().find(|letter| name == letter.to_string());
    let hinges = machine.drives().enumerate().filter(|(_, (_, drive))| drive.motion == Motion::Revolute);
    hinges.filter_map(|(index, (_, drive))| Some((index, letter(&drive.name)?))).collect()
}

/// The axes of `hinges` and the pose with all of them at 0, of a machine whose drives bring it to what `placed` says.
fn axes(
    machine: &Machine,
    hinges: &[(usize, char)],
    carries: bool,
    placed: impl Fn(&[f64]) -> Option<Pose>,
) -> Option<(Vec<RotaryDrive>, Pose)> {
    let labels = machine.drive_labels();
    let mut at_zero = machine.home.drives.clone();
    hinges.iter().for_each(|&(index, _)| at_zero[index] = 0.0);
    let zero = placed(&at_zero)?;
    let axis = |&(index, letter): &(usize, char)| {
        let mut turned = at_zero.clone();
        turned[index] = TRIAL_RAD;
        let motion = placed(&turned)?.compose(&zero.inverse());
        let about = rotation_log(&motion.rotation).try_normalize(0.5 * TRIAL_RAD)?;
        // The point of the axis nearest to O: a turn moves O by (1 − R) of it.
        let shift = motion.translation - about * about.dot(&motion.translation);
        let through = (shift + about.cross(&shift) / (0.5 * TRIAL_RAD).tan()) / 2.0;
        Some(RotaryDrive { letter, label: labels[index].clone(), carries, about, through })
    };
    Some((hinges.iter().map(axis).collect::<Option<Vec<_>>>()?, zero))
}
