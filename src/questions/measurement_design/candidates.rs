//! Candidate poses and loads: spread evenly over the travel of an arm's drives, or over the workspace of other machines.

use nalgebra::Vector3;

use crate::{
    machine::{Branch, Configuration, Machine},
    questions::identification::{AppliedLoad, Measurement, Reading},
    spatial::{Pose, radical_inverse},
};

/// Region in which candidate poses may be.
#[derive(Debug, Clone, PartialEq)]
pub struct Region {
    /// Corners of the box that the tool tip stays in, O, mm; `None`: P stays in the machine's workspace box.
    pub tip: Option<[Vector3<f64>; 2]>,
    /// Boxes that the tool tip stays out of, O, mm.
    pub forbidden: Vec<[Vector3<f64>; 2]>,
    /// Branches of inverse kinematics that an arm may be on; all if empty.
    pub branches: Vec<Branch>,
}

/// Whether `p` is in the box, borders included.
fn is_in_box([min, max]: &[Vector3<f64>; 2], p: &Vector3<f64>) -> bool {
    (0..3).all(|i| (min[i]..=max[i]).contains(&p[i]))
}

impl Region {
    /// Returns whether at `pose` the tool tip (P if no box for the tip is given) is in the allowed box, and the tip outside the forbidden ones.
    fn contains(&self, machine: &Machine, pose: &Pose) -> bool {
        let tip = pose.transform(machine.tool_tip);
        let is_inside = match &self.tip {
            Some(corners) => is_in_box(corners, &tip),
            None => is_in_box(&[machine.workspace.min, machine.workspace.max], &pose.translation),
        };
        is_inside && !self.forbidden.iter().any(|corners| is_in_box(corners, &tip))
    }

    /// Returns whether a configuration is in the region and on an allowed branch.
    fn allows(&self, machine: &Machine, configuration: &Configuration) -> bool {
        let is_on_branch = || machine.branch_of(configuration).is_some_and(|branch| self.branches.contains(&branch));
        self.contains(machine, &configuration.pose) && (self.branches.is_empty() || is_on_branch())
    }
}

/// Bases of Halton's sequence for up to this many drives.
const PRIMES: [usize; 12] = [2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37];
/// Drive positions of an arm are rounded to one over this, degrees or mm, as a person types them.
const DIGITS: f64 = 100.0;
/// Most poses tried for each that is wanted.
const REFUSED_PER_POSE: usize = 2000;

/// Returns the pose of P of an open chain without passive joints, by forward kinematics; `None` for other machines.
pub fn end_of_arm(machine: &Machine, drives: &[f64]) -> Option<Pose> {
    let [chain] = machine.chains.as_slice() else { return None };
    let mut values = Vec::new();
    chain.rigid_values(drives, &[], &mut values);
    chain.passive.is_empty().then(|| chain.forward(&values, &mut Vec::new()))
}

/// Returns up to `count` configurations in `region`, spread by Halton's sequence; fewer where hardly any are allowed.
pub fn poses(machine: &Machine, region: &Region, count: usize) -> Vec<Configuration> {
    let travels: Option<Vec<(f64, f64)>> = machine.drives().map(|(_, drive)| drive.travel).collect();
    let is_arm = machine.chains.len() == 1 && machine.drive_count() <= PRIMES.len();
    let corners = region.tip.unwrap_or([machine.workspace.min, machine.workspace.max]);
    let pose = |index: usize| match &travels {
        Some(travels) if is_arm => {
            let travels = travels.iter().zip(PRIMES);
            let drives = travels.zip(machine.drives()).map(|(((low, high), prime), (_, drive))| {
                let shown = drive.motion.to_shown(low + (high - low) * radical_inverse(index, prime));
                drive.motion.from_shown((shown * DIGITS).round() / DIGITS)
            });
            let drives: Vec<f64> = drives.collect();
            let is_allowed = end_of_arm(machine, &drives).is_none_or(|pose| region.contains(machine, &pose));
            if is_allowed { machine.forward_kinematics(&drives).ok() } else { None }
        }
        _ => {
            let share = Vector3::from_fn(|i, _| radical_inverse(index, PRIMES[i]));
            let tip = corners[0] + (corners[1] - corners[0]).component_mul(&share);
            let lever = machine.home.pose.rotation * machine.tool_tip;
            machine.inverse_kinematics_at(if region.tip.is_some() { tip - lever } else { tip }).ok()
        }
    };
    (1..=count * REFUSED_PER_POSE).filter_map(pose).filter(|at| region.allows(machine, at)).take(count).collect()
}

/// Plans a measurement of each pose under each force on the tool tip (O, N), starting from no load.
pub fn plan_measurements(poses: &[Configuration], forces: &[Vector3<f64>], readings: &[Reading]) -> Vec<Measurement> {
    let no_load = AppliedLoad { force: Vector3::zeros(), moment: Vector3::zeros() };
    let under_each_force = |(number, at): (usize, &Configuration)| {
        let name = (number + 1).to_string();
        let readings = readings.to_vec();
        let place = Measurement {
            name,
            pose: number,
            line: 0,
            at: at.clone(),
            load: no_load,
            reference: no_load,
            marker: None,
            readings,
        };
        let loaded =
            move |force: &Vector3<f64>| Measurement { load: AppliedLoad { force: *force, ..no_load }, ..place.clone() };
        forces.iter().map(loaded).collect::<Vec<_>>()
    };
    poses.iter().enumerate().flat_map(under_each_force).collect()
}
