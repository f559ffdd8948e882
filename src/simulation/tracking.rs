//! Tracks the nominal machine along a path from point to point, and finds where it would have to change its posture.

use crate::{
    compensation::{CompensationStatus, TaskPoint},
    machine::{
        AskedPosture, BatchKinematics, Configuration, ExternalAxes, Machine, PositionedMachine, PostureChange,
        Unreachable,
    },
};

/// Configuration of the nominal machine at a point of a path, if reached, and whether it can be tracked there.
#[derive(Debug, Clone)]
pub(crate) struct TrackPoint {
    pub at: Option<Configuration>,
    pub tracked: Result<(), CompensationStatus>,
}

impl TrackPoint {
    /// Returns the configuration, if the machine can be there at all, else `None`.
    fn configuration(&self) -> Option<&Configuration> {
        self.at.as_ref().filter(|_| !matches!(self.tracked, Err(CompensationStatus::Unreachable(_))))
    }
}

/// Tracks `nominal` along each of `blocks`, several at a time, each from home so that none waits for another; [`join_blocks`] makes
/// them continue one another. A block ends where `goes_on` returns false for its number and its points so far.
pub(crate) fn track_together(
    nominal: &Machine,
    blocks: &[&[TaskPoint]],
    goes_on: impl Fn(usize, &[TrackPoint]) -> bool,
) -> Vec<Vec<TrackPoint>> {
    track_together_from(&nominal.home, nominal, blocks, goes_on)
}

/// Tracks `nominal` as [`track_together`], each block from `start`, or from home where no straight way leads on from there.
pub(crate) fn track_together_from(
    start: &Configuration,
    nominal: &Machine,
    blocks: &[&[TaskPoint]],
    goes_on: impl Fn(usize, &[TrackPoint]) -> bool,
) -> Vec<Vec<TrackPoint>> {
    let mut storage = BatchKinematics::new(nominal);
    let begin = |_| MachineOnPath { near: start.clone(), ..MachineOnPath::new(nominal) };
    let mut track: Vec<MachineOnPath> = blocks.iter().map(begin).collect();
    let mut points: Vec<Vec<TrackPoint>> = blocks.iter().map(|tasks| Vec::with_capacity(tasks.len())).collect();
    step_by_step(&mut track, blocks, &mut storage, |k, point| {
        points[k].push(point);
        goes_on(k, &points[k])
    });
    points
}

/// Makes consecutive blocks, each tracked from home, continue one another from the configuration `before`, revolute joints at the turn they have reached.
pub(crate) fn join_blocks<'a>(
    nominal: &Machine,
    before: Option<&Configuration>,
    blocks: impl Iterator<Item = (&'a [TaskPoint], &'a mut Vec<TrackPoint>)>,
) {
    if nominal.may_change_posture() {
        let mut track = MachineOnPath::new(nominal);
        track.before = before.cloned();
        blocks.for_each(|(tasks, points)| track.continue_with(tasks, points));
    }
}

/// Returns the configuration at the last point of `track` that is reached; `None` if none is.
pub(crate) fn last_reached(track: &[TrackPoint]) -> Option<&Configuration> {
    track.iter().rev().find_map(TrackPoint::configuration)
}

/// Tracks each machine along its tasks, all by one point at a time. `take` gets each point with the machine's number, and says whether to go on.
fn step_by_step(
    track: &mut [MachineOnPath],
    tasks: &[&[TaskPoint]],
    storage: &mut BatchKinematics,
    mut take: impl FnMut(usize, TrackPoint) -> bool,
) {
    let mut going: Vec<usize> = (0..track.len()).collect();
    for point in 0.. {
        going.retain(|&k| point < tasks[k].len());
        if going.is_empty() {
            break;
        }
        // With external axes each stands on a machine of its own.
        let plain: Vec<usize> = going
            .iter()
            .copied()
            .filter(|&k| tasks[k][point].external.is_none() && tasks[k][point].led.is_none())
            .collect();
        let starts: Vec<_> = plain.iter().map(|&k| (&track[k].near, tasks[k][point].pose)).collect();
        let mut found = plain.iter().zip(storage.inverse_kinematics(&starts)).peekable();
        going.retain(|&k| {
            let straight = found.next_if(|(own, _)| **own == k).and_then(|(_, at)| at);
            take(k, track[k].step(&tasks[k][point], straight))
        });
    }
}

