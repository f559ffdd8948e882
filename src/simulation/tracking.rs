//! The nominal machine tracked along a path from point to point, and where it would have to change its posture.

use crate::{
    compensation::{CompensationStatus, TaskPoint},
    machine::{Configuration, Machine, SideBySide, Standing},
};

/// Where the nominal machine stands at a point of a path, if it reaches it, and why it cannot be tracked there, if it cannot.
#[derive(Debug, Clone)]
pub(crate) struct TrackPoint {
    pub at: Option<Configuration>,
    pub asked: Result<(), CompensationStatus>,
}

impl TrackPoint {
    /// Where the machine stands, if it can be there at all.
    fn stands(&self) -> Option<&Configuration> {
        self.at.as_ref().filter(|_| !matches!(self.asked, Err(CompensationStatus::Unreachable(_))))
    }
}

/// `nominal` tracked along each of `stretches`, as many of them at a time as the processor can, each from home, so that none waits for another;
/// [`join`] puts them behind one another. A stretch ends where `goes_on`, told its number and its points so far, says no.
pub(crate) fn tracked(
    nominal: &Machine,
    stretches: &[&[TaskPoint]],
    goes_on: impl Fn(usize, &[TrackPoint]) -> bool,
) -> Vec<Vec<TrackPoint>> {
    let mut storage = SideBySide::new(nominal);
    let mut track: Vec<LedAlong> = stretches.iter().map(|_| LedAlong::new(nominal)).collect();
    let mut points: Vec<Vec<TrackPoint>> = stretches.iter().map(|tasks| Vec::with_capacity(tasks.len())).collect();
    step_by_step(&mut track, stretches, &mut storage, |k, point| {
        points[k].push(point);
        goes_on(k, &points[k])
    });
    points
}

/// Puts stretches of a path that follow one another, each tracked from home, behind the point at which the machine stands as in `before`: it
/// goes on there, hinges at the turn that they have reached.
pub(crate) fn join<'a>(
    nominal: &Machine,
    before: Option<&Configuration>,
    stretches: impl Iterator<Item = (&'a [TaskPoint], &'a mut Vec<TrackPoint>)>,
) {
    if nominal.may_change_posture() {
        let mut track = LedAlong::new(nominal);
        track.before = before.cloned();
        stretches.for_each(|(tasks, points)| track.go_on_with(tasks, points));
    }
}

/// Where the machine stands at the last of `tracked` to which it can be tracked.
pub(crate) fn last_of(track: &[TrackPoint]) -> Option<&Configuration> {
    track.iter().rev().find_map(TrackPoint::stands)
}

/// Leads each machine along its tasks, all of them to their next points before any goes on. `take` gets each point with the number
/// of its machine, and says whether that goes on.
fn step_by_step(
    track: &mut [LedAlong],
    tasks: &[&[TaskPoint]],
    storage: &mut SideBySide,
    mut take: impl FnMut(usize, TrackPoint) -> bool,
) {
    let mut going: Vec<usize> = (0..track.len()).collect();
    for point in 0.. {
        going.retain(|&k| point < tasks[k].len());
        if going.is_empty() {
            break;
        }
        // With external axes each stands on a machine of its own.
        let plain: Vec<usize> = going.iter().copied().filter(|&k| tasks[k][point].external.is_none()).collect();
        let asked: Vec<_> = plain.iter().map(|&k| (&track[k].near, tasks[k][point].pose)).collect();
        let mut found = plain.iter().zip(storage.inverse_kinematics(&asked)).peekable();
        going.retain(|&k| {
            let straight = found.next_if(|(own, _)| **own == k).and_then(|(_, at)| at);
            let (at, asked) = track[k].step(&tasks[k][point], straight);
            take(k, TrackPoint { at, asked })
        });
    }
}

/// A machine on its way along a path.
struct LedAlong {
    nominal: Standing,
    /// From where the next point is sought.
    near: Configuration,
    /// Where the machine stands at the point before: `near`, but at the beginning. `None` there, and of machines that have one posture.
    before: Option<Configuration>,
}

impl LedAlong {
    /// A machine at home.
    fn new(nominal: &Machine) -> Self {
        Self { nominal: Standing::new(nominal), near: nominal.home.clone(), before: None }
    }

