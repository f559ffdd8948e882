//! Compensation or simulation of one task point for each of several sessions, several at a time.

use std::cell::RefCell;

use nalgebra::Vector6;

use super::{
    Method, compensate, direct,
    outcome::{Compensation, CompensationStatus},
    session::{Ending, Progress, Session},
    task_point::TaskPoint,
};
use crate::{
    machine::{BatchKinematics, Configuration, Machine},
    spatial::Pose,
    statics::{Batch, Case, Level, Outcome, TaskError},
};

/// Compensates each task by its session as [`compensate`] does, with the same results to the last bit.
///
/// The sessions share their settings and their machines, and `batch` is one of their real machine. Without compensation
/// and with the direct method, as many equilibria are solved at a time as the processor can; sessions that come with the
/// same `batch` in the same order again save work.
pub fn compensate_batch(
    sessions: &mut [&mut Session],
    asked: &[TaskPoint],
    method: Method,
    batch: &mut Batch,
) -> Vec<Compensation> {
    debug_assert_eq!(sessions.len(), asked.len());
    let wanted: Vec<_> = sessions.iter_mut().zip(asked).map(|(session, task)| session.with_wanted_pose(task)).collect();
    let all = wanted.iter().zip(asked).map(|(wanted, task)| *wanted.as_ref().unwrap_or(task));
    let tasks: &[TaskPoint] = &all.collect::<Vec<_>>();
    let histories: Vec<History> = tasks.iter().map(|_| History::default()).collect();
    let outcomes = match method {
        Method::None | Method::Direct => batch_equilibria(sessions, tasks, method, &histories, batch),
        _ => vec![None; sessions.len()],
    };
    if method == Method::Direct && sessions.first().is_some_and(|session| session.nominal.has_limits()) {
        let solved = sessions.iter_mut().zip(&outcomes).filter(|(_, outcome)| outcome.is_some());
        find_targets(&mut solved.map(|(session, _)| &mut **session).collect::<Vec<_>>());
    }
    let mut endings: Vec<Option<(Ending, Vec<f64>)>> = vec![None; sessions.len()];
    if method == Method::Direct {
        let chosen = sessions.iter_mut().zip(tasks).zip(&wanted).zip(&mut endings);
        let chosen =
            chosen.filter(|(((own, task), wanted), _)| wanted.is_ok() && !direct::determines_drives(own, task));
        let mut parts: Vec<PartialTask<'_>> =
            chosen.map(|(((session, task), _), ending)| PartialTask::new(session, task, ending)).collect();
        solve_partial(&mut parts, batch);
    }
    let mut results = Vec::with_capacity(sessions.len());
    let finished =
        sessions.iter_mut().zip(asked.iter().zip(tasks)).zip(outcomes).zip(histories).zip(wanted).zip(endings);
    for (((((session, (asked, task)), outcome), history), wanted), ending) in finished {
        if let Err(status) = wanted {
            results.push(session.conclude(task, Err(status), Vec::new()));
            continue;
        }
        if let Some((ending, history)) = ending {
            results.push(session.conclude(task, ending, history));
            continue;
        }
        let Some(outcome) = outcome else {
            results.push(compensate(session, asked, method));
            continue;
        };
        let mut progress = Progress::new();
        let ending = if method == Method::Direct {
            progress.history = history.into_inner();
            direct::accept_or_correct(session, task, Some(outcome), &mut progress)
        } else {
            session.accept_or_solve_anew(task, outcome).map(|outcome| {
                progress.history.push(session.task_error(task).size());
                (CompensationStatus::Applied, outcome)
            })
        };
        results.push(session.conclude(task, ending, progress.history));
    }
    results
}

