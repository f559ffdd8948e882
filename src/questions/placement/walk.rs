//! Solution of the loaded machine along the points of a path, each started from the one before, and several walks side by side.

use nalgebra::Vector3;

use super::tally::{Needs, PointValues};
use crate::{
    FOR_PAGES,
    compensation::{Compensation, CompensationStatus, Method, Session, TaskPoint, compensate, compensate_batch},
    machine::{Configuration, Machine, Motion, PostureChange, Unreachable},
    simulation::{Failure, Machines, Source, along_path::PathCase, play::PlayedPoint},
    statics::{Batch, has_play},
};

/// Role of the exact correction in an evaluation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ExactMode {
    /// It is not computed.
    NotAsked,
    /// It is computed; where there is none, its numbers are missing.
    IfPossible,
    /// Where there is none, the workpiece cannot be cut.
    Needed,
}

/// Results of the machine with all sources of error at one point.
#[derive(Debug, Clone, Default)]
pub(super) struct Solution {
    /// Result at the nominal command.
    pub uncompensated: Option<Compensation>,
    /// Result at the exact correction, if it was sought.
    pub exact: Option<Compensation>,
}

/// Why a point cannot be cut, and by how much limits are exceeded.
#[derive(Debug, Clone)]
pub(super) struct Infeasibility {
    pub failure: Failure,
    /// Excess beyond a limit, mm or degrees, or as a share of a force limit; [`UNMEASURED`] or more where it is only known to be large.
    pub excess: f64,
}

/// Excess from which the number only says that it is large.
pub(super) const UNMEASURED: f64 = 1e3;

/// Returns how far out of reach a pose is, mm or degrees beyond a limit; at least [`UNMEASURED`] where it is only known to be large.
pub(super) fn excess(unreachable: &Unreachable) -> f64 {
    match unreachable {
        Unreachable::Travel { value, low, high, .. } | Unreachable::JointLimit { value, low, high, .. } => {
            f64::max(low - value, value - high)
        }
        Unreachable::TooFar { short_mm, .. } => UNMEASURED + short_mm,
        Unreachable::BeyondSpan { away_mm, span_mm, .. } => 2.0 * UNMEASURED + away_mm - span_mm,
        Unreachable::NoWay { straight, .. } | Unreachable::NoPosture { straight, .. } => excess(straight),
        _ => 2.0 * UNMEASURED,
    }
}

/// Sessions of a walk: of the machine with all sources of error, and of those with one alone, for the superposition error.
#[derive(Debug, Clone)]
struct WalkSessions {
    all: Session,
    single: Vec<(Source, Session)>,
}

impl WalkSessions {
    /// Makes sessions at home for the numbers of `needs`.
    fn new(machines: &Machines, needs: Needs) -> Self {
        let parts = if needs.superposition_error { Source::parts(&machines.nominal) } else { &[] };
        let single = parts.iter().map(|&source| (source, machines.session(source))).collect();
        Self { all: machines.session(Source::All), single }
    }

    /// Begins anew, undeflected at the configuration `at`.
    fn restart(&mut self, at: &Configuration) {
        self.all.restart(at);
        self.single.iter_mut().for_each(|(_, session)| session.restart(at));
    }
}

/// Solvers of the machines of a feature for as many walks as are solved side by side.
#[derive(Debug)]
pub(super) struct WalkSolvers {
    sessions: Vec<WalkSessions>,
    /// `None` in pages, which have no lanes.
    batches: Option<WalkBatches>,
}

/// Solvers of equilibria of [`Batch::WIDTH`] walks, in the order of the sessions of each.
#[derive(Debug)]
pub(super) struct WalkBatches {
    all: Batch,
    single: Vec<Batch>,
}

impl WalkSolvers {
    /// Makes the solvers for the numbers of `needs`.
    pub fn new(machines: &Machines, needs: Needs) -> Self {
        let sessions = WalkSessions::new(machines, needs);
        let single = || sessions.single.iter().map(|(source, _)| machines.batch(*source)).collect();
        let batches = (!FOR_PAGES).then(|| WalkBatches { all: machines.batch(Source::All), single: single() });
        Self { sessions: vec![sessions; Batch::WIDTH], batches }
    }