    /// Puts `points` of `tasks`, which were tracked from home, behind the point before; gives its place to the last of them.
    fn go_on_with(&mut self, tasks: &[TaskPoint], points: &mut Vec<TrackPoint>) {
        if let (Some(before), Some(first)) =
            (self.before.clone(), points.iter().position(|point| point.stands().is_some()))
        {
            self.go_on_behind(&before, tasks, points, first);
        }
        if let Some(last) = last_of(points) {
            self.before = Some(last.clone());
        }
    }

    /// As `go_on_with`, where `first` of the points is the first to which the machine can be tracked, and the one before is known.
    fn go_on_behind(
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
        let turns = self.nominal.turns_towards(&from_home.drives, &there.as_ref().unwrap_or(before).drives);
        let is_turned = turns.iter().all(|turn| *turn == 0.0) || turn(&self.nominal, points, &turns);
        if let (true, Some(at)) = (is_turned, points[first].at.clone())
            && there.as_ref().is_none_or(|there| self.nominal.is_beside(there, &at))
        {
            points[first].asked = self.keep_posture(&at, there.is_some(), task);
            return;
        }
        // From where the machine stands or, where no straight way leads on, from home at the same turn.
        self.near = match there {
            Some(_) => before.clone(),
            None => with_turns(self.nominal.original().home.clone(), &turns),
        };
        for (task, point) in tasks.iter().zip(points) {
            let (at, asked) = self.step(task, None);
            *point = TrackPoint { at, asked };
        }
    }

    /// The configuration at the next point, if it can be reached, and why the machine cannot be tracked there, if it cannot: also where it
    /// would stand in another posture than at the point before. `straight`: the configuration to which the straight line leads, where
    /// it was found before.
    fn step(
        &mut self,
        task: &TaskPoint,
        straight: Option<Configuration>,
    ) -> (Option<Configuration>, Result<(), CompensationStatus>) {
        if let Err(unreachable) = self.nominal.move_to(task.external) {
            return (None, Err(CompensationStatus::Unreachable(unreachable)));
        }
        let is_from_before = self.before.as_ref() == Some(&self.near);
        let straight = match straight {
            Some(at) => Ok(at),
            None => self.nominal.inverse_kinematics_from(&self.near, &task.pose),
        };
        let is_tracked = straight.is_ok();
        let at = match straight.or_else(|_| self.nominal.inverse_kinematics(&task.pose)) {
            Ok(at) => at,
            Err(unreachable) => return (None, Err(CompensationStatus::Unreachable(unreachable))),
        };
        self.near.clone_from(&at);
        let kept = match self.nominal.check_tracked(&task.pose, &at) {
            Ok(()) if self.nominal.may_change_posture() => self.keep_posture(&at, is_tracked && is_from_before, task),
            Ok(()) => Ok(()),
            Err(unreachable) => Err(CompensationStatus::Unreachable(unreachable)),
        };
        (Some(at), kept)
    }

    /// Whether the machine at `at`, which meets `task`, stands in the posture of the point before. `is_tracked`: whether the straight line
    /// is known to lead from there.
    fn keep_posture(
        &mut self,
        at: &Configuration,
        is_tracked: bool,
        task: &TaskPoint,
    ) -> Result<(), CompensationStatus> {
        let Some(before) = self.before.replace(at.clone()) else { return Ok(()) };
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

/// Takes the hinges of `points` as many `turns` (mm or rad) farther, if the machine can be tracked so to all of them; whether it can.
fn turn(machine: &Machine, points: &mut Vec<TrackPoint>, turns: &[f64]) -> bool {
    let turned = |point: &TrackPoint| {
        let at = with_turns(point.at.clone()?, turns);
        let is_tracked = point.asked.is_ok() && machine.drive_beyond_travel(&at.drives).is_none();
        is_tracked.then_some(TrackPoint { at: Some(at), asked: Ok(()) })
    };
    let all: Option<Vec<TrackPoint>> = points.iter().map(turned).collect();
    let is_turned = all.is_some();
    *points = all.unwrap_or_else(|| std::mem::take(points));
    is_turned
}

fn with_turns(mut at: Configuration, turns: &[f64]) -> Configuration {
    at.drives.iter_mut().zip(turns).for_each(|(drive, turn)| *drive += turn);
    at
}
