//! Poses and loads to choose from: spread evenly over the travel of an arm's drives, or over the workspace of other machines.

use nalgebra::Vector3;

use crate::{
    machine::{Branch, Configuration, Machine},
    questions::identification::{Applied, Measurement, Reading},
    spatial::{Pose, radical_inverse},
};

/// Where poses may be.
#[derive(Debug, Clone, PartialEq)]
pub struct Region {
    /// Corners of the box that the tool tip stays in, O, mm; `None`: P stays in the machine's box.
    pub tip: Option<[Vector3<f64>; 2]>,
    /// Boxes that the tool tip stays out of.
    pub forbidden: Vec<[Vector3<f64>; 2]>,
    /// Branches on which an arm may stand; all if empty.
    pub branches: Vec<Branch>,
}

fn is_in([min, max]: &[Vector3<f64>; 2], p: &Vector3<f64>) -> bool {
    (0..3).all(|i| (min[i]..=max[i]).contains(&p[i]))
}

impl Region {
    fn holds(&self, machine: &Machine, pose: &Pose) -> bool {
        let tip = pose.transform(machine.tool_tip);
        let is_inside = match &self.tip {
            Some(corners) => is_in(corners, &tip),
            None => is_in(&[machine.workspace.min, machine.workspace.max], &pose.translation),
        };
        is_inside && !self.forbidden.iter().any(|corners| is_in(corners, &tip))
    }

    fn allows(&self, machine: &Machine, at: &Configuration) -> bool {
        let is_on_branch = || machine.branch_of(at).is_some_and(|branch| self.branches.contains(&branch));
        self.holds(machine, &at.pose) && (self.branches.is_empty() || is_on_branch())
    }
}

/// Bases of Halton's sequence for up to this many drives.
const PRIMES: [usize; 12] = [2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37];
/// Positions of an arm's drives are rounded to hundredths, as a person types them.
const DIGITS: f64 = 100.0;
/// A region is given up where so many poses are refused for each that is wanted.
const REFUSED_PER_POSE: usize = 2000;

/// Where P is on an arm whose joints are all driven, found without a search; `None` for other machines.
pub fn end_of_arm(machine: &Machine, drives: &[f64]) -> Option<Pose> {
    let [chain] = machine.chains.as_slice() else { return None };
    let mut values = Vec::new();
    chain.rigid_values(drives, &[], &mut values);
    chain.passive.is_empty().then(|| chain.forward(&values, &mut Vec::new()))
}

/// Up to `count` poses that `region` allows; fewer where hardly any are.
pub fn poses(machine: &Machine, region: &Region, count: usize) -> Vec<Configuration> {
    let travels: Option<Vec<(f64, f64)>> = machine.drives().map(|(_, drive)| drive.travel).collect();
    let is_arm = machine.chains.len() == 1 && machine.drive_count() <= PRIMES.len();
    let corners = region.tip.unwrap_or([machine.workspace.min, machine.workspace.max]);
    let pose = |index: usize| match &travels {
        Some(travels) if is_arm => {
            let travels = travels.iter().zip(PRIMES);
            let drives = travels.zip(machine.drives()).map(|(((low, high), prime), (_, drive))| {
                let shown = drive.motion.shown(low + (high - low) * radical_inverse(index, prime));
                drive.motion.from_shown((shown * DIGITS).round() / DIGITS)
            });
            let drives: Vec<f64> = drives.collect();
            let is_wanted = end_of_arm(machine, &drives).is_none_or(|pose| region.holds(machine, &pose));
            if is_wanted { machine.forward_kinematics(&drives).ok() } else { None }
        }
        _ => {
            let share = Vector3::from_fn(|i, _| radical_inverse(index, PRIMES[i]));
            let tip = corners[0] + (corners[1] - corners[0]).component_mul(&share);
            let lever = machine.home.pose.rotation * machine.tool_tip;
            machine.command(if region.tip.is_some() { tip - lever } else { tip }).ok()
        }
    };
    (1..=count * REFUSED_PER_POSE).filter_map(pose).filter(|at| region.allows(machine, at)).take(count).collect()
}

/// Each pose under each force, from rest, to be read by `readings`.
pub fn measurements(poses: &[Configuration], forces: &[Vector3<f64>], readings: &[Reading]) -> Vec<Measurement> {
    let nothing = Applied { force: Vector3::zeros(), moment: Vector3::zeros() };
    let of = |(number, at): (usize, &Configuration)| {
        let name = (number + 1).to_string();
        let readings = readings.to_vec();
        let place =
            Measurement { name, line: 0, at: at.clone(), load: nothing, reference: nothing, marker: None, readings };
        let loaded =
            move |force: &Vector3<f64>| Measurement { load: Applied { force: *force, ..nothing }, ..place.clone() };
        forces.iter().map(loaded).collect::<Vec<_>>()
    };
    poses.iter().enumerate().flat_map(of).collect()
}