/// A machine being tracked along a path.
struct MachineOnPath {
    nominal: PositionedMachine,
    /// The machine with its head commanded, once a program leads that.
    head: Option<PositionedMachine>,
    /// Configuration from which the next point is sought.
    near: Configuration,
    /// Configuration at the previous point; `None` at the beginning, and for machines with only one posture.
    before: Option<Configuration>,
}

impl MachineOnPath {
    /// Starts at home.
    fn new(nominal: &Machine) -> Self {
        Self { nominal: PositionedMachine::new(nominal), head: None, near: nominal.home.clone(), before: None }
    }

    /// Makes `points` of `tasks`, tracked from home, continue from the point before, which then is the last of them.
    fn continue_with(&mut self, tasks: &[TaskPoint], points: &mut Vec<TrackPoint>) {
        // A head that is led stands as the program says wherever a block begins.
        let is_led = tasks.iter().any(|task| task.led.is_some());
        if let (false, Some(before), Some(first)) =
            (is_led, self.before.clone(), points.iter().position(|point| point.configuration().is_some()))
        {
            self.continue_behind(&before, tasks, points, first);
        }
        if let Some(last) = last_reached(points) {
            self.before = Some(last.clone());
        }
    }

    /// Makes `points` continue from the configuration `before`, where number `first` is the first of them that is reached.
    fn continue_behind(
        &mut self,
        before: &Configuration,
        tasks: &[TaskPoint],
        points: &mut Vec<TrackPoint>,
        first: usize,
    ) {
        let task = &tasks[first];
        let there = match self.nominal.move_to(task.external) {
            Ok(_) => self.nominal.inverse_kinematics_from(before, &task.pose).ok(),
            Err(_) => None,
        };
        let Some(from_home) = points[first].at.as_ref() else { return };
        let turns = self.nominal.full_turns_towards(&from_home.drives, &there.as_ref().unwrap_or(before).drives);
        // A program that says postures says turns as well.
        let is_asked = tasks.iter().any(|task| task.asked.is_some());
        let is_turned = turns.iter().all(|turn| *turn == 0.0) || !is_asked && add_turns(&self.nominal, points, &turns);
        if let (true, Some(at)) = (is_turned, points[first].at.clone())
            && there.as_ref().is_none_or(|there| self.nominal.has_same_drives(there, &at))
        {
            points[first].tracked = self.check_posture(&at, there.is_some(), task);
            return;
        }
        // From where the machine stands or, where no straight way leads on, from home at the same turn.
        self.near = match there {
            Some(_) => before.clone(),
            None => with_turns(self.nominal.original().home.clone(), &turns),
        };
        for (task, point) in tasks.iter().zip(points) {
            *point = self.step(task, None);
        }
    }

