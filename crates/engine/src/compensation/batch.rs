//! One task or target for each of several sessions, solved several at a time.

use std::cell::RefCell;

use nalgebra::Vector6;

use super::{
    Method, compensate, direct,
    outcome::{Compensation, CompensationStatus},
    session::{Ending, Progress, Session},
    task_point::TaskPoint,
};
use crate::{
    machine::{Configuration, Machine, SideBySide},
    spatial::Pose,
    statics::{Batch, Case, Outcome, TaskError},
};

/// [`compensate`] of each task by its session, with the same results to the last bit.
///
/// The sessions share their settings and their machines, and `batch` is one of their real machine. Without compensation
/// and with the direct method, as many equilibria are solved at a time as the processor can; sessions that come with the
/// same `batch` in the same places again save work.
pub fn compensate_batch(
    sessions: &mut [&mut Session],
    asked: &[TaskPoint],
    method: Method,
    batch: &mut Batch,
) -> Vec<Compensation> {
    debug_assert_eq!(sessions.len(), asked.len());
    let zeroed: Vec<_> = sessions.iter_mut().zip(asked).map(|(session, task)| session.zeroed(task)).collect();
    let all = zeroed.iter().zip(asked).map(|(zeroed, task)| *zeroed.as_ref().unwrap_or(task));
    let tasks: &[TaskPoint] = &all.collect::<Vec<_>>();
    let histories: Vec<History> = tasks.iter().map(|_| History::default()).collect();
    let outcomes = match method {
        Method::None | Method::Direct => solve(sessions, tasks, method, &histories, batch),
        _ => vec![None; sessions.len()],
    };
    if method == Method::Direct && sessions.first().is_some_and(|session| session.nominal.has_limits()) {
        let solved = sessions.iter_mut().zip(&outcomes).filter(|(_, outcome)| outcome.is_some());
        find_targets(&mut solved.map(|(session, _)| &mut **session).collect::<Vec<_>>());
    }
    let mut in_part = vec![None; sessions.len()];
    if method == Method::Direct && sessions.len() > 1 {
        let chosen = sessions.iter_mut().zip(tasks).zip(&zeroed).zip(&mut in_part);
        let chosen =
            chosen.filter(|(((session, task), zeroed), _)| zeroed.is_ok() && !direct::is_complete(session, task));
        between_equilibria(
            chosen.map(|(((session, task), _), ending)| InPart::new(session, task, ending)).collect(),
            batch,
        );
    }
    let mut answers = Vec::with_capacity(sessions.len());
    let answered =
        sessions.iter_mut().zip(asked.iter().zip(tasks)).zip(outcomes).zip(histories).zip(zeroed).zip(in_part);
    for (((((session, (asked, task)), outcome), history), zeroed), in_part) in answered {
        if let Err(status) = zeroed {
            answers.push(session.conclude(task, Err(status), Vec::new()));
            continue;
        }
        if let Some((ending, history)) = in_part {
            answers.push(session.conclude(task, ending, history));
            continue;
        }
        let Some(outcome) = outcome else {
            answers.push(compensate(session, asked, method));
            continue;
        };
        let mut progress = Progress::new();
        let ending = if method == Method::Direct {
            progress.history = history.into_inner();
            direct::conclude(session, task, Some(outcome), &mut progress)
        } else {
            session.accept_or_settle_anew(task, outcome).map(|outcome| {
                progress.history.push(session.task_error(task).size());
                (CompensationStatus::Applied, outcome)
            })
        };
        answers.push(session.conclude(task, ending, progress.history));
    }
    answers
}

/// [`super::simulate`] of the target of each task by its session, with the same results to the last bit.
///
/// Sessions and `batch` as for [`compensate_batch`].
pub fn simulate_batch(
    sessions: &mut [&mut Session],
    asked: &[TaskPoint],
    targets: &[Pose],
    batch: &mut Batch,
) -> Vec<Compensation> {
    debug_assert!(sessions.len() == asked.len() && sessions.len() == targets.len());
    let Some(settings) = sessions.first().map(|session| session.settings.equilibrium) else { return Vec::new() };
    let zeroed: Vec<_> = sessions.iter_mut().zip(asked).map(|(session, task)| session.zeroed(task)).collect();
    know_poses(sessions, targets);
    let mut begun = Vec::with_capacity(sessions.len());
    for ((session, zeroed), target) in sessions.iter_mut().zip(zeroed).zip(targets) {
        begun.push(zeroed.map(|task| (task, session.go_to(target))));
    }
    let mut cases: Vec<Case<'_>> = Vec::with_capacity(sessions.len());
    for (session, begun) in sessions.iter_mut().zip(&begun) {
        if let Ok((task, Ok(()))) = begun {
            let (drives, state) = (&mut session.drives, &mut session.state);
            cases.push(Case { drives, load: task.load, state, task: None });
        }
    }
    let mut outcomes = batch.equilibria(&mut cases, &settings).into_iter();
    let mut answers = Vec::with_capacity(sessions.len());
    for ((session, asked), begun) in sessions.iter_mut().zip(asked).zip(begun) {
        let answer = match begun {
            Err(status) => session.conclude(asked, Err(status), Vec::new()),
            Ok((task, gone)) => {
                let settled = gone.and_then(|()| match outcomes.next() {
                    Some(outcome) => session.accept_or_settle_anew(&task, outcome),
                    None => session.settle(&task),
                });
                let history = vec![session.task_error(&task).size()];
                let ending = settled.map(|outcome| (CompensationStatus::Applied, outcome));
                session.conclude(&task, ending, history)
            }
        };
        answers.push(answer);
    }
    answers
}