    /// Calls `use_walks` with a walk from each of `starts`, at most [`Batch::WIDTH`], and what solves them side by side.
    pub fn with_walks<'a, T>(
        &mut self,
        settings: WalkSettings<'a>,
        starts: &[&Configuration],
        use_walks: impl FnOnce(&mut [PathWalk<'a>], Option<&mut WalkBatches>) -> T,
    ) -> T {
        let begin = |(mut sessions, at): (WalkSessions, &&Configuration)| {
            sessions.restart(at);
            PathWalk::with_sessions(sessions, settings)
        };
        let mut walks: Vec<PathWalk<'a>> = self.sessions.drain(..starts.len()).zip(starts).map(begin).collect();
        let used = use_walks(&mut walks, self.batches.as_mut());
        self.sessions.extend(walks.into_iter().map(|walk| walk.sessions));
        used
    }
}

/// What walks along the path of a feature compute and refuse.
#[derive(Clone, Copy)]
pub(super) struct WalkSettings<'a> {
    pub machines: &'a Machines,
    pub needs: Needs,
    /// Force limit of each drive, N or N·mm; infinite where there is none.
    pub force_limits: &'a [f64],
    /// Whether an exact correction beyond a force limit is refused.
    pub check_forces: bool,
    pub exact: ExactMode,
}

/// Solves a few numbers at each point of a piece of a path.
pub(super) struct PathWalk<'a> {
    settings: WalkSettings<'a>,
    nominal: &'a Machine,
    /// Positions of drives, joints and forces within their limits, −1 to 1, point by point; `None` if not recorded.
    pub shares: Option<Vec<f64>>,
    /// Results at the last point.
    pub last: Solution,
    /// Configuration of the nominal machine at the first point of the path, if it has several branches.
    pub first: Option<Configuration>,
    sessions: WalkSessions,
}

/// A point that is being solved.
struct Visit {
    /// Rigid configuration there.
    at: Configuration,
    /// Result at the nominal command.
    uncompensated: Compensation,
    /// Half the interval that stays open there, mm; `None` where it is not known.
    open: Option<f64>,
    /// Sum of the displacements by single sources, less that by all at once without play, O axes, mm.
    excess: Vector3<f64>,
    values: Result<PointValues, Infeasibility>,
}

/// Solves the next point of each of `walks`, along paths of one feature, side by side, with the bits that each has alone. `Err` says why a
/// point cannot be cut.
pub(super) fn visit_together(
    walks: &mut [&mut PathWalk<'_>],
    tasks: &[TaskPoint],
    batches: Option<&mut WalkBatches>,
) -> Vec<Result<PointValues, Infeasibility>> {
    let (mut all, single) = batches.map_or((None, None), |own| (Some(&mut own.all), Some(&mut own.single)));
    let mut sessions: Vec<&mut Session> = walks.iter_mut().map(|walk| &mut walk.sessions.all).collect();
    let plain = compensate_all(&mut sessions, tasks, Method::None, all.as_deref_mut());
    let begun = walks.iter_mut().zip(tasks).zip(plain);
    let mut visits: Vec<Visit> = begun.map(|((walk, task), plain)| walk.begin(task, plain)).collect();
    let sources = walks.first().map_or(0, |walk| walk.sessions.single.len());
    let mut single = single.map(|own| own.iter_mut());
    for source in 0..sources {
        let batch = single.as_mut().and_then(Iterator::next);
        let mut open = open_visits(walks, &mut visits, tasks);
        let alone: Vec<TaskPoint> =
            open.iter().map(|(walk, _, task)| walk.sessions.single[source].0.task(task)).collect();
        let mut sessions: Vec<&mut Session> =
            open.iter_mut().map(|(walk, ..)| &mut walk.sessions.single[source].1).collect();
        let found = compensate_all(&mut sessions, &alone, Method::None, batch);
        open.into_iter().zip(found).for_each(|((walk, visit, _), found)| visit.add_single(walk.nominal, &found));
    }
    visits.iter_mut().filter(|_| sources > 0).for_each(Visit::add_superposition_error);
    if walks.first().is_some_and(|walk| walk.settings.exact != ExactMode::NotAsked) {
        let mut open = open_visits(walks, &mut visits, tasks);
        let tasks: Vec<TaskPoint> = open.iter().map(|(_, _, task)| **task).collect();
        let mut sessions: Vec<&mut Session> = open.iter_mut().map(|(walk, ..)| &mut walk.sessions.all).collect();
        let found = compensate_all(&mut sessions, &tasks, Method::Direct, all);
        open.into_iter().zip(found).for_each(|((walk, visit, task), exact)| walk.correct(task, visit, exact));
    }
    walks.iter_mut().zip(visits).map(|(walk, visit)| walk.end(visit)).collect()
}

/// Returns the walks whose point can be cut as far as is known, with their visits and tasks.
fn open_visits<'v, 'a>(
    walks: &'v mut [&mut PathWalk<'a>],
    visits: &'v mut [Visit],
    tasks: &'v [TaskPoint],
) -> Vec<(&'v mut PathWalk<'a>, &'v mut Visit, &'v TaskPoint)> {
    let all = walks.iter_mut().zip(visits).zip(tasks).map(|((walk, visit), task)| (&mut **walk, visit, task));
    all.filter(|(_, visit, _)| visit.values.is_ok()).collect()
}

