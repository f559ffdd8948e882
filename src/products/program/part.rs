//! Splits a program into parts, so that memory does not grow with its length: task points of a part are computed when needed.

use std::{borrow::Cow, ops::Range, sync::OnceLock};

use super::ProgramJob;
use crate::{
    compensation::{CompensationStatus, TaskPoint},
    input::error::{Error, Result},
    machine::{Configuration, Machine, PostureChange},
    process::{
        CutPath,
        cutting::{Corners, LoadError},
        file::Process,
        uncertainty::DrawnForceAt,
    },
    simulation::{
        along_path::{BLOCK, PART, PathCase, TrackBlocks, last_configuration, parts, track_blocks},
        spread_along::SpreadPart,
        tasks::{against_bend, drawn_force_at, unloaded_tasks},
        tracking::TrackPoint,
    },
    spatial::Pose,
    toolpath::{
        PathPoint, Toolpath,
        robot::{ArmData, ArmPosture},
    },
};

/// A range of consecutive points of a program with their task points.
#[derive(Debug, Clone)]
pub struct Part<'a> {
    /// Index of the first point.
    pub first: usize,
    /// Points of the path.
    pub points: &'a [PathPoint],
    tasks: Vec<TaskPoint>,
    forces: Vec<DrawnForceAt>,
}

impl Part<'_> {
    /// Returns the task points (pose and load) of the part.
    pub fn tasks(&self) -> &[TaskPoint] {
        &self.tasks
    }

    /// Returns what draws change of the force at each; nothing where one factor is for all of it.
    pub(super) fn forces(&self) -> &[DrawnForceAt] {
        &self.forces
    }

    /// Returns the part with the poses of P that a program commands, along which the nominal machine is tracked, as one whose spread is wanted.
    pub(super) fn to_spread<'a>(&'a self, track: &'a TrackBlocks<'a>, written: &'a [Pose]) -> SpreadPart<'a> {
        SpreadPart { first: self.first, tasks: &self.tasks, forces: &self.forces, track, written: Some(written) }
    }

    /// Returns the indices of its points.
    pub fn range(&self) -> Range<usize> {
        self.first..self.first + self.points.len()
    }

    /// Returns the part as a path to solve: `nominal` computes commands, `actual` is the actual machine; deflections begin at rest of `unloaded`.
    pub(super) fn case<'a>(&'a self, [nominal, actual, unloaded]: [&'a Machine; 3]) -> PathCase<'a> {
        PathCase { nominal, actual, unloaded, before: None, tasks: &self.tasks, play: true }
    }

    /// Returns the part with each task point changed by `change`.
    pub fn with_tasks(&self, change: impl Fn(&TaskPoint) -> TaskPoint) -> Self {
        Self { tasks: self.tasks.iter().map(change).collect(), ..self.clone() }
    }
}

/// Most points of a program that is corrected within limits, since that solves all points at once.
const MAX_AT_ONCE: usize = 200_000;

/// Tracked points of the nominal machine along a part, block by block.
pub(super) type TrackPart = Vec<Vec<TrackPoint>>;

/// Most points of a program whose tracked configurations are stored; those of longer programs are computed anew for each pass.
const MAX_STORED: usize = 200_000;

/// Returns empty storage for the tracked points of each part of `path`; no storage at all if the path is too long.
pub(super) fn empty_tracks(path: &Toolpath) -> Vec<OnceLock<TrackPart>> {
    if path.len() > MAX_STORED { Vec::new() } else { parts(path.len()).map(|_| OnceLock::new()).collect() }
}

/// Returns the task points of `path`, called `name` in errors, for a platform with parasitic rotation; `None` for others.
pub(super) fn stored_tasks(process: &Process, path: &CutPath, name: &str) -> Result<Option<Vec<TaskPoint>>> {
    let all = || (0..path.len()).map(task_at(process, path)).collect::<std::result::Result<_, _>>();
    let fault = |fault: LoadError| Error::argument(name, fault.to_string());
    process.machine.has_parasitic_rotation.then(all).transpose().map_err(fault)
}

