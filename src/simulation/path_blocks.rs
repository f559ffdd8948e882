//! Solves blocks of a path: the points of a block one after another, each from the one before, and several blocks at a time.

use super::{
    along_path::{Commands, PathCase, PathPointResult},
    play::PlayedPoint,
    settings,
    tracking::TrackPoint,
};
use crate::{
    compensation::{
        Compensation, CompensationStatus, Method, Session, TaskPoint, compensate_batch, find_targets, simulate_batch,
        simulate_drives,
    },
    machine::{Configuration, Machine},
    spatial::Pose,
    statics::Batch,
};

/// A block of a path: the index of its first point, and the nominal machine tracked along it.
pub(crate) type TrackedBlock<'a> = (usize, &'a [TrackPoint]);

/// A block being solved.
struct OpenBlock<'a> {
    session: Session,
    /// Index of its first point.
    first: usize,
    track: &'a [TrackPoint],
    /// Configuration at which the nominal machine was last tracked.
    near: &'a Configuration,
    answers: Vec<PathPointResult>,
}

/// Solves `tracked` blocks of `case`; an error of `done` ends everything.
pub(crate) fn solve_blocks<'a, E>(
    case: &PathCase<'a>,
    commands: &Commands<'_>,
    tracked: &[TrackedBlock<'a>],
    done: &(dyn Fn() -> Result<(), E> + Sync),
) -> Result<Vec<Vec<PathPointResult>>, E> {
    let begin = |&(first, track): &TrackedBlock<'a>| {
        let mut session = Session::new(case.nominal, case.actual, settings()).with_unloaded_machine(case.unloaded);
        // From home the way would be long, and might end on another branch.
        let near = track.first().and_then(|point| point.at.as_ref()).filter(|_| case.tasks[first].external.is_none());
        if let Some(at) = near {
            session.set_rigid(at);
        }
        let (near, answers) = (near.unwrap_or(&case.nominal.home), Vec::with_capacity(track.len()));
        OpenBlock { session, first, track, near, answers }
    };
    let mut blocks: Vec<OpenBlock<'a>> = tracked.iter().map(begin).collect();
    let mut batch = Batch::new(case.actual);
    for point in 0..tracked.iter().map(|(_, track)| track.len()).max().unwrap_or(0) {
        let mut going: Vec<&mut OpenBlock<'a>> = blocks.iter_mut().filter(|block| point < block.track.len()).collect();
        let found = solve_points(case, commands, point, &mut going, &mut batch);
        for (block, found) in going.into_iter().zip(found) {
            let answer = block.result(case, commands, point, found);
            block.answers.push(answer);
            done()?;
        }
    }
    Ok(blocks.into_iter().map(|block| block.answers).collect())
}