/// Solves task `k` with session `k`, in lanes where `batch` is given.
fn compensate_all(
    sessions: &mut [&mut Session],
    tasks: &[TaskPoint],
    method: Method,
    batch: Option<&mut Batch>,
) -> Vec<Compensation> {
    // With external axes each stands on a machine of its own.
    let is_one_machine = tasks.iter().all(|task| task.external.is_none());
    match batch.filter(|_| !FOR_PAGES && sessions.len() > 1 && is_one_machine) {
        Some(batch) => compensate_batch(sessions, tasks, method, batch),
        None => sessions.iter_mut().zip(tasks).map(|(session, task)| compensate(session, task, method)).collect(),
    }
}

impl Visit {
    /// Adds the displacement by a source alone.
    fn add_single(&mut self, nominal: &Machine, found: &Compensation) {
        match found.status.is_success() {
            true => self.excess += found.position_error,
            false => self.values = Err(refusal(nominal, &found.status)),
        }
    }

    /// Writes the superposition error, once all sources are added, into the numbers of the point.
    fn add_superposition_error(&mut self) {
        if let Ok(values) = &mut self.values {
            values.superposition_error = self.excess.norm();
        }
    }
}

impl<'a> PathWalk<'a> {
    /// Makes a walk that starts at home.
    pub fn new(settings: WalkSettings<'a>) -> Self {
        Self::with_sessions(WalkSessions::new(settings.machines, settings.needs), settings)
    }

    /// Makes a walk that starts where `sessions` are.
    fn with_sessions(sessions: WalkSessions, settings: WalkSettings<'a>) -> Self {
        let nominal = &settings.machines.nominal;
        Self { settings, nominal, shares: None, last: Solution::default(), first: None, sessions }
    }

    /// Solves one point from the one before, and returns its numbers. `Err` says why it cannot be cut.
    pub fn visit(&mut self, task: &TaskPoint) -> Result<PointValues, Infeasibility> {
        visit_together(&mut [self], std::slice::from_ref(task), None).swap_remove(0)
    }

    /// Begins the visit of a point, whose result at the nominal command is `uncompensated`, without play.
    fn begin(&mut self, task: &TaskPoint, mut uncompensated: Compensation) -> Visit {
        self.last.exact = None;
        let excess = -uncompensated.position_error;
        let at = self.sessions.all.command().clone();
        let open = self.add_play(task, &at, &mut uncompensated, true);
        let values = self.plain_values(&uncompensated);
        Visit { at, uncompensated, open, excess, values }
    }

    /// Ends a visit and returns the numbers of its point.
    fn end(&mut self, visit: Visit) -> Result<PointValues, Infeasibility> {
        self.last.uncompensated = Some(visit.uncompensated);
        visit.values.map(|values| values.with_open(visit.open))
    }

    /// Adds the play of the drives, as along a path, to what was `found` at the rigid configuration `at`; returns half the interval that stays open, mm,
    /// `None` where it is not known.
    fn add_play(
        &mut self,
        task: &TaskPoint,
        at: &Configuration,
        found: &mut Compensation,
        is_given: bool,
    ) -> Option<f64> {
        let actual = self.settings.machines.actual(Source::All);
        if !found.status.is_success() || !has_play(actual) {
            return Some(0.0);
        }
        let mut target = self.sessions.all.target().ok();
        let case = PathCase::new(self.settings.machines, Source::All, std::slice::from_ref(task));
        let played = PlayedPoint { case: &case, task, at, is_given };
        played.add(&mut self.sessions.all, found, &mut target).map(|play| play.open_mm.norm())
    }

    /// Returns the numbers of a point from its result `uncompensated` at the nominal command.
    fn plain_values(&mut self, uncompensated: &Compensation) -> Result<PointValues, Infeasibility> {
        if !uncompensated.status.is_success() {
            return Err(refusal(self.nominal, &uncompensated.status));
        }
        self.check_branch()?;
        self.record_limit_shares();
        let mut values = PointValues { deflection: uncompensated.position_error.norm(), ..PointValues::default() };
        if self.settings.needs.stability {
            values.stability = uncompensated
                .outcome
                .as_ref()
                .and_then(|outcome| outcome.least_stiffness(self.nominal.characteristic_length));
        }
        Ok(values)
    }