    /// Returns the configuration at the next point, if reached, and why the machine cannot be tracked there, if so, such as a change of
    /// posture. `straight` is the configuration at the end of the straight line, if already found.
    fn step(&mut self, task: &TaskPoint, straight: Option<Configuration>) -> TrackPoint {
        let unreached = |why| TrackPoint { at: None, tracked: Err(CompensationStatus::Unreachable(why)) };
        if let Err(unreachable) = self.nominal.move_to(task.external) {
            return unreached(unreachable);
        }
        if let Some(led) = task.led {
            return match self.led_configuration(led, task) {
                Ok(at) => {
                    let tracked = self.nominal.check_tracked(&task.pose, &at).map_err(CompensationStatus::Unreachable);
                    (self.near, self.before) = (at.clone(), Some(at.clone()));
                    TrackPoint { at: Some(at), tracked }
                }
                Err(unreachable) => unreached(unreachable),
            };
        }
        let asked = task.asked.filter(|_| self.nominal.may_change_posture());
        let from = asked.and_then(|asked| self.nominal.at_angles(asked.from?.map(f64::from)));
        let begins_anew = from.is_some();
        if let Some(from) = from {
            self.near.clone_from(&from);
            self.before = Some(from);
        }
        // Behind a motion from point to point, or where nothing says how it stood before.
        let is_taken = |asked: &AskedPosture| asked.is_chosen() || self.before.is_none() && asked.says_something();
        let taken = asked.filter(is_taken).and_then(|own| self.nominal.posture_asked(&task.pose, &own, &self.near));
        let is_from_before = self.before.as_ref() == Some(&self.near);
        let straight = match (taken, straight.filter(|_| !begins_anew)) {
            (Some(at), _) | (None, Some(at)) => Ok(at),
            _ => self.nominal.inverse_kinematics_from(&self.near, &task.pose),
        };
        let is_tracked = straight.is_ok();
        let at = match straight.or_else(|_| self.nominal.inverse_kinematics(&task.pose)) {
            Ok(at) => at,
            Err(unreachable) => return unreached(unreachable),
        };
        self.near.clone_from(&at);
        let tracked = match self.nominal.check_tracked(&task.pose, &at) {
            Ok(()) if self.nominal.may_change_posture() => self.check_posture(&at, is_tracked && is_from_before, task),
            Ok(()) => Ok(()),
            Err(unreachable) => Err(CompensationStatus::Unreachable(unreachable)),
        };
        TrackPoint { at: Some(at), tracked }
    }

    /// Returns the configuration that meets `task` with the head where the program leads it.
    fn led_configuration(&mut self, led: ExternalAxes, task: &TaskPoint) -> Result<Configuration, Unreachable> {
        if self.head.is_none() {
            self.head = self.nominal.original().with_commanded_head().map(|head| PositionedMachine::new(&head));
        }
        let Some(head) = &mut self.head else { return self.nominal.inverse_kinematics(&task.pose) };
        head.move_to(Some(led))?;
        let near = head.inverse_kinematics(&task.pose)?;
        self.nominal.inverse_kinematics_from(&near, &task.pose)
    }

    /// Checks that the machine at `at`, which meets `task`, keeps its posture. `is_tracked`: the straight line is known to lead there.
    fn check_posture(
        &mut self,
        at: &Configuration,
        is_tracked: bool,
        task: &TaskPoint,
    ) -> Result<(), CompensationStatus> {
        let before = self.before.replace(at.clone());
        if let Some(asked) = &task.asked {
            if !self.nominal.has_posture(at, asked) {
                let (change, here_mm) = (PostureChange::Contradicts, at.pose.translation);
                let before_mm = before.map_or(here_mm, |before| before.pose.translation);
                return Err(CompensationStatus::ChangesPosture { change, before_mm, here_mm });
            }
            if asked.is_chosen() {
                return Ok(());
            }
        }
        let Some(before) = before else { return Ok(()) };
        let is_tracked = is_tracked || self.nominal.inverse_kinematics_from(&before, &task.pose).is_ok();
        match self.nominal.posture_change(&before, at, is_tracked) {
            None => Ok(()),
            Some(change) => {
                let (before_mm, here_mm) = (before.pose.translation, at.pose.translation);
                Err(CompensationStatus::ChangesPosture { change, before_mm, here_mm })
            }
        }
    }
}

/// Adds `turns` (mm or rad) to the drives of all `points` if the machine can be tracked there; returns whether it did.
fn add_turns(machine: &Machine, points: &mut Vec<TrackPoint>, turns: &[f64]) -> bool {
    let turned = |point: &TrackPoint| {
        let at = with_turns(point.at.clone()?, turns);
        let is_tracked = point.tracked.is_ok() && machine.drive_beyond_travel(&at.drives).is_none();
        is_tracked.then_some(TrackPoint { at: Some(at), tracked: Ok(()) })
    };
    let all: Option<Vec<TrackPoint>> = points.iter().map(turned).collect();
    let is_turned = all.is_some();
    *points = all.unwrap_or_else(|| std::mem::take(points));
    is_turned
}

/// Returns the configuration with `turns` (mm or rad) added to its drive positions.
fn with_turns(mut at: Configuration, turns: &[f64]) -> Configuration {
    at.drives.iter_mut().zip(turns).for_each(|(drive, turn)| *drive += turn);
    at
}