/// Returns how the arm of `machine` stands with its drives at `drives` (mm, rad); `None` unless it ends in six revolute joints.
pub(super) fn arm_posture(machine: &Machine, drives: &[f64]) -> Option<ArmPosture> {
    machine.branch_and_angles(drives).map(|(branch, angles)| ArmPosture { branch, angles })
}

/// Returns a function from the index of a point of `path` to its task point, to be called in order, since the force blends from move to move.
pub(super) fn task_at<'a>(
    process: &'a Process,
    path: &'a CutPath,
) -> impl FnMut(usize) -> std::result::Result<TaskPoint, LoadError> + use<'a> {
    let mut unloaded = unloaded_tasks(&process.machine, &process.placement, process.target, path);
    let mut corners = Corners::new(process, path);
    move |k| {
        let (task, there) = unloaded(&path.points()[k]);
        let load = there.wrench(&corners.load(k, &there)?);
        Ok(TaskPoint { load, aside: against_bend(path, k, &there), ..task })
    }
}

impl ProgramJob {
    /// Returns the tracked points of the nominal machine along `part` from the configuration `before`, and sets that to the end of the part.
    pub(super) fn track(&self, part: &Part<'_>, before: &mut Option<Configuration>) -> Cow<'_, [Vec<TrackPoint>]> {
        let find = || track_blocks(&self.machine, before.as_ref(), part.tasks(), |_, _| true);
        let track = match self.part_tracks.get(part.first / PART) {
            Some(track) => Cow::Borrowed(track.get_or_init(find).as_slice()),
            None => Cow::Owned(find()),
        };
        if let Some(last) = last_configuration(&track) {
            *before = Some(last.clone());
        }
        track
    }

    /// Stores the tracked points of `part`, if the program is short enough.
    pub(super) fn store_track(&self, part: &Part<'_>, track_part: TrackPart) {
        if let Some(track) = self.part_tracks.get(part.first / PART) {
            track.get_or_init(|| track_part);
        }
    }

    /// Checks that the arm stands at each point as the program says, if it does.
    ///
    /// # Errors
    /// It does not: with the line, what the program says there, and how the arm stands.
    pub(super) fn check_postures(&self) -> Result<()> {
        if !self.machine.may_change_posture() || self.path.points().iter().all(|point| point.arm.is_none()) {
            return Ok(());
        }
        let contradicts = |point: &TrackPoint| {
            matches!(point.tracked, Err(CompensationStatus::ChangesPosture { change: PostureChange::Contradicts, .. }))
        };
        let mut before = None;
        for part in self.parts() {
            let part = part?;
            let track = self.track(&part, &mut before);
            for (start, points) in (0..).step_by(BLOCK).zip(track.iter()) {
                if let Some(k) = points.iter().position(contradicts) {
                    return Err(self.contradiction(part.first + start + k, &part.tasks()[start + k], &points[k]));
                }
            }
        }
        Ok(())
    }

    /// Returns the error that the arm does not stand at point `k` of the path, the task `task`, as the program says, but as in `found`.
    fn contradiction(&self, k: usize, task: &TaskPoint, found: &TrackPoint) -> Error {
        let point = &self.path.points()[k];
        let line = self.file.line_name(point.source.segment).unwrap_or_default();
        let Some(said) = point.arm else { return Error::argument(&self.name, line) };
        let with_data = |drives: &[f64]| {
            let posture = arm_posture(&self.machine, drives)?;
            let data = ArmData::of_posture(said.language, &posture)?.text();
            Some(format!("{data} ({})", posture.text()))
        };
        let how = match &found.at {
            Some(at) if !said.is_taken => {
                format!("the arm comes there with {}", with_data(&at.drives).unwrap_or_default())
            }
            _ => {
                let postures = self.machine.postures_at(&task.pose);
                let within = postures.iter().filter(|posture| posture.limits.is_ok());
                let known: Vec<String> = within.filter_map(|posture| with_data(&posture.at.drives)).collect();
                format!("within its travel the arm meets this pose with {}", known.join("; "))
            }
        };
        let problem = format!(
            "{line}: {}, but {how}: expected what is so on the robot, or ignore_configuration = true in [robot_program] of the process \
             where its drives count otherwise than those of the machine",
            said.text()
        );
        Error::argument(&self.name, problem)
    }

    /// Returns the parts of the program, in order.
    ///
    /// # Errors
    /// In practice none: every point of a program that was read has a load.
    pub fn parts(&self) -> impl Iterator<Item = Result<Part<'_>>> {
        let process = &self.process;
        let mut task = task_at(process, &self.path);
        let mut components: Vec<_> = self.components.iter().map(|process| task_at(process, &self.path)).collect();
        let has_tools = self.uncertainty.as_ref().is_some_and(|own| own.tools.len() > 1);
        parts(self.path.len()).map(move |range| {
            let (first, points) = (range.start, &self.path.points()[range.clone()]);
            let fault = |fault: LoadError| Error::argument(&self.name, fault.to_string());
            let along = |task: &mut dyn FnMut(usize) -> std::result::Result<TaskPoint, LoadError>| {
                range.clone().map(task).collect::<std::result::Result<Vec<_>, _>>().map_err(fault)
            };
            let components = components.iter_mut().map(|task| along(task)).collect::<Result<Vec<_>>>()?;
            let tool = |point: &PathPoint| {
                self.uncertainty.as_ref().map_or(0, |own| own.tool_index(point.tool.filter(|_| point.cutting)))
            };
            let at = |(k, point): (usize, &PathPoint)| drawn_force_at(tool(point), &components, k);
            let is_asked = has_tools || !components.is_empty();
            let forces = points.iter().enumerate().filter(|_| is_asked).map(at).collect();
            let tasks = match &self.tasks {
                Some(tasks) => tasks[range.clone()].to_vec(),
                None => along(&mut task)?,
            };
            Ok(Part { first, points, tasks, forces })
        })
    }