    /// Checks that the machine is on the branch of inverse kinematics of the first point, as no path leads to another one.
    fn check_branch(&mut self) -> Result<(), Infeasibility> {
        if self.nominal.branch_of(&self.nominal.home).is_none() {
            return Ok(());
        }
        let current = self.sessions.all.command();
        let Some(first) = &self.first else {
            self.first = Some(current.clone());
            return Ok(());
        };
        match self.nominal.posture_change(first, current, true) {
            Some(change @ PostureChange::Branch { .. }) => {
                let (before_mm, here_mm) = (first.pose.translation, current.pose.translation);
                let status = CompensationStatus::ChangesPosture { change, before_mm, here_mm };
                Err(refusal(self.nominal, &status))
            }
            _ => Ok(()),
        }
    }

    /// Adds the numbers of the exact correction without play, `exact`, to the `visit` of `task`.
    fn correct(&mut self, task: &TaskPoint, visit: &mut Visit, mut exact: Compensation) {
        let open = self.add_play(task, &visit.at, &mut exact, false);
        if let Ok(values) = &mut visit.values {
            *values = values.with_open(open);
            if let Err(refusal) = self.add_exact(&visit.uncompensated, &exact, values) {
                visit.values = Err(refusal);
            }
        }
        self.last.exact = Some(exact);
    }

    /// Adds drive corrections and forces of the correction `exact` to `values`. `Err` where it is required and missing, or beyond a force limit.
    fn add_exact(
        &mut self,
        uncompensated: &Compensation,
        exact: &Compensation,
        values: &mut PointValues,
    ) -> Result<(), Infeasibility> {
        if !exact.status.is_success() {
            values.is_uncorrected = true;
            return if self.settings.exact == ExactMode::Needed {
                Err(uncorrected(self.nominal, &exact.status))
            } else {
                Ok(())
            };
        }
        if self.settings.exact == ExactMode::Needed {
            self.record_limit_shares();
        }
        let is_mixed = self.nominal.has_mixed_drives();
        for (k, (_, drive)) in self.nominal.drives().enumerate() {
            let delta = (exact.drives[k] - uncompensated.drives[k]).abs();
            let correction = drive.motion.to_shown(delta);
            let (force, limit) = (exact.drive_forces[k].abs(), self.settings.force_limits[k]);
            if is_mixed && drive.motion == Motion::Revolute {
                let [most, torque] = values.revolute.unwrap_or_default();
                values.revolute = Some([most.max(correction), torque.max(force)]);
            } else {
                values.correction = values.correction.max(correction);
                values.force = values.force.max(force);
            }
            if self.settings.check_forces && force > limit {
                return Err(self.overload_refusal(k, force));
            }
            if let Some(shares) = self.shares.as_mut().filter(|_| self.settings.check_forces && limit.is_finite()) {
                shares.push(exact.drive_forces[k] / limit);
            }
            if limit.is_finite() {
                let margin = (limit - force) / limit;
                values.margin = Some(values.margin.map_or(margin, |least| least.min(margin)));
            }
        }
        Ok(())
    }

    /// Appends where drives and joints lie within their limits, −1 to 1, to `shares`, if they are recorded.
    fn record_limit_shares(&mut self) {
        if let Some(shares) = &mut self.shares {
            self.nominal.limit_fractions(self.sessions.all.command(), shares);
        }
    }

    /// Returns the refusal of a drive force beyond its limit.
    fn overload_refusal(&self, drive: usize, force: f64) -> Infeasibility {
        let label = &self.nominal.drive_labels()[drive];
        let unit = self.nominal.drives().nth(drive).map_or("", |(_, drive)| drive.motion.shown_force_unit());
        let limit = self.settings.force_limits[drive];
        let reason = format!("drive {label} needs {force:.1} {unit}, its limit is {limit:.1} {unit}");
        Infeasibility { failure: Failure { status: "force_limit".into(), reason }, excess: (force - limit) / limit }
    }
}

/// Returns the refusal of a point for a status of `machine`, with the excess beyond limits.
fn refusal(machine: &Machine, status: &CompensationStatus) -> Infeasibility {
    let excess =
        if let CompensationStatus::Unreachable(unreachable) = status { excess(unreachable) } else { UNMEASURED };
    Infeasibility { failure: Failure::of(status, machine), excess }
}

/// Returns the refusal of a point that the loaded machine reaches but cannot correct.
fn uncorrected(machine: &Machine, status: &CompensationStatus) -> Infeasibility {
    let mut refused = refusal(machine, status);
    refused.failure.reason = match status {
        CompensationStatus::Unreachable(Unreachable::Travel { chain, drive, value, low, high, unit }) => format!(
            "the corrected drive {drive} of chain {chain} would stand at {value:.3} {unit}, beyond its travel of \
             {low:.3} to {high:.3} {unit}"
        ),
        _ => format!("there is no correction: {}", refused.failure.reason),
    };
    refused
}
