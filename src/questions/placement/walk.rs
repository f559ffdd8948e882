//! The machine being tracked over points of a path, each solved from the one before.

use super::tally::{Needs, Seen};
use crate::{
    compensation::{Compensation, CompensationStatus, Method, Session, TaskPoint, compensate},
    machine::{Configuration, Machine, Motion, PostureChange, Unreachable},
    simulation::{Failure, Machines, Source},
};

/// What becomes of the exact correction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Exact {
    /// It is not looked at.
    NotAsked,
    /// It is computed; where there is none, its numbers are missing.
    IfPossible,
    /// Where there is none, the workpiece cannot be cut.
    Needed,
}

/// What the machine with all sources of error did at a point.
#[derive(Debug, Clone, Default)]
pub(super) struct Answers {
    /// At the nominal command.
    pub plain: Option<Compensation>,
    /// At the exact correction, if it was sought.
    pub exact: Option<Compensation>,
}

/// Why a point cannot be cut.
#[derive(Debug, Clone)]
pub(super) struct Refusal {
    pub failure: Failure,
    /// By how much, as far as it can be told: mm or degrees beyond a limit, or the share of a force limit.
    pub excess: f64,
}

/// An excess from which on it tells no more than that it is large.
pub(super) const UNMEASURED: f64 = 1e3;

/// By how much a place is unreachable, mm or degrees.
pub(super) fn excess(unreachable: &Unreachable) -> f64 {
    match unreachable {
        Unreachable::Travel { value, low, high, .. } | Unreachable::JointLimit { value, low, high, .. } => {
            f64::max(low - value, value - high)
        }
        Unreachable::TooFar { short_mm, .. } => UNMEASURED + short_mm,
        Unreachable::BeyondSpan { away_mm, span_mm, .. } => 2.0 * UNMEASURED + away_mm - span_mm,
        Unreachable::NoWay { straight, .. } => excess(straight),
        _ => 2.0 * UNMEASURED,
    }
}

/// Sessions for everything a point is asked, standing at home.
///
/// [`crate::simulation::along_path::run`] answers more (the modified target, which needs forward kinematics) and in blocks of its
/// own; a search asks many short pieces of paths for a few numbers.
pub(super) struct Walk<'a> {
    nominal: &'a Machine,
    needs: Needs,
    /// Most force of each drive, N or N·mm; infinite where there is no limit.
    force_limits: &'a [f64],
    /// Whether an exact correction beyond a limit is refused.
    check_forces: bool,
    exact: Exact,
    /// Where drives, joints and forces stand within their limits, −1 to 1, point by point; `None` if nobody asks.
    pub shares: Option<Vec<f64>>,
    /// What the machine did at the last point.
    pub last: Answers,
    both: Session,
    /// Where the nominal machine stands at the first point, if it can change its branch.
    first: Option<Configuration>,
    /// The cutting force on the nominal machine, and the unloaded real machine.
    apart: Vec<(Source, Session)>,
}

impl<'a> Walk<'a> {
    pub fn new(
        machines: &'a Machines,
        needs: Needs,
        force_limits: &'a [f64],
        check_forces: bool,
        exact: Exact,
    ) -> Self {
        let session = |source| machines.session(source);
        Self {
            nominal: &machines.nominal,
            needs,
            force_limits,
            check_forces,
            exact,
            shares: None,
            last: Answers::default(),
            both: session(Source::All),
            first: None,
            apart: Source::parts(&machines.nominal)
                .iter()
                .filter(|_| needs.superposition_error)
                .map(|&source| (source, session(source)))
                .collect(),
        }
    }

    /// What happens at one point.
    pub fn visit(&mut self, task: &TaskPoint) -> Result<Seen, Refusal> {
        self.last.exact = None;
        let plain = compensate(&mut self.both, task, Method::None);
        let seen = self.judge(task, &plain);
        self.last.plain = Some(plain);
        seen
    }

    fn judge(&mut self, task: &TaskPoint, plain: &Compensation) -> Result<Seen, Refusal> {
        if !plain.status.is_success() {
            return Err(refusal(&plain.status, plain.status.reason(self.nominal)));
        }
        self.keep_branch()?;
        self.note_limits();
        let mut seen = Seen { deflection: plain.position_error.norm(), ..Seen::default() };
        if self.needs.stability {
            seen.stability =
                plain.outcome.as_ref().and_then(|outcome| outcome.softest(self.nominal.characteristic_length));
        }
        if !self.apart.is_empty() {
            let mut superposition_error = -plain.position_error;
            for (source, session) in &mut self.apart {
                let alone = solved(self.nominal, compensate(session, &source.task(task), Method::None))?;
                superposition_error += alone.position_error;
            }
            seen.superposition_error = superposition_error.norm();
        }
        if self.exact != Exact::NotAsked {
            self.correct(task, plain, &mut seen)?;
        }
        Ok(seen)
    }