    /// Returns the task points of the whole program; an error if it has more than [`MAX_AT_ONCE`] points.
    pub(super) fn all_tasks(&self) -> Result<Vec<TaskPoint>> {
        let points = self.path.len();
        if points > MAX_AT_ONCE {
            let problem = format!(
                "bounded corrects the whole path at once: {points} points, expected at most {MAX_AT_ONCE}; a coarser \
                 [sampling] or a part of the program has fewer"
            );
            return Err(Error::argument("--method", problem));
        }
        let mut tasks = Vec::with_capacity(points);
        for part in self.parts() {
            tasks.extend_from_slice(part?.tasks());
        }
        Ok(tasks)
    }

    /// Returns index and reason of the first cutting points to which the rigid machine cannot be tracked, at most `most`. Stops at the part
    /// of the first such point; calls `done` after each part with the number of its points.
    ///
    /// # Errors
    /// As [`ProgramJob::parts`].
    pub fn untrackable_points(&self, most: usize, mut done: impl FnMut(usize)) -> Result<Vec<(usize, String)>> {
        let mut before = None;
        for part in self.parts() {
            let part = part?;
            let found = self.untrackable_in_part(&part, &mut before, most);
            done(part.points.len());
            if !found.is_empty() {
                return Ok(found);
            }
        }
        Ok(Vec::new())
    }

    /// Returns the untrackable cutting points of `part`, at most `most`; if there are none, stores the track and moves `before` to its end.
    fn untrackable_in_part(
        &self,
        part: &Part<'_>,
        before: &mut Option<Configuration>,
        most: usize,
    ) -> Vec<(usize, String)> {
        let is_out = |k: usize, at: &TrackPoint| part.points[k].cutting && at.tracked.is_err();
        let lost = |start: usize, track: &[TrackPoint]| (start..).zip(track).filter(|(k, at)| is_out(*k, at)).count();
        // What is out of reach takes longest.
        let track = track_blocks(&self.machine, before.as_ref(), part.tasks(), |start, track| {
            track.last().is_none_or(|at| at.tracked.is_ok()) || lost(start, track) < most
        });
        let mut untrackable = Vec::new();
        for (start, track) in (0..).step_by(BLOCK).zip(&track) {
            for (k, at) in (start..).zip(track) {
                if let (true, Err(status)) = (is_out(k, at), &at.tracked) {
                    untrackable.push((part.first + k, status.reason(&self.machine)));
                }
            }
        }
        if untrackable.is_empty() {
            *before = last_configuration(&track).cloned().or(before.take());
            self.store_track(part, track);
        }
        untrackable.truncate(most);
        untrackable
    }
}