/// A task that leaves controlled coordinates as commanded, and its session.
struct InPart<'a> {
    session: &'a mut Session,
    task: &'a TaskPoint,
    shift: direct::Shift,
    progress: Progress,
    ending: &'a mut Option<(Ending, Vec<f64>)>,
}

impl<'a> InPart<'a> {
    fn new(session: &'a mut Session, task: &'a TaskPoint, ending: &'a mut Option<(Ending, Vec<f64>)>) -> Self {
        Self { shift: direct::Shift::new(session, task), session, task, progress: Progress::new(), ending }
    }

    fn end(&mut self, ending: Ending) {
        *self.ending = Some((ending, std::mem::take(&mut self.progress.history)));
    }
}

/// The iteration of the direct method between equilibria, all of `parts` at a time: with the bits that each has alone.
fn between_equilibria(mut parts: Vec<InPart<'_>>, batch: &mut Batch) {
    let mut far: Vec<&mut InPart<'_>> =
        parts.iter_mut().filter(|own| !direct::is_near(own.session, own.task)).collect();
    let poses: Vec<Pose> = far.iter().map(|own| own.task.pose).collect();
    let outcomes = equilibria_at(&mut far, &poses, batch);
    for (own, outcome) in far.into_iter().zip(outcomes) {
        if let Err(status) = outcome.and_then(|outcome| own.session.accept_or_settle_anew(own.task, outcome)) {
            own.end(Err(status));
        }
    }
    loop {
        let mut going: Vec<&mut InPart<'_>> = parts.iter_mut().filter(|own| own.ending.is_none()).collect();
        if going.is_empty() {
            return;
        }
        let poses: Vec<Pose> =
            going.iter().map(|own| own.task.shifted(&own.session.nominal, &own.shift.shift)).collect();
        let outcomes = equilibria_at(&mut going, &poses, batch);
        for (own, outcome) in going.into_iter().zip(outcomes) {
            let InPart { session, task, shift, progress, .. } = own;
            let next = session.answered(task, &shift.shift, outcome).and_then(|(residual, outcome)| {
                Ok(shift.corrected(session, &residual, &outcome, progress)?.map(|status| (status, outcome)))
            });
            match next {
                Ok(None) => {}
                Ok(Some(ending)) => own.end(Ok(ending)),
                Err(status) => own.end(Err(status)),
            }
        }
    }
}

/// Commands each session its pose and lets it come to an equilibrium, or says why it cannot go there.
fn equilibria_at(
    parts: &mut [&mut InPart<'_>],
    poses: &[Pose],
    batch: &mut Batch,
) -> Vec<Result<Outcome, CompensationStatus>> {
    let mut sessions: Vec<&mut Session> = parts.iter_mut().map(|own| &mut *own.session).collect();
    let Some(settings) = sessions.first().map(|session| session.settings.equilibrium) else { return Vec::new() };
    know_poses(&mut sessions, poses);
    let gone: Vec<_> = sessions.iter_mut().zip(poses).map(|(session, pose)| session.go_to(pose)).collect();
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

/// Equilibria at the nominal commands, or at drives that meet the tasks in one iteration, which `histories` then follow.
/// `None` where there is no command, where the iteration fails, or where it does not suit the task.
fn solve(
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
        true => direct::is_near(session, task) && direct::is_complete(session, task),
        false => session.go_to(&task.shifted(&session.nominal, &Vector6::zeros())).is_ok(),
    };
    let begun: Vec<bool> = sessions.iter_mut().zip(tasks).map(begin).collect();
    let errors: Vec<_> = tasks.iter().zip(histories).map(|(task, history)| error_of(&nominal, task, history)).collect();
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

/// The task error of `task` at a pose, followed by `history`.
fn error_of<'a>(
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

/// Lets the sessions know what their nominal inverse kinematics gives for the pose that each is to go to.
fn know_poses(sessions: &mut [&mut Session], poses: &[Pose]) {
    let seeking: Vec<usize> = (0..sessions.len()).filter(|&k| sessions[k].seeks(&poses[k])).collect();
    let found = with_storage(sessions, |storage, sessions| {
        let asked: Vec<_> = seeking.iter().map(|&k| (&sessions[k].command, poses[k])).collect();
        storage.inverse_kinematics(&asked)
    });
    for (&k, at) in seeking.iter().zip(found) {
        if let Some(at) = at {
            sessions[k].know_from_command(&poses[k], at);
        }
    }
}

/// Finds the poses that command the drives of the sessions: [`Session::target`] then costs nothing, where it is found.
pub fn find_targets(sessions: &mut [&mut Session]) {
    let seeking: Vec<usize> = (0..sessions.len()).filter(|&k| sessions[k].target_sought().is_some()).collect();
    let found = with_storage(sessions, |storage, sessions| {
        let asked: Vec<_> = seeking.iter().filter_map(|&k| sessions[k].target_sought()).collect();
        storage.forward_kinematics(&asked)
    });
    for (&k, at) in seeking.iter().zip(found) {
        if let Some(at) = at {
            sessions[k].command = at;
        }
    }
}

/// What `find` finds with the storage of the sessions; nothing for one alone. Several stand on the same nominal machine.
fn with_storage(
    sessions: &mut [&mut Session],
    find: impl FnOnce(&mut SideBySide, &[&mut Session]) -> Vec<Option<Configuration>>,
) -> Vec<Option<Configuration>> {
    if sessions.len() < 2 {
        return Vec::new();
    }
    let own = sessions[0].side_by_side.take();
    let mut storage = own.unwrap_or_else(|| Box::new(SideBySide::new(&sessions[0].nominal)));
    let found = find(&mut storage, sessions);
    sessions[0].side_by_side = Some(storage);
    found
}
