//! Other rigid configurations for a pose that cannot be reached by following the straight line from home.
//!
//! The drives of a serial machine can be moved one by one from any posture to any other, so every posture that meets the target within travel will
//! do: it is sought from home with the first revolute joint turned towards the target, then with each other revolute joint turned. A machine with closed loops must
//! not pass a singularity: it is tracked around, through points beside the straight line.

use std::f64::consts::{PI, TAU};

use nalgebra::Vector3;

use super::{
    Configuration, Machine, Motion, MoveScrew, Unreachable,
    kinematics::{Closure, Command},
};
use crate::spatial::Pose;

/// Angles by which revolute joints are turned from home.
const TURNS: [f64; 5] = [PI / 3.0, -PI / 3.0, TAU / 3.0, -TAU / 3.0, PI];
const SERIAL_FIRST: &str = "the first revolute joint turned towards the position and away from it";
const SERIAL_ALL: &str = "the first revolute joint turned towards the position and away from it, each other revolute joint turned by 60, 120 and 180 deg from there and from home";
/// Distance of points beside the straight line, as shares of its length.
const DETOURS: [f64; 2] = [0.5, 1.0];
const DETOURS_TRIED: &str = "detours through points beside the straight line, by half of and by all its length";
/// A line shorter than this share of the machine's characteristic length has no sides.
const SHORTEST_LINE: f64 = 1e-3;

impl Machine {
    /// Searches another branch for `target`, which the straight line from home misses for the reason `straight`; `Err` says what was tried.
    pub(super) fn try_other_branch(&self, target: &Pose, straight: Unreachable) -> Result<Configuration, Unreachable> {
        let is_finite = target.translation.iter().chain(target.rotation.iter()).all(|entry| entry.is_finite());
        // All postures of an arm are known; those of one that its rail carries are sought.
        if let (Some(chosen), 0, true) = (self.branch, self.redundancy, is_finite) {
            return self.solve_on_branch(chosen, target, straight);
        }
        let (posture, tried) = match (self.chains.len(), &straight) {
            _ if !is_finite || matches!(straight, Unreachable::BeyondSpan { .. }) => return Err(straight),
            // Prismatic joints alone have one posture.
            (1, _) if !self.drives().any(|(_, drive)| drive.motion == Motion::Revolute) => return Err(straight),
            // Of an arm all postures are known, in a thirtieth of the time that a search takes.
            (1, _) if self.chains[0].passive.is_empty() && self.is_beyond_travel(target) => (None, SERIAL_ALL),
            (1, _) if self.chains[0].passive.is_empty() => self.search_postures(target),
            // A way around is of use where the chains close, but not on this side of a singularity.
            (_, Unreachable::OtherMode) => (self.solve_by_detour(target), DETOURS_TRIED),
            _ => return Err(straight),
        };
        let posture = match posture {
            None if self.redundancy == 0 => self.known_posture(target, &straight)?,
            posture => posture,
        };
        posture.ok_or_else(|| Unreachable::NoWay { straight: Box::new(straight), tried: tried.into() })
    }

    /// Whether all postures of an arm that meet `target` are found, and all are beyond travel.
    fn is_beyond_travel(&self, target: &Pose) -> bool {
        // Drives that are coupled may turn together by what is no turn of one.
        let is_known = self.redundancy == 0 && self.full_turns().all(|turn| turn.is_some());
        let count = if is_known { self.postures_in_closed_form(target).len() } else { 0 };
        let postures = if count > 0 { self.postures_at(target) } else { Vec::new() };
        count > 0 && postures.len() == count && postures.iter().all(|posture| posture.limits.is_err())
    }

    /// The posture of an arm that meets `target` within travel, nearest to home; `None` where the machine is no arm or is out of reach, `Err` where
    /// all that meet it are beyond travel, with the limits.
    fn known_posture(&self, target: &Pose, straight: &Unreachable) -> Result<Option<Configuration>, Unreachable> {
        let mut limits: Vec<(String, Vec<&str>)> = Vec::new();
        let mut within: Vec<Configuration> = Vec::new();
        for posture in self.postures_at(target) {
            match posture.limits {
                Ok(()) => within.push(posture.at),
                Err(limit) => {
                    let (limit, branch) = (limit.to_string(), posture.branch.label());
                    match limits.iter_mut().find(|(known, _)| *known == limit) {
                        Some((_, branches)) => branches.push(branch),
                        None => limits.push((limit, vec![branch])),
                    }
                }
            }
        }
        if within.is_empty() && !limits.is_empty() {
            let text = |(limit, branches): (String, Vec<&str>)| format!("{limit} ({})", branches.join(", "));
            let limits = limits.into_iter().map(text).collect::<Vec<_>>().join("; ");
            return Err(Unreachable::NoPosture { straight: Box::new(straight.clone()), limits });
        }
        let distance = |at: &Configuration| self.distance_from_home(at);
        Ok(within.into_iter().min_by(|a, b| distance(a).total_cmp(&distance(b))))
    }