/// Solves the point number `point` of each block, all blocks together.
fn solve_points(
    case: &PathCase<'_>,
    commands: &Commands<'_>,
    point: usize,
    blocks: &mut [&mut OpenBlock<'_>],
    batch: &mut Batch,
) -> Vec<Compensation> {
    let asked: Vec<TaskPoint> = blocks.iter().map(|block| case.tasks[block.first + point]).collect();
    for (block, task) in blocks.iter_mut().zip(&asked) {
        block.seed_command(case.nominal, point, task);
    }
    // With external axes each stands on a machine of its own.
    let together = if asked.iter().any(|task| task.external.is_some()) { 1 } else { blocks.len() };
    let mut found = Vec::with_capacity(blocks.len());
    for (blocks, asked) in blocks.chunks_mut(together.max(1)).zip(asked.chunks(together.max(1))) {
        found.extend(solve_group(case, commands, point, blocks, asked, batch));
    }
    found
}

/// Returns command and equilibrium at point number `point` of each block; where the machine cannot be tracked, the reason.
fn solve_group(
    case: &PathCase<'_>,
    commands: &Commands<'_>,
    point: usize,
    blocks: &mut [&mut OpenBlock<'_>],
    asked: &[TaskPoint],
    batch: &mut Batch,
) -> Vec<Compensation> {
    let places: Vec<usize> = blocks.iter().map(|block| block.first + point).collect();
    let reached: Vec<usize> = (0..blocks.len()).filter(|&k| blocks[k].track[point].tracked.is_ok()).collect();
    let tasks: Vec<TaskPoint> = reached.iter().map(|&k| asked[k]).collect();
    let mut sessions: Vec<&mut Session> =
        blocks.iter_mut().filter(|block| block.track[point].tracked.is_ok()).map(|block| &mut block.session).collect();
    let solved = match commands {
        Commands::Method(method) => compensate_batch(&mut sessions, &tasks, *method, batch),
        Commands::Program(poses) => {
            let targets: Vec<Pose> = reached.iter().map(|&k| poses[places[k]]).collect();
            let simulated = simulate_batch(&mut sessions, &tasks, &targets, batch);
            let with_points = sessions.iter().zip(&tasks).zip(&targets).zip(simulated);
            // The controller leads the same point of the platform.
            let checked = with_points.map(|(((session, task), target), simulated)| {
                match case.nominal.check_tracked(target, session.command()) {
                    Err(unreachable) if simulated.outcome.is_some() => {
                        session.refused(task, CompensationStatus::Unreachable(unreachable))
                    }
                    _ => simulated,
                }
            });
            checked.collect()
        }
        Commands::Drives(drives) => {
            let given = sessions.iter_mut().zip(&tasks).zip(&reached);
            given.map(|((session, task), &k)| simulate_drives(session, task, &drives[places[k]])).collect()
        }
    };
    if let Commands::Method(_) = commands {
        find_targets(&mut sessions);
    }
    let mut solved = solved.into_iter();
    let answers = blocks.iter().zip(asked).map(|(block, task)| match &block.track[point].tracked {
        Err(reason) => Some(block.session.refused(task, reason.clone())),
        Ok(()) => solved.next().map(|found| match block.full_turn_jump(case.nominal, point, commands, &found) {
            Some(change) => block.session.refused(task, change),
            None => found,
        }),
    });
    answers.flatten().collect()
}

impl<'a> OpenBlock<'a> {
    /// Gives the session the tracked configuration at `point` as its command for `task`.
    fn seed_command(&mut self, nominal: &Machine, point: usize, task: &TaskPoint) {
        if let (Some(at), true) = (&self.track[point].at, task.led.is_some()) {
            // Near a pole of the head another posture is as near as the one that the program names.
            self.session.set_rigid(at);
        } else if let (Some(at), None) = (&self.track[point].at, task.external) {
            // A motion from point to point may end in another posture, to which no straight line leads.
            if task.asked.is_some() && nominal.posture_change(self.near, at, false).is_some() {
                self.session.set_rigid(at);
            }
            self.session.seed(self.near, &task.pose, at);
            self.near = at;
        }
    }

    /// Returns a posture change if the corrected command turns a revolute joint back within its travel where the path goes on; `None` if not, and for
    /// commands that are drive positions.
    fn full_turn_jump(
        &self,
        nominal: &Machine,
        point: usize,
        commands: &Commands<'_>,
        found: &Compensation,
    ) -> Option<CompensationStatus> {
        let at = self.track[point]
            .at
            .as_ref()
            .filter(|_| found.outcome.is_some() && !matches!(commands, Commands::Drives(_)))?;
        let change = nominal.full_turn_jump(&at.drives, &found.drives)?;
        let here_mm = at.pose.translation;
        Some(CompensationStatus::ChangesPosture { change, before_mm: here_mm, here_mm })
    }

    /// Returns the result of `commands` at point number `point` of the block from its compensation, with the play of the drives.
    fn result(
        &mut self,
        case: &PathCase<'_>,
        commands: &Commands<'_>,
        point: usize,
        mut found: Compensation,
    ) -> PathPointResult {
        let mut target = found.outcome.as_ref().and_then(|_| self.session.target().ok());
        let play = self.track[point].at.as_ref().and_then(|at| {
            let is_given = !matches!(commands, Commands::Method(method) if *method != Method::None);
            let played = PlayedPoint { case, task: &case.tasks[self.first + point], at, is_given };
            played.add(&mut self.session, &mut found, &mut target)
        });
        PathPointResult {
            is_settled: found.outcome.is_some(),
            corrections: found.iterations(),
            target,
            status: found.status,
            drives: found.drives,
            nominal_drives: self.track[point].at.as_ref().map(|at| at.drives.clone()).unwrap_or_default(),
            position_error: found.position_error,
            residual_rotation: found.residual_rotation,
            drive_forces: found.drive_forces,
            play,
        }
    }
}
