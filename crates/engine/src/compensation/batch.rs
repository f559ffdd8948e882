//! Compensation or simulation of one task point for each of several sessions, several at a time.

use std::cell::RefCell;

use nalgebra::Vector6;

use super::{
    Method, compensate, direct,
    outcome::{Compensation, CompensationStatus},
    session::{Progress, Session},
    task_point::TaskPoint,
};
use crate::{
    machine::{BatchKinematics, Configuration, Machine},
    spatial::Pose,
    statics::{Batch, Case, Outcome, TaskError},
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
    let mut results = Vec::with_capacity(sessions.len());
    let finished = sessions.iter_mut().zip(asked.iter().zip(tasks)).zip(outcomes).zip(histories).zip(wanted);
    for ((((session, (asked, task)), outcome), history), wanted) in finished {
        if let Err(status) = wanted {
            results.push(session.conclude(task, Err(status), Vec::new()));
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

/// Lengths of the task errors of an iteration, mm.
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

/// Runs `find` with kinematics storage shared by the sessions, which have the same nominal machine; returns nothing for a single session.
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