    /// The posture of a serial machine that meets `target` within travel, nearest to home of those found; and words for what was tried.
    fn search_postures(&self, target: &Pose) -> (Option<Configuration>, &'static str) {
        let home = &self.home.drives;
        let revolute: Vec<usize> = self
            .drives()
            .enumerate()
            .filter(|(_, (_, drive))| drive.motion == Motion::Revolute)
            .map(|(index, _)| index)
            .collect();
        let turned = |drives: &[f64], revolute: usize, angle: f64| {
            let mut drives = drives.to_vec();
            drives[revolute] += angle;
            drives
        };
        let mut starts = vec![home.clone()];
        if let Some(&first) = revolute.first() {
            let towards = self.azimuth(first, target);
            starts.push(turned(home, first, towards));
            starts.push(turned(home, first, towards + PI));
        }
        if let Some(posture) = self.nearest_posture(&starts, target) {
            return (Some(posture), SERIAL_FIRST);
        }
        let others = revolute.iter().skip(1).flat_map(|&revolute| TURNS.map(|angle| (revolute, angle)));
        let starts: Vec<Vec<f64>> = others
            .flat_map(|(revolute, angle)| starts.iter().take(2).map(move |drives| turned(drives, revolute, angle)))
            .collect();
        (self.nearest_posture(&starts, target), SERIAL_ALL)
    }

    /// Change of revolute drive `revolute` of a serial machine, rad, that turns P about its axis from home towards the target.
    fn azimuth(&self, revolute: usize, target: &Pose) -> f64 {
        let chain = &self.chains[0];
        let mut values = vec![0.0; chain.virtual_count];
        chain.add_joint_positions(&self.home.drives, &mut values);
        let mut screws: Vec<MoveScrew> = Vec::new();
        chain.forward(&values, &mut screws);
        let Some(screw) = screws.iter().find(|screw| screw.coordinate == chain.drives[revolute].coordinate) else {
            return 0.0;
        };
        let axis = screw.twist.angular;
        let from_axis = screw.twist.linear.cross(&axis);
        let way = target.translation - (self.home.pose.translation - from_axis);
        let to_target = way - axis * axis.dot(&way);
        let least = 1e-9 * self.characteristic_length;
        if from_axis.norm() < least || to_target.norm() < least {
            return 0.0;
        }
        let angle = libm::atan2(axis.dot(&from_axis.cross(&to_target)), from_axis.dot(&to_target));
        let share = chain.joint_per_drive(revolute, revolute);
        if share == 0.0 { 0.0 } else { angle / share }
    }

    /// Posture nearest to home, of those found from the drive positions `starts` that meet `target` within the limits; `None` if none does.
    fn nearest_posture(&self, starts: &[Vec<f64>], target: &Pose) -> Option<Configuration> {
        let mut closure = Closure::new(self);
        let postures = starts.iter().filter_map(|drives| {
            let start = self.serial_configuration(drives);
            let mut met = closure.solve_from(start, &Command::Task(target))?;
            self.turn_nearest_to_home(&mut met);
            self.adjust_to_limits(met, target).ok()
        });
        let measured: Vec<(f64, Configuration)> = postures.map(|at| (self.distance_from_home(&at), at)).collect();
        let nearest = measured.into_iter().reduce(|best, next| {
            // Postures found twice differ by rounding: the first one stays.
            if next.0 < best.0 * (1.0 - 1e-9) { next } else { best }
        });
        nearest.map(|(_, at)| at)
    }

    /// Configuration of a serial machine with its drives at `drives` (mm, rad).
    pub(super) fn serial_configuration(&self, drives: &[f64]) -> Configuration {
        let chain = &self.chains[0];
        let mut values = vec![0.0; chain.virtual_count];
        chain.add_joint_positions(drives, &mut values);
        let pose = chain.forward(&values, &mut Vec::new());
        Configuration { pose, drives: drives.to_vec(), passive: vec![Vec::new()] }
    }

    /// Configuration at `target` reached around a singularity: from home to a point beside the straight line, and on to the target; `None` if no
    /// detour leads there, or the target is next to home.
    fn solve_by_detour(&self, target: &Pose) -> Option<Configuration> {
        let home = self.home.pose;
        let line = self.controllable_position(target.translation) - home.translation;
        if line.norm() < SHORTEST_LINE * self.characteristic_length {
            return None;
        }
        let sides: Vec<Vector3<f64>> = side_directions(&line, |axis| self.controls_translation(axis));
        let middle = home.translation + line * 0.5;
        DETOURS.iter().flat_map(|share| sides.iter().map(move |side| side * *share)).find_map(|offset| {
            let via = self.pose_at(middle + offset * line.norm());
            let beside = self.inverse_kinematics_from(&self.home, &via).ok()?;
            self.inverse_kinematics_from(&beside, target).ok()
        })
    }
}

/// Unit vectors to both sides of `line`, in up to two directions across it, along the axes that are `controlled`.
fn side_directions(line: &Vector3<f64>, controlled: impl Fn(usize) -> bool) -> Vec<Vector3<f64>> {
    let direction = line.normalize();
    let mut across: Vec<Vector3<f64>> = Vec::new();
    let mut axes: Vec<usize> = (0..3).filter(|&axis| controlled(axis)).collect();
    // The axis farthest from the line first.
    axes.sort_by(|&a, &b| direction[a].abs().total_cmp(&direction[b].abs()));
    for axis in axes {
        let mut side = Vector3::zeros();
        side[axis] = 1.0;
        side -= direction * direction[axis];
        for other in &across {
            side -= other * other.dot(&side);
        }
        if side.norm() > 1e-6 {
            across.push(side.normalize());
        }
    }
    across.into_iter().flat_map(|side| [side, -side]).collect()
}
