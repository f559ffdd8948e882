//! A program in parts, so that memory does not grow with it: what is wanted at the points of a part is found when it is needed.

use std::{borrow::Cow, ops::Range, sync::OnceLock};

use super::{ProgramJob, corners::Corners};
use crate::{
    compensation::TaskPoint,
    input::error::{Error, Result},
    machine::{Configuration, Machine},
    process::{cutting::LoadError, file::Process},
    simulation::{
        along_path::{BLOCK, PART, PathCase, last_of_blocks, lead, parts},
        tasks::unloaded,
        tracking::TrackPoint,
    },
    toolpath::{PathPoint, Toolpath},
};

/// Points of a program that follow one another.
#[derive(Debug, Clone)]
pub struct Part<'a> {
    /// Index of the first of them.
    pub first: usize,
    /// The points.
    pub points: &'a [PathPoint],
    tasks: Vec<TaskPoint>,
}

impl Part<'_> {
    /// What is wanted at its points, under load.
    pub fn tasks(&self) -> &[TaskPoint] {
        &self.tasks
    }

    /// Indices of its points.
    pub fn range(&self) -> Range<usize> {
        self.first..self.first + self.points.len()
    }

    /// These points to be solved: `nominal` computes commands, `real` answers them, deflections are measured from the rest of `unloaded`.
    pub(super) fn case<'a>(&'a self, [nominal, real, unloaded]: [&'a Machine; 3]) -> PathCase<'a> {
        PathCase { nominal, real, unloaded, before: None, tasks: &self.tasks }
    }

    /// The same points, something else wanted of them.
    pub fn asked(&self, other: impl Fn(&TaskPoint) -> TaskPoint) -> Self {
        Self { tasks: self.tasks.iter().map(other).collect(), ..self.clone() }
    }
}

/// Most points of a program that is corrected within limits: of all of them at once.
const MOST_AT_ONCE: usize = 200_000;

/// Where the nominal machine is tracked along a part, block by block.
pub(super) type TrackPart = Vec<Vec<TrackPoint>>;

/// Of a program of at most so many points, where the machine is tracked is found once; of a longer one whenever it is needed.
const LED_ONCE: usize = 200_000;

/// Where the machine is tracked along the parts of `path`, none found yet.
pub(super) fn track(path: &Toolpath) -> Vec<OnceLock<TrackPart>> {
    if path.len() > LED_ONCE { Vec::new() } else { parts(path.len()).map(|_| OnceLock::new()).collect() }
}

/// What is wanted at points of `path`, asked for one after another by their indices: the force goes over from one move to the next.
pub(super) fn task_at<'a>(
    process: &'a Process,
    path: &'a Toolpath,
) -> impl FnMut(usize) -> std::result::Result<TaskPoint, LoadError> + use<'a> {
    let mut unloaded = unloaded(&process.machine, &process.placement, process.target, path);
    let mut corners = Corners::new(process, path);
    move |k| {
        let (task, there) = unloaded(&path.points()[k]);
        Ok(TaskPoint { load: there.wrench(&corners.load(k, &there)?), ..task })
    }
}

impl ProgramJob {
    /// Where the machine is tracked along `part`, which follows what it was tracked along `before`; `before` then stands at its end.
    pub(super) fn tracking(&self, part: &Part<'_>, before: &mut Option<Configuration>) -> Cow<'_, [Vec<TrackPoint>]> {
        let find = || lead(&self.machine, before.as_ref(), part.tasks(), |_, _| true);
        let track = match self.track.get(part.first / PART) {
            Some(track) => Cow::Borrowed(track.get_or_init(find).as_slice()),
            None => Cow::Owned(find()),
        };
        if let Some(last) = last_of_blocks(&track) {
            *before = Some(last.clone());
        }
        track
    }

    /// Notes where the machine is tracked along `part`.
    pub(super) fn keep_tracked(&self, part: &Part<'_>, found: TrackPart) {
        if let Some(track) = self.track.get(part.first / PART) {
            track.get_or_init(|| found);
        }
    }

    /// The parts of the program, in order.
    ///
    /// # Errors
    /// None in fact: there is a load at every point of a program that was read.
    pub fn parts(&self) -> impl Iterator<Item = Result<Part<'_>>> {
        let process = &self.process;
        let mut task = task_at(process, &self.path);
        parts(self.path.len()).map(move |range| {
            let (first, points) = (range.start, &self.path.points()[range.clone()]);
            let tasks = match &self.kept {
                Some(kept) => kept[range].to_vec(),
                None => range
                    .map(&mut task)
                    .collect::<std::result::Result<_, _>>()
                    .map_err(|fault| Error::argument(&self.name, fault.to_string()))?,
            };
            Ok(Part { first, points, tasks })
        })
    }

    /// What is wanted at all points.
    ///
    /// # Errors
    /// Too many points.
    pub(super) fn all_tasks(&self) -> Result<Vec<TaskPoint>> {
        let points = self.path.len();
        if points > MOST_AT_ONCE {
            let problem = format!(
                "bounded corrects the whole path at once: {points} points, expected at most {MOST_AT_ONCE}; a coarser \
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

    /// The first points at which the tool cuts and to which the rigid machine cannot be tracked: index and reason. Their number is at most
    /// `most`, and nothing is looked at far beyond them. `done` is called with the number of points looked at, after each part.
    ///
    /// # Errors
    /// As [`ProgramJob::parts`].
    pub fn out_of_reach(&self, most: usize, mut done: impl FnMut(usize)) -> Result<Vec<(usize, String)>> {
        let mut before = None;
        for part in self.parts() {
            let part = part?;
            let found = self.out_of_reach_in(&part, &mut before, most);
            done(part.points.len());
            if !found.is_empty() {
                return Ok(found);
            }
        }
        Ok(Vec::new())
    }

    fn out_of_reach_in(
        &self,
        part: &Part<'_>,
        before: &mut Option<Configuration>,
        most: usize,
    ) -> Vec<(usize, String)> {
        let is_out = |k: usize, at: &TrackPoint| part.points[k].cutting && at.asked.is_err();
        let out = |start: usize, track: &[TrackPoint]| (start..).zip(track).filter(|(k, at)| is_out(*k, at)).count();
        // What is out of reach takes longest.
        let track = lead(&self.machine, before.as_ref(), part.tasks(), |start, track| {
            track.last().is_none_or(|at| at.asked.is_ok()) || out(start, track) < most
        });
        let mut found = Vec::new();
        for (start, track) in (0..).step_by(BLOCK).zip(&track) {
            for (k, at) in (start..).zip(track) {
                if let (true, Err(status)) = (is_out(k, at), &at.asked) {
                    found.push((part.first + k, status.reason(&self.machine)));
                }
            }
        }
        if found.is_empty() {
            *before = last_of_blocks(&track).cloned().or(before.take());
            self.keep_tracked(part, track);
        }
        found.truncate(most);
        found
    }
}
