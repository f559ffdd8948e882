//! Solution of the loaded machine along the points of a path, each started from the one before.

use nalgebra::Vector3;

use super::tally::{Needs, PointValues};
use crate::{
    compensation::{Compensation, CompensationStatus, Method, Session, TaskPoint, compensate},
    machine::{Configuration, Machine, Motion, PostureChange, Unreachable},
    simulation::{Failure, Machines, Source, along_path::PathCase, play::PlayedPoint},
    statics::has_play,
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

/// Sessions that solve a few numbers at each point of many short pieces of paths, started at home.
pub(super) struct PathWalk<'a> {
    machines: &'a Machines,
    nominal: &'a Machine,
    needs: Needs,
    /// Force limit of each drive, N or N·mm; infinite where there is none.
    force_limits: &'a [f64],
    /// Whether an exact correction beyond a force limit is refused.
    check_forces: bool,
    exact: ExactMode,
    /// Positions of drives, joints and forces within their limits, −1 to 1, point by point; `None` if not recorded.
    pub shares: Option<Vec<f64>>,
    /// Results at the last point.
    pub last: Solution,
    all_sources: Session,
    /// Configuration of the nominal machine at the first point, if it has several branches.
    first: Option<Configuration>,
    /// Sessions of the single sources, for the superposition error.
    single_sources: Vec<(Source, Session)>,
}

impl<'a> PathWalk<'a> {
    /// Makes a walk that starts at home.
    pub fn new(
        machines: &'a Machines,
        needs: Needs,
        force_limits: &'a [f64],
        check_forces: bool,
        exact: ExactMode,
    ) -> Self {
        let session = |source| machines.session(source);
        Self {
            machines,
            nominal: &machines.nominal,
            needs,
            force_limits,
            check_forces,
            exact,
            shares: None,
            last: Solution::default(),
            all_sources: session(Source::All),
            first: None,
            single_sources: Source::parts(&machines.nominal)
                .iter()
                .filter(|_| needs.superposition_error)
                .map(|&source| (source, session(source)))
                .collect(),
        }
    }

    /// Solves one point from the one before, and returns its numbers. `Err` says why it cannot be cut.
    pub fn visit(&mut self, task: &TaskPoint) -> Result<PointValues, Infeasibility> {
        self.last.exact = None;
        let mut uncompensated = compensate(&mut self.all_sources, task, Method::None);
        let elastic = uncompensated.position_error;
        let at = self.all_sources.command().clone();
        let open = self.add_play(task, &at, &mut uncompensated, true);
        let values = self.point_values(task, &at, &uncompensated, elastic);
        self.last.uncompensated = Some(uncompensated);
        values.map(|values| values.with_open(open))
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
        let actual = self.machines.actual(Source::All);
        if !found.status.is_success() || !has_play(actual) {
            return Some(0.0);
        }
        let mut target = self.all_sources.target().ok();
        let case = PathCase::new(self.machines, Source::All, std::slice::from_ref(task));
        let played = PlayedPoint { case: &case, task, at, is_given };
        played.add(&mut self.all_sources, found, &mut target).map(|play| play.open_mm.norm())
    }

    /// Returns the numbers of a point, whose rigid configuration is `at`, from its result `uncompensated` at the nominal command and its error without play
    /// there, `elastic` (O axes, mm), and solves what other numbers need.
    fn point_values(
        &mut self,
        task: &TaskPoint,
        at: &Configuration,
        uncompensated: &Compensation,
        elastic: Vector3<f64>,
    ) -> Result<PointValues, Infeasibility> {
        if !uncompensated.status.is_success() {
            return Err(refusal(&uncompensated.status, uncompensated.status.reason(self.nominal)));
        }
        self.check_branch()?;
        self.record_limit_shares();
        let mut values = PointValues { deflection: uncompensated.position_error.norm(), ..PointValues::default() };
        if self.needs.stability {
            values.stability = uncompensated
                .outcome
                .as_ref()
                .and_then(|outcome| outcome.least_stiffness(self.nominal.characteristic_length));
        }
        if !self.single_sources.is_empty() {
            let mut superposition_error = -elastic;
            for (source, session) in &mut self.single_sources {
                let single = success_or_refusal(self.nominal, compensate(session, &source.task(task), Method::None))?;
                superposition_error += single.position_error;
            }
            values.superposition_error = superposition_error.norm();
        }
        if self.exact != ExactMode::NotAsked {
            self.correct(task, at, uncompensated, &mut values)?;
        }
        Ok(values)
    }