    /// Refuses a point at which the machine stands on another branch than at the first: no path leads there.
    fn keep_branch(&mut self) -> Result<(), Refusal> {
        if self.nominal.branch_of(&self.nominal.home).is_none() {
            return Ok(());
        }
        let here = self.both.command();
        let Some(first) = &self.first else {
            self.first = Some(here.clone());
            return Ok(());
        };
        match self.nominal.posture_change(first, here, true) {
            Some(change @ PostureChange::Branch { .. }) => {
                let (before_mm, here_mm) = (first.pose.translation, here.pose.translation);
                let status = CompensationStatus::ChangesPosture { change, before_mm, here_mm };
                Err(refusal(&status, status.reason(self.nominal)))
            }
            _ => Ok(()),
        }
    }

    fn correct(&mut self, task: &TaskPoint, plain: &Compensation, seen: &mut Seen) -> Result<(), Refusal> {
        let exact = compensate(&mut self.both, task, Method::Direct);
        let judged = self.judge_correction(plain, &exact, seen);
        self.last.exact = Some(exact);
        judged
    }

    fn judge_correction(&mut self, plain: &Compensation, exact: &Compensation, seen: &mut Seen) -> Result<(), Refusal> {
        if !exact.status.is_success() {
            seen.is_uncorrected = true;
            return if self.exact == Exact::Needed { Err(uncorrected(self.nominal, &exact.status)) } else { Ok(()) };
        }
        if self.exact == Exact::Needed {
            self.note_limits();
        }
        let is_mixed = self.nominal.has_mixed_drives();
        for (k, (_, drive)) in self.nominal.drives().enumerate() {
            let delta = (exact.drives[k] - plain.drives[k]).abs();
            let correction = drive.motion.shown(delta);
            let (force, limit) = (exact.drive_forces[k].abs(), self.force_limits[k]);
            if is_mixed && drive.motion == Motion::Revolute {
                let [most, torque] = seen.hinges.unwrap_or_default();
                seen.hinges = Some([most.max(correction), torque.max(force)]);
            } else {
                seen.correction = seen.correction.max(correction);
                seen.force = seen.force.max(force);
            }
            if self.check_forces && force > limit {
                return Err(self.overloaded(k, force));
            }
            if let Some(shares) = self.shares.as_mut().filter(|_| self.check_forces && limit.is_finite()) {
                shares.push(exact.drive_forces[k] / limit);
            }
            if limit.is_finite() {
                let margin = (limit - force) / limit;
                seen.margin = Some(seen.margin.map_or(margin, |least| least.min(margin)));
            }
        }
        Ok(())
    }

    fn note_limits(&mut self) {
        if let Some(shares) = &mut self.shares {
            self.nominal.limit_shares(self.both.command(), shares);
        }
    }

    fn overloaded(&self, drive: usize, force: f64) -> Refusal {
        let label = &self.nominal.drive_labels()[drive];
        let unit = self.nominal.drives().nth(drive).map_or("", |(_, drive)| drive.motion.shown_force_unit());
        let limit = self.force_limits[drive];
        let reason = format!("drive {label} needs {force:.1} {unit}, its limit is {limit:.1} {unit}");
        Refusal { failure: Failure { status: "force_limit".into(), reason }, excess: (force - limit) / limit }
    }
}

fn solved(machine: &Machine, answer: Compensation) -> Result<Compensation, Refusal> {
    if answer.status.is_success() {
        return Ok(answer);
    }
    Err(refusal(&answer.status, answer.status.reason(machine)))
}

fn refusal(status: &CompensationStatus, reason: String) -> Refusal {
    let excess =
        if let CompensationStatus::Unreachable(unreachable) = status { excess(unreachable) } else { UNMEASURED };
    Refusal { failure: Failure { status: status.label().into(), reason }, excess }
}

/// The point is in reach and the loaded machine stands there, but not with its error compensated.
fn uncorrected(machine: &Machine, status: &CompensationStatus) -> Refusal {
    let reason = match status {
        CompensationStatus::Unreachable(Unreachable::Travel { chain, drive, value, low, high, unit }) => format!(
            "the corrected drive {drive} of chain {chain} would stand at {value:.3} {unit}, beyond its travel of \
             {low:.3} to {high:.3} {unit}"
        ),
        status => format!("there is no correction: {}", status.reason(machine)),
    };
    refusal(status, reason)
}
