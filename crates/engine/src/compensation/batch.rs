//! Compensation or simulation of one task point for each of several sessions, several at a time.

use std::cell::RefCell;

use nalgebra::Vector6;

use super::{
    Method, compensate, direct,
    outcome::{Compensation, CompensationStatus},
    session::{MethodResult, Progress, Session},
    task_point::TaskPoint,
};
use crate::{
    machine::{BatchKinematics, Configuration, Machine},
    spatial::{Pose, Wrench},
    statics::{Batch, Case, Level, Outcome, State, Status, TaskError},
};

/// Compensates task `k` with session `k` as [`compensate`] does, with results identical to the last bit; returns them in this order.
///
/// The sessions must have the same settings and the same two machines, of which `batch` solves the actual one. [`Method::None`] and
/// [`Method::Direct`] solve as many equilibria at a time as the processor can. The same sessions with the same `batch` again save work.
pub fn compensate_batch(
    sessions: &mut [&mut Session],
    tasks: &[TaskPoint],
    method: Method,
    batch: &mut Batch,
) -> Vec<Compensation> {
    debug_assert_eq!(sessions.len(), tasks.len());
    find_rests(sessions, tasks);
    let ready: Vec<_> = sessions.iter_mut().zip(tasks).map(|(session, task)| session.with_wanted_pose(task)).collect();
    let all = ready.iter().zip(tasks).map(|(ready, task)| *ready.as_ref().unwrap_or(task));
    let ready_tasks: &[TaskPoint] = &all.collect::<Vec<_>>();
    let histories: Vec<History> = ready_tasks.iter().map(|_| History::default()).collect();
    let outcomes = match method {
        Method::None | Method::Direct => batch_equilibria(sessions, ready_tasks, method, &histories, batch),
        _ => vec![None; sessions.len()],
    };
    if method == Method::Direct && sessions.first().is_some_and(|session| session.nominal.has_limits()) {
        let solved = sessions.iter_mut().zip(&outcomes).filter(|(_, outcome)| outcome.is_some());
        find_targets(&mut solved.map(|(session, _)| &mut **session).collect::<Vec<_>>());
    }
    let mut endings: Vec<Option<(MethodResult, Vec<f64>)>> = vec![None; sessions.len()];
    if method == Method::Direct {
        let chosen = sessions.iter_mut().zip(ready_tasks).zip(&ready).zip(&mut endings);
        let chosen =
            chosen.filter(|(((session, task), ready), _)| ready.is_ok() && !direct::determines_drives(session, task));
        let mut parts: Vec<PartialTask<'_>> =
            chosen.map(|(((session, task), _), ending)| PartialTask::new(session, task, ending)).collect();
        solve_partial(&mut parts, batch);
    }
    let mut results = Vec::with_capacity(sessions.len());
    let finished =
        sessions.iter_mut().zip(tasks.iter().zip(ready_tasks)).zip(outcomes).zip(histories).zip(ready).zip(endings);
    for (((((session, (unresolved, task)), outcome), history), ready), ending) in finished {
        if let Err(status) = ready {
            results.push(session.conclude(task, Err(status), Vec::new()));
            continue;
        }
        if let Some((ending, history)) = ending {
            results.push(session.conclude(task, ending, history));
            continue;
        }
        let Some(outcome) = outcome else {
            results.push(compensate(session, unresolved, method));
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

/// Commands `targets[k]` (poses of P in O) to session `k` and finds the equilibrium under the load of task `k`, as [`super::simulate`] does
/// to the last bit. The sessions must have the same settings and the same two machines, of which `batch` solves the actual one.
pub fn simulate_batch(
    sessions: &mut [&mut Session],
    tasks: &[TaskPoint],
    targets: &[Pose],
    batch: &mut Batch,
) -> Vec<Compensation> {
    debug_assert!(sessions.len() == tasks.len() && sessions.len() == targets.len());
    let Some(settings) = sessions.first().map(|session| session.settings.equilibrium) else { return Vec::new() };
    find_rests(sessions, tasks);
    let ready: Vec<_> = sessions.iter_mut().zip(tasks).map(|(session, task)| session.with_wanted_pose(task)).collect();
    seed_sessions(sessions, targets);
    let mut commanded = Vec::with_capacity(sessions.len());
    for ((session, ready), target) in sessions.iter_mut().zip(ready).zip(targets) {
        commanded.push(ready.map(|task| (task, session.command_pose(target))));
    }
    let mut cases: Vec<Case<'_>> = Vec::with_capacity(sessions.len());
    for (session, commanded) in sessions.iter_mut().zip(&commanded) {
        if let Ok((task, Ok(()))) = commanded {
            let (drives, state) = (&mut session.drives, &mut session.state);
            cases.push(Case { drives, load: task.load, state, task: None });
        }
    }
    let mut outcomes = batch.equilibria(&mut cases, &settings).into_iter();
    let mut results = Vec::with_capacity(sessions.len());
    for ((session, unresolved), commanded) in sessions.iter_mut().zip(tasks).zip(commanded) {
        let result = match commanded {
            Err(status) => session.conclude(unresolved, Err(status), Vec::new()),
            Ok((task, command)) => {
                let stable = command.and_then(|()| match outcomes.next() {
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

/// A task and its session under iteration; `ending` stays `None` until that is over, then has its result and the history of its errors, mm.
pub(super) struct PartialTask<'a> {
    session: &'a mut Session,
    task: &'a TaskPoint,
    progress: Progress,
    ending: &'a mut Option<(MethodResult, Vec<f64>)>,
}

impl<'a> PartialTask<'a> {
    /// A task whose iteration has not begun; `ending` receives its result.
    fn new(session: &'a mut Session, task: &'a TaskPoint, ending: &'a mut Option<(MethodResult, Vec<f64>)>) -> Self {
        Self { session, task, progress: Progress::new(), ending }
    }

    /// Ends the iteration with `ending`, to which the history of errors is added.
    fn end(&mut self, ending: MethodResult) {
        *self.ending = Some((ending, std::mem::take(&mut self.progress.history)));
    }
}

/// Runs `solve` for one session's task in a batch of its own, with the bits it has among others; `progress` gets the history of errors, mm.
pub(super) fn solve_alone(
    session: &mut Session,
    task: &TaskPoint,
    progress: &mut Progress,
    solve: impl FnOnce(&mut [PartialTask<'_>], &mut Batch),
) -> MethodResult {
    let stored = session.alone.take();
    let mut batch = stored.unwrap_or_else(|| Box::new(Batch::at_level(&session.actual, Level::One)));
    let mut ending = None;
    solve(&mut [PartialTask::new(session, task, &mut ending)], &mut batch);
    session.alone = Some(batch);
    let (ending, history) = ending.unwrap_or((Err(CompensationStatus::Slow), Vec::new()));
    progress.history = history;
    ending
}

/// Solves tasks that compensate only part of what the drives control: by [`solve_with_command`], or [`correct_targets`] where that fails.
pub(super) fn solve_partial(parts: &mut [PartialTask<'_>], batch: &mut Batch) {
    let mut far: Vec<&mut PartialTask<'_>> =
        parts.iter_mut().filter(|part| !direct::is_near_last_point(part.session, part.task)).collect();
    let poses: Vec<Pose> = far.iter().map(|part| part.task.pose).collect();
    let outcomes = equilibria_at_poses(&mut far, &poses, batch);
    for (part, outcome) in far.into_iter().zip(outcomes) {
        if let Err(status) = outcome.and_then(|outcome| part.session.accept_or_solve_anew(part.task, outcome)) {
            part.end(Err(status));
        }
    }
    solve_with_command(parts, batch);
    correct_targets(parts, batch);
}

/// Largest accepted difference of the drives found from those of the inverse kinematics, as a share of the characteristic length.
const SAME_COMMAND: f64 = 1e-11;

/// Finds drives, command and equilibrium in one Newton iteration; ends parts whose drives inverse kinematics confirms, resets the others.
fn solve_with_command(parts: &mut [PartialTask<'_>], batch: &mut Batch) {
    let is_open = |part: &&mut PartialTask<'_>| part.ending.is_none() && direct::has_drive_per_control(part.session);
    let mut parts: Vec<&mut PartialTask<'_>> = parts.iter_mut().filter(is_open).collect();
    let Some(first) = parts.first() else { return };
    let (nominal, settings) = ((*first.session.nominal).clone(), first.session.settings.equilibrium);
    let tasks: Vec<TaskPoint> = parts.iter().map(|part| *part.task).collect();
    let histories: Vec<History> = parts.iter().map(|_| History::default()).collect();
    let errors: Vec<_> =
        tasks.iter().zip(&histories).map(|(task, history)| error_fn(&nominal, task, history)).collect();
    let mut poses: Vec<Pose> = tasks.iter().map(|task| task.pose).collect();
    let (mut cases, mut starts) = (Vec::with_capacity(parts.len()), Vec::with_capacity(parts.len()));
    for ((part, task), error) in parts.iter_mut().zip(&tasks).zip(&errors) {
        let Session { drives, state, command, .. } = &mut *part.session;
        cases.push(Case { drives, load: task.load, state, task: Some(error) });
        starts.push(&*command);
    }
    let outcomes = batch.equilibria_at_position(&nominal, &mut cases, &starts, &mut poses, &settings);
    drop(errors);
    let done = parts.into_iter().zip(outcomes).zip(poses).zip(histories);
    let done = done.filter_map(|(((part, outcome), pose), history)| Some((part, outcome?, pose, history.into_inner())));
    let mut done: Vec<(&mut PartialTask<'_>, Outcome, Pose, Vec<f64>)> = done.collect();
    let poses: Vec<Pose> = done.iter().map(|(_, _, pose, _)| *pose).collect();
    seed_sessions(&mut done.iter_mut().map(|(part, ..)| &mut *part.session).collect::<Vec<_>>(), &poses);
    for (part, outcome, pose, history) in done {
        let (drives, before) = (part.session.drives.clone(), part.session.command.clone());
        let is_same =
            part.session.command_pose(&pose).is_ok() && part.session.drive_difference(&drives) <= SAME_COMMAND;
        // A soft machine may stand beside a singular place, which the equilibria one by one tell.
        let is_met =
            part.session.task_error(part.task).size() <= part.session.tolerance_mm() && !outcome.is_soft(&nominal);
        if is_same && is_met {
            part.session.command.drives.clone_from(&drives);
            part.session.drives = drives;
            part.progress.history = history;
            part.end(Ok((CompensationStatus::Converged, outcome)));
            continue;
        }
        part.session.drives.clone_from(&before.drives);
        part.session.command = before;
        if let Err(status) = part.session.reset_to_nominal(part.task) {
            part.end(Err(status));
        }
    }
}

/// Corrects the target of each task by Newton steps from the nominal command, each with a loaded equilibrium, until all parts have ended.
pub(super) fn correct_targets(parts: &mut [PartialTask<'_>], batch: &mut Batch) {
    let mut shifts: Vec<direct::TargetShift> =
        parts.iter().map(|part| direct::TargetShift::new(part.session, part.task)).collect();
    loop {
        let active = parts.iter_mut().zip(&mut shifts).filter(|(part, _)| part.ending.is_none());
        let (mut active, shifts): (Vec<&mut PartialTask<'_>>, Vec<&mut direct::TargetShift>) = active.unzip();
        if active.is_empty() {
            return;
        }
        let poses =
            active.iter().zip(&shifts).map(|(part, shift)| part.task.shifted_pose(&part.session.nominal, &shift.shift));
        let poses: Vec<Pose> = poses.collect();
        let outcomes = equilibria_at_poses(&mut active, &poses, batch);
        for ((part, shift), outcome) in active.into_iter().zip(shifts).zip(outcomes) {
            let PartialTask { session, task, progress, .. } = part;
            let next = session.accept_shifted(task, &shift.shift, outcome).and_then(|(residual, outcome)| {
                Ok(shift.correct(session, &residual, &outcome, progress)?.map(|status| (status, outcome)))
            });
            match next {
                Ok(None) => {}
                Ok(Some(ending)) => part.end(Ok(ending)),
                Err(status) => part.end(Err(status)),
            }
        }
    }
}

/// Commands `poses[k]` to part `k` and solves the loaded equilibrium there, in order; `Err` for a pose that cannot be commanded.
fn equilibria_at_poses(
    parts: &mut [&mut PartialTask<'_>],
    poses: &[Pose],
    batch: &mut Batch,
) -> Vec<Result<Outcome, CompensationStatus>> {
    let mut sessions: Vec<&mut Session> = parts.iter_mut().map(|part| &mut *part.session).collect();
    let Some(settings) = sessions.first().map(|session| session.settings.equilibrium) else { return Vec::new() };
    seed_sessions(&mut sessions, poses);
    let commands: Vec<_> = sessions.iter_mut().zip(poses).map(|(session, pose)| session.command_pose(pose)).collect();
    let mut cases: Vec<Case<'_>> = Vec::with_capacity(sessions.len());
    for (part, _) in parts.iter_mut().zip(&commands).filter(|(_, command)| command.is_ok()) {
        let Session { drives, state, .. } = &mut *part.session;
        cases.push(Case { drives, load: part.task.load, state, task: None });
    }
    let mut outcomes = batch.equilibria(&mut cases, &settings).into_iter();
    commands.into_iter().filter_map(|command| command.map(|()| outcomes.next()).transpose()).collect()
}

/// Sizes of the task errors of an iteration, mm.
type History = RefCell<Vec<f64>>;

/// Equilibrium of each session at its nominal command or, for [`Method::Direct`], at drives that meet the task, found in one iteration,
/// whose errors (mm) go into `histories`. `None` where the pose cannot be commanded or the direct iteration fails or does not apply.
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
    let prepare = |(session, task): (&mut &mut Session, &TaskPoint)| match is_direct {
        true => direct::is_near_last_point(session, task) && direct::determines_drives(session, task),
        false => session.command_pose(&task.shifted_pose(&session.nominal, &Vector6::zeros())).is_ok(),
    };
    let is_ready: Vec<bool> = sessions.iter_mut().zip(tasks).map(prepare).collect();
    let errors: Vec<_> = tasks.iter().zip(histories).map(|(task, history)| error_fn(&nominal, task, history)).collect();
    let mut cases: Vec<Case<'_>> = Vec::with_capacity(sessions.len());
    for (((session, TaskPoint { load, .. }), error), _) in
        sessions.iter_mut().zip(tasks).zip(&errors).zip(&is_ready).filter(|(_, is_ready)| **is_ready)
    {
        let task: Option<&dyn Fn(&Pose) -> TaskError> = if is_direct { Some(error) } else { None };
        cases.push(Case { drives: &mut session.drives, load: *load, state: &mut session.state, task });
    }
    let mut outcomes = match is_direct {
        true => batch.equilibria_at_task(&mut cases, &settings).into_iter(),
        false => batch.equilibria(&mut cases, &settings).into_iter().map(Some).collect::<Vec<_>>().into_iter(),
    };
    is_ready.into_iter().map(|is_ready| if is_ready { outcomes.next().flatten() } else { None }).collect()
}

/// Returns the function that computes the error of `task` at a pose of P and appends its length, mm, to `history`.
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

/// Solves nominal inverse kinematics of `poses[k]` for session `k`, side by side, and seeds the sessions with what is found.
fn seed_sessions(sessions: &mut [&mut Session], poses: &[Pose]) {
    let seeking: Vec<usize> = (0..sessions.len()).filter(|&k| sessions[k].needs_search(&poses[k])).collect();
    let solutions = with_shared_storage(sessions, |storage, sessions| {
        let searches: Vec<_> = seeking.iter().map(|&k| (&sessions[k].command, poses[k])).collect();
        storage.inverse_kinematics(&searches)
    });
    for (&k, at) in seeking.iter().zip(solutions) {
        if let Some(at) = at {
            sessions[k].seed_from_command(&poses[k], at);
        }
    }
}

/// Solves, side by side, where the nominal machine stands under its weight alone at the pose of `tasks[k]`, as [`Session::with_wanted_pose`] of session
/// `k` would; it is then known.
fn find_rests(sessions: &mut [&mut Session], tasks: &[TaskPoint]) {
    let has_lanes = !cfg!(target_family = "wasm");
    let is_needed = has_lanes && sessions.iter().zip(tasks).any(|(session, task)| session.needs_rest(task));
    // On external axes each stands on a machine of its own, to which it has not moved yet.
    if sessions.len() < 2 || !is_needed || tasks.iter().any(|task| task.external.is_some()) {
        return;
    }
    let poses: Vec<Pose> = tasks.iter().map(|task| task.pose).collect();
    seed_sessions(sessions, &poses);
    let stored = sessions[0].under_weight.take();
    let mut batch = stored.unwrap_or_else(|| Box::new(Batch::new(sessions[0].unloaded())));
    let settings = sessions[0].settings.equilibrium;
    let pending = |(k, task): (usize, &TaskPoint)| {
        let at = sessions[k].pending_rest(task)?;
        Some((k, at.drives.clone(), State::rigid(&sessions[k].nominal, at)))
    };
    let mut pending: Vec<(usize, Vec<f64>, State)> = tasks.iter().enumerate().filter_map(pending).collect();
    let mut cases: Vec<Case<'_>> = Vec::with_capacity(pending.len());
    for (_, drives, state) in &mut pending {
        cases.push(Case { drives, load: Wrench::zero(), state, task: None });
    }
    let outcomes = batch.equilibria(&mut cases, &settings);
    for ((k, _, state), outcome) in pending.into_iter().zip(outcomes) {
        // Where there is none the session says so itself.
        if outcome.status == Status::Solved {
            sessions[k].set_rest(poses[k], state.pose);
        }
    }
    sessions[0].under_weight = Some(batch);
}

/// Solves, side by side, the forward kinematics that [`Session::target`] of each session would need; it is then known.
pub fn find_targets(sessions: &mut [&mut Session]) {
    let seeking: Vec<usize> = (0..sessions.len()).filter(|&k| sessions[k].pending_target().is_some()).collect();
    let solutions = with_shared_storage(sessions, |storage, sessions| {
        let searches: Vec<_> = seeking.iter().filter_map(|&k| sessions[k].pending_target()).collect();
        storage.forward_kinematics(&searches)
    });
    for (&k, at) in seeking.iter().zip(solutions) {
        if let Some(at) = at {
            sessions[k].command = at;
        }
    }
}

/// Calls `solve` with one kinematics storage and the sessions, all of one nominal machine; returns nothing for fewer than two sessions.
fn with_shared_storage(
    sessions: &mut [&mut Session],
    solve: impl FnOnce(&mut BatchKinematics, &[&mut Session]) -> Vec<Option<Configuration>>,
) -> Vec<Option<Configuration>> {
    if sessions.len() < 2 {
        return Vec::new();
    }
    let stored = sessions[0].side_by_side.take();
    let mut storage = stored.unwrap_or_else(|| Box::new(BatchKinematics::new(&sessions[0].nominal)));
    let solutions = solve(&mut storage, sessions);
    sessions[0].side_by_side = Some(storage);
    solutions
}