    /// Checks that the machine is on the branch of inverse kinematics of the first point, as no path leads to another one.
    fn check_branch(&mut self) -> Result<(), Infeasibility> {
        if self.nominal.branch_of(&self.nominal.home).is_none() {
            return Ok(());
        }
        let current = self.all_sources.command();
        let Some(first) = &self.first else {
            self.first = Some(current.clone());
            return Ok(());
        };
        match self.nominal.posture_change(first, current, true) {
            Some(change @ PostureChange::Branch { .. }) => {
                let (before_mm, here_mm) = (first.pose.translation, current.pose.translation);
                let status = CompensationStatus::ChangesPosture { change, before_mm, here_mm };
                Err(refusal(&status, status.reason(self.nominal)))
            }
            _ => Ok(()),
        }
    }

    /// Solves the exact correction of a point and adds its numbers to `values`. `Err` as of [`PathWalk::add_exact`].
    fn correct(
        &mut self,
        task: &TaskPoint,
        at: &Configuration,
        uncompensated: &Compensation,
        values: &mut PointValues,
    ) -> Result<(), Infeasibility> {
        let mut exact = compensate(&mut self.all_sources, task, Method::Direct);
        let open = self.add_play(task, at, &mut exact, false);
        *values = values.with_open(open);
        let added = self.add_exact(uncompensated, &exact, values);
        self.last.exact = Some(exact);
        added
    }

    /// Adds drive corrections and forces of the correction `exact` to `values`. `Err` where it is required and missing, or exceeds a force
    /// limit.
    fn add_exact(
        &mut self,
        uncompensated: &Compensation,
        exact: &Compensation,
        values: &mut PointValues,
    ) -> Result<(), Infeasibility> {
        if !exact.status.is_success() {
            values.is_uncorrected = true;
            return if self.exact == ExactMode::Needed {
                Err(uncorrected(self.nominal, &exact.status))
            } else {
                Ok(())
            };
        }
        if self.exact == ExactMode::Needed {
            self.record_limit_shares();
        }
        let is_mixed = self.nominal.has_mixed_drives();
        for (k, (_, drive)) in self.nominal.drives().enumerate() {
            let delta = (exact.drives[k] - uncompensated.drives[k]).abs();
            let correction = drive.motion.to_shown(delta);
            let (force, limit) = (exact.drive_forces[k].abs(), self.force_limits[k]);
            if is_mixed && drive.motion == Motion::Revolute {
                let [most, torque] = values.revolute.unwrap_or_default();
                values.revolute = Some([most.max(correction), torque.max(force)]);
            } else {
                values.correction = values.correction.max(correction);
                values.force = values.force.max(force);
            }
            if self.check_forces && force > limit {
                return Err(self.overload_refusal(k, force));
            }
            if let Some(shares) = self.shares.as_mut().filter(|_| self.check_forces && limit.is_finite()) {
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
            self.nominal.limit_fractions(self.all_sources.command(), shares);
        }
    }

    /// Returns the refusal of a drive force beyond its limit.
    fn overload_refusal(&self, drive: usize, force: f64) -> Infeasibility {
        let label = &self.nominal.drive_labels()[drive];
        let unit = self.nominal.drives().nth(drive).map_or("", |(_, drive)| drive.motion.shown_force_unit());
        let limit = self.force_limits[drive];
        let reason = format!("drive {label} needs {force:.1} {unit}, its limit is {limit:.1} {unit}");
        Infeasibility { failure: Failure { status: "force_limit".into(), reason }, excess: (force - limit) / limit }
    }
}

/// Returns the result of a solve if it succeeded; else why the point is refused.
fn success_or_refusal(machine: &Machine, result: Compensation) -> Result<Compensation, Infeasibility> {
    if result.status.is_success() {
        return Ok(result);
    }
    Err(refusal(&result.status, result.status.reason(machine)))
}

/// Returns the refusal of a point for a status and its reason, with the excess beyond limits.
fn refusal(status: &CompensationStatus, reason: String) -> Infeasibility {
    let excess =
        if let CompensationStatus::Unreachable(unreachable) = status { excess(unreachable) } else { UNMEASURED };
    Infeasibility { failure: Failure { status: status.label().into(), reason }, excess }
}

/// Returns the refusal of a point that the loaded machine reaches but cannot correct.
fn uncorrected(machine: &Machine, status: &CompensationStatus) -> Infeasibility {
    let reason = match status {
        CompensationStatus::Unreachable(Unreachable::Travel { chain, drive, value, low, high, unit }) => format!(
            "the corrected drive {drive} of chain {chain} would stand at {value:.3} {unit}, beyond its travel of \
             {low:.3} to {high:.3} {unit}"
        ),
        status => format!("there is no correction: {}", status.reason(machine)),
    };
    refusal(status, reason)
}