/// Simulates the target of each task by its session as [`super::simulate`] does, with the same results to the last bit.
/// Sessions and `batch` as for [`compensate_batch`].
pub fn simulate_batch(
    sessions: &mut [&mut Session],
    asked: &[TaskPoint],
    targets: &[Pose],
    batch: &mut Batch,
) -> Vec<Compensation> {
    debug_assert!(sessions.len() == asked.len() && sessions.len() == targets.len());
    let Some(settings) = sessions.first().map(|session| session.settings.equilibrium) else { return Vec::new() };
    let wanted: Vec<_> = sessions.iter_mut().zip(asked).map(|(session, task)| session.with_wanted_pose(task)).collect();
    seed_sessions(sessions, targets);
    let mut begun = Vec::with_capacity(sessions.len());
    for ((session, wanted), target) in sessions.iter_mut().zip(wanted).zip(targets) {
        begun.push(wanted.map(|task| (task, session.command_pose(target))));
    }
    let mut cases: Vec<Case<'_>> = Vec::with_capacity(sessions.len());
    for (session, begun) in sessions.iter_mut().zip(&begun) {
        if let Ok((task, Ok(()))) = begun {
            let (drives, state) = (&mut session.drives, &mut session.state);
            cases.push(Case { drives, load: task.load, state, task: None });
        }
    }
    let mut outcomes = batch.equilibria(&mut cases, &settings).into_iter();
    let mut results = Vec::with_capacity(sessions.len());
    for ((session, asked), begun) in sessions.iter_mut().zip(asked).zip(begun) {
        let result = match begun {
            Err(status) => session.conclude(asked, Err(status), Vec::new()),
            Ok((task, gone)) => {
                let stable = gone.and_then(|()| match outcomes.next() {
                    Some(outcome) => session.accept_or_solve_anew(&task, outcome),
                    None => session.solve_stable(&task),
                });
                let history = vec![session.task_error(&task).size()];
                let ending = stable.map(|outcome| (CompensationStatus::Applied, outcome));
                session.conclude(&task, ending, history)
            }
        };
        results.push(result);
    }
    results
}

/// A task whose target is corrected, its session, and how its iteration ended.
pub(super) struct PartialTask<'a> {
    session: &'a mut Session,
    task: &'a TaskPoint,
    progress: Progress,
    ending: &'a mut Option<(Ending, Vec<f64>)>,
}

impl<'a> PartialTask<'a> {
    fn new(session: &'a mut Session, task: &'a TaskPoint, ending: &'a mut Option<(Ending, Vec<f64>)>) -> Self {
        Self { session, task, progress: Progress::new(), ending }
    }

    fn end(&mut self, ending: Ending) {
        *self.ending = Some((ending, std::mem::take(&mut self.progress.history)));
    }
}

/// Runs `solve` for one session alone, with the bits that it has among others; `progress` gets the history of its errors.
pub(super) fn solve_alone(
    session: &mut Session,
    task: &TaskPoint,
    progress: &mut Progress,
    solve: impl FnOnce(&mut [PartialTask<'_>], &mut Batch),
) -> Ending {
    let own = session.alone.take();
    let mut batch = own.unwrap_or_else(|| Box::new(Batch::at_level(&session.real, Level::One)));
    let mut ending = None;
    solve(&mut [PartialTask::new(session, task, &mut ending)], &mut batch);
    session.alone = Some(batch);
    let (ending, history) = ending.unwrap_or((Err(CompensationStatus::Slow), Vec::new()));
    progress.history = history;
    ending
}

/// Solves tasks that leave controlled coordinates as commanded: in one iteration with the nominal machine, or, where that fails, between
/// equilibria.
pub(super) fn solve_partial(parts: &mut [PartialTask<'_>], batch: &mut Batch) {
    let mut far: Vec<&mut PartialTask<'_>> =
        parts.iter_mut().filter(|own| !direct::is_near_last_point(own.session, own.task)).collect();
    let poses: Vec<Pose> = far.iter().map(|own| own.task.pose).collect();
    let outcomes = equilibria_at_poses(&mut far, &poses, batch);
    for (own, outcome) in far.into_iter().zip(outcomes) {
        if let Err(status) = outcome.and_then(|outcome| own.session.accept_or_solve_anew(own.task, outcome)) {
            own.end(Err(status));
        }
    }
    solve_with_command(parts, batch);
    correct_targets(parts, batch);
}

/// Largest accepted difference of the drives found from those of the inverse kinematics, as a share of the characteristic length.
const SAME_COMMAND: f64 = 1e-11;

/// Solves the loaded machine and its command in one iteration, as far as it converges and the inverse kinematics gives the same drives.
fn solve_with_command(parts: &mut [PartialTask<'_>], batch: &mut Batch) {
    let is_open = |own: &&mut PartialTask<'_>| own.ending.is_none() && direct::has_drive_per_control(own.session);
    let mut parts: Vec<&mut PartialTask<'_>> = parts.iter_mut().filter(is_open).collect();
    let Some(first) = parts.first() else { return };
    let (nominal, settings) = ((*first.session.nominal).clone(), first.session.settings.equilibrium);
    let tasks: Vec<TaskPoint> = parts.iter().map(|own| *own.task).collect();
    let histories: Vec<History> = parts.iter().map(|_| History::default()).collect();
    let errors: Vec<_> =
        tasks.iter().zip(&histories).map(|(task, history)| error_fn(&nominal, task, history)).collect();
    let mut poses: Vec<Pose> = tasks.iter().map(|task| task.pose).collect();
    let (mut cases, mut starts) = (Vec::with_capacity(parts.len()), Vec::with_capacity(parts.len()));
    for ((own, task), error) in parts.iter_mut().zip(&tasks).zip(&errors) {
        let Session { drives, state, command, .. } = &mut *own.session;
        cases.push(Case { drives, load: task.load, state, task: Some(error) });
        starts.push(&*command);
    }
    let outcomes = batch.equilibria_at_position(&nominal, &mut cases, &starts, &mut poses, &settings);
    drop(errors);
    let found = parts.into_iter().zip(outcomes).zip(poses).zip(histories);
    let found = found.filter_map(|(((own, outcome), pose), history)| Some((own, outcome?, pose, history.into_inner())));
    let mut found: Vec<(&mut PartialTask<'_>, Outcome, Pose, Vec<f64>)> = found.collect();
    let poses: Vec<Pose> = found.iter().map(|(_, _, pose, _)| *pose).collect();
    seed_sessions(&mut found.iter_mut().map(|(own, ..)| &mut *own.session).collect::<Vec<_>>(), &poses);
    for (own, outcome, pose, history) in found {
        let (drives, before) = (own.session.drives.clone(), own.session.command.clone());
        let is_same = own.session.command_pose(&pose).is_ok() && own.session.drive_difference(&drives) <= SAME_COMMAND;
        // A soft machine may stand beside a singular place, which the equilibria one by one tell.
        let is_met =
            own.session.task_error(own.task).size() <= own.session.tolerance_mm() && !outcome.is_soft(&nominal);
        if is_same && is_met {
            own.session.command.drives.clone_from(&drives);
            own.session.drives = drives;
            own.progress.history = history;
            own.end(Ok((CompensationStatus::Converged, outcome)));
            continue;
        }
        own.session.drives.clone_from(&before.drives);
        own.session.command = before;
        if let Err(status) = own.session.reset_to_nominal(own.task) {
            own.end(Err(status));
        }
    }
}

/// Corrects the target of each task by the sensitivities between equilibria, from the nominal command, until its iteration is over.
pub(super) fn correct_targets(parts: &mut [PartialTask<'_>], batch: &mut Batch) {
    let mut shifts: Vec<direct::TargetShift> =
        parts.iter().map(|own| direct::TargetShift::new(own.session, own.task)).collect();
    loop {
        let going = parts.iter_mut().zip(&mut shifts).filter(|(own, _)| own.ending.is_none());
        let (mut going, shifts): (Vec<&mut PartialTask<'_>>, Vec<&mut direct::TargetShift>) = going.unzip();
        if going.is_empty() {
            return;
        }
        let poses =
            going.iter().zip(&shifts).map(|(own, shift)| own.task.shifted_pose(&own.session.nominal, &shift.shift));
        let poses: Vec<Pose> = poses.collect();
        let outcomes = equilibria_at_poses(&mut going, &poses, batch);
        for ((own, shift), outcome) in going.into_iter().zip(shifts).zip(outcomes) {
            let PartialTask { session, task, progress, .. } = own;
            let next = session.simulated(task, &shift.shift, outcome).and_then(|(residual, outcome)| {
                Ok(shift.correct(session, &residual, &outcome, progress)?.map(|status| (status, outcome)))
            });
            match next {
                Ok(None) => {}
                Ok(Some(ending)) => own.end(Ok(ending)),
                Err(status) => own.end(Err(status)),
            }
        }
    }
}

/// Commands each session its pose and solves the equilibrium there; `Err` where the pose cannot be commanded.
fn equilibria_at_poses(
    parts: &mut [&mut PartialTask<'_>],
    poses: &[Pose],
    batch: &mut Batch,
) -> Vec<Result<Outcome, CompensationStatus>> {
    let mut sessions: Vec<&mut Session> = parts.iter_mut().map(|own| &mut *own.session).collect();
    let Some(settings) = sessions.first().map(|session| session.settings.equilibrium) else { return Vec::new() };
    seed_sessions(&mut sessions, poses);
    let gone: Vec<_> = sessions.iter_mut().zip(poses).map(|(session, pose)| session.command_pose(pose)).collect();
    let mut cases: Vec<Case<'_>> = Vec::with_capacity(sessions.len());
    for (own, _) in parts.iter_mut().zip(&gone).filter(|(_, gone)| gone.is_ok()) {
        let Session { drives, state, .. } = &mut *own.session;
        cases.push(Case { drives, load: own.task.load, state, task: None });
    }
    let mut outcomes = batch.equilibria(&mut cases, &settings).into_iter();
    gone.into_iter().filter_map(|gone| gone.map(|()| outcomes.next()).transpose()).collect()
}

/// Sizes of the task errors of an iteration, mm.
type History = RefCell<Vec<f64>>;

/// Equilibria at the nominal commands, or (direct method) at drives that meet the tasks in one iteration, whose errors go into `histories`.
/// `None` where there is no command, where the iteration fails, or where it does not suit the task.
fn batch_equilibria(
    sessions: &mut [&mut Session],
    tasks: &[TaskPoint],
    method: Method,
    histories: &[History],
    batch: &mut Batch,
) -> Vec<Option<Outcome>> {
    let Some(first) = sessions.first() else { return Vec::new() };
    let (nominal, settings) = ((*first.nominal).clone(), first.settings.equilibrium);
    let is_direct = method == Method::Direct;
    let begin = |(session, task): (&mut &mut Session, &TaskPoint)| match is_direct {
        true => direct::is_near_last_point(session, task) && direct::determines_drives(session, task),
        false => session.command_pose(&task.shifted_pose(&session.nominal, &Vector6::zeros())).is_ok(),
    };
    let begun: Vec<bool> = sessions.iter_mut().zip(tasks).map(begin).collect();
    let errors: Vec<_> = tasks.iter().zip(histories).map(|(task, history)| error_fn(&nominal, task, history)).collect();
    let mut cases: Vec<Case<'_>> = Vec::with_capacity(sessions.len());
    for (((session, TaskPoint { load, .. }), error), _) in
        sessions.iter_mut().zip(tasks).zip(&errors).zip(&begun).filter(|(_, begun)| **begun)
    {
        let task: Option<&dyn Fn(&Pose) -> TaskError> = if is_direct { Some(error) } else { None };
        cases.push(Case { drives: &mut session.drives, load: *load, state: &mut session.state, task });
    }
    let mut outcomes = match is_direct {
        true => batch.equilibria_at_task(&mut cases, &settings).into_iter(),
        false => batch.equilibria(&mut cases, &settings).into_iter().map(Some).collect::<Vec<_>>().into_iter(),
    };
    begun.into_iter().map(|begun| if begun { outcomes.next().flatten() } else { None }).collect()
}

/// Function that returns the task error of `task` at a pose and adds its length to `history`.
fn error_fn<'a>(
    nominal: &'a Machine,
    task: &'a TaskPoint,
    history: &'a History,
) -> impl Fn(&Pose) -> TaskError + use<'a> {
    move |pose| {
        let error = task.task_error(nominal, pose);
        history.borrow_mut().push(error.size());
        error
    }
}

/// Seeds each session with the nominal inverse kinematics of the pose that it is to go to.
fn seed_sessions(sessions: &mut [&mut Session], poses: &[Pose]) {
    let seeking: Vec<usize> = (0..sessions.len()).filter(|&k| sessions[k].needs_search(&poses[k])).collect();
    let found = with_shared_storage(sessions, |storage, sessions| {
        let asked: Vec<_> = seeking.iter().map(|&k| (&sessions[k].command, poses[k])).collect();
        storage.inverse_kinematics(&asked)
    });
    for (&k, at) in seeking.iter().zip(found) {
        if let Some(at) = at {
            sessions[k].seed_from_command(&poses[k], at);
        }
    }
}

/// Finds the poses that command the drives of the sessions, where it can: [`Session::target`] then costs nothing.
pub fn find_targets(sessions: &mut [&mut Session]) {
    let seeking: Vec<usize> = (0..sessions.len()).filter(|&k| sessions[k].pending_target().is_some()).collect();
    let found = with_shared_storage(sessions, |storage, sessions| {
        let asked: Vec<_> = seeking.iter().filter_map(|&k| sessions[k].pending_target()).collect();
        storage.forward_kinematics(&asked)
    });
    for (&k, at) in seeking.iter().zip(found) {
        if let Some(at) = at {
            sessions[k].command = at;
        }
    }
}

/// Calls `find` with the sessions, all of one nominal machine, and one kinematics storage for them; an empty result for a single session.
fn with_shared_storage(
    sessions: &mut [&mut Session],
    find: impl FnOnce(&mut BatchKinematics, &[&mut Session]) -> Vec<Option<Configuration>>,
) -> Vec<Option<Configuration>> {
    if sessions.len() < 2 {
        return Vec::new();
    }
    let own = sessions[0].side_by_side.take();
    let mut storage = own.unwrap_or_else(|| Box::new(BatchKinematics::new(&sessions[0].nominal)));
    let found = find(&mut storage, sessions);
    sessions[0].side_by_side = Some(storage);
    found
}
