//! Limits of drive forces where inputs are uncertain: tightened in the optimisation until they hold in enough draws, and checked in others.
//!
//! A draw is one machine and one factor of the cutting force for the whole program. The engine solves each in full.

use std::ops::Range;

use super::{ProgramAsWritten, ProgramCommands, ProgramJob, bounded::LimitExcess};
use crate::{
    compensation::{BoundedPath, BoundedSettings, LimitKind},
    input::error::{Error, Result},
    process::uncertainty::{Draws, P95, Uncertainty},
    simulation::{
        along_path::Commands,
        drawn_forces::{DrawnForces, ForcedPart, larger_forces},
        spread::DrawnMachines,
        within_limits::force_limits,
    },
    work::Work,
};

/// How sure it is that drive forces stay within their limits all along the program as written.
#[derive(Debug, Clone, PartialEq)]
pub struct ForceCheck {
    /// Number of draws, independent of one another and of those by which limits were tightened.
    pub draws: usize,
    /// Number of those in which all forces stay within their limits; a draw without equilibrium somewhere does not count.
    pub within: usize,
    /// Number of those without equilibrium somewhere.
    pub failed: usize,
    /// What comes nearest to its limit, or exceeds it most, in the draw that 95 % of the draws do not exceed.
    pub p95: LimitExcess,
    /// By which share the limit of each drive was tightened in the optimisation, machine order.
    pub tightened: Vec<f64>,
    /// Largest error that the corrections would leave without that, with nominal numbers, mm.
    pub untightened_mm: f64,
}

/// Force limits as they were tightened.
#[derive(Debug)]
pub(super) struct TightenedForces {
    /// Limit of each drive in the optimisation, N or N·mm.
    tightened: Vec<f64>,
    /// Largest error that the corrections leave within the limits themselves, mm.
    untightened_mm: f64,
    /// Why they could not be tightened further, if that would have been needed.
    hindrance: Option<String>,
}

/// Draws by which limits are tightened: the first scramble of those by which distances are judged, since few of them are spread evenly.
const TIGHTENING: usize = Draws::PER_SCRAMBLE;
/// Draws that may exceed the limits while they are tightened. Where they hold in less than 95 %, so few of independent draws do in 3 % of cases.
const MAX_ABOVE: usize = 6;
/// Draws that check the program, independent of one another.
const CHECKING: usize = 512;
/// Most times that limits are tightened.
const MAX_TIGHTENINGS: usize = 8;
/// Limits are tightened by so much more than their shares ask for, as forces are not quite proportional.
const CLOSER: f64 = 1e-3;

/// Returns the force of a draw that is the largest share of its limit; infinite without equilibrium.
fn nearest(found: &DrawnForces, limits: &[f64]) -> LimitExcess {
    let of = |drive, value, point, limit| LimitExcess { kind: LimitKind::Force, drive, point, value, limit };
    let none = of(0, f64::INFINITY, 0, 1.0);
    let Ok(forces) = found else { return none };
    let limited = forces.iter().zip(limits).enumerate().filter(|(_, (_, limit))| limit.is_finite());
    let each = limited.map(|(drive, ((value, point), limit))| of(drive, *value, *point, *limit));
    each.max_by(|a, b| a.share().total_cmp(&b.share())).unwrap_or(none)
}

/// Whether a force is within its limit, to the tolerance of the optimisation.
fn is_within(force: &LimitExcess) -> bool {
    force.share() <= 1.0 + BoundedSettings::default().force_tolerance
}

impl ProgramJob {
    /// Returns the machines of the draws that `draws` makes of what is uncertain; `None` where no force is limited, or nothing that a force depends on
    /// is uncertain.
    fn machines_under_limits(&self, draws: impl Fn(&Uncertainty) -> Uncertainty) -> Result<Option<DrawnMachines>> {
        let is_limited = force_limits(&self.machine, &self.process.limits).iter().any(|limit| limit.is_finite());
        let varies = self.uncertainty.as_ref().filter(|own| is_limited && own.varies_machine_or_force());
        let Some(uncertainty) = varies else { return Ok(None) };
        DrawnMachines::new(Some(&draws(uncertainty)), &self.machines, &self.errors)
    }

    /// Returns the largest forces in each of `draws` at `commands` over the points that `path` corrects.
    fn forces_in(
        &self,
        drawn: &DrawnMachines,
        draws: Range<usize>,
        path: &BoundedPath,
        commands: &ProgramCommands<'_>,
        work: &Work,
    ) -> Result<Vec<DrawnForces>> {
        let (mut before, mut track) = (None, self.tracker());
        let counts = |point: usize| path.points[point].corrected().is_some();
        let mut all = vec![Ok(vec![(0.0, 0); self.machine.drive_count()]); draws.len()];
        for part in self.parts() {
            let part = part?;
            let along = self.track(&part, &mut before);
            let run = |commands: &Commands<'_>| {
                let part = ForcedPart { first: part.first, track: &along, tasks: part.tasks(), forces: part.forces() };
                drawn.largest_forces(draws.clone(), &part, commands, &counts, work)
            };
            all = larger_forces(all, self.part_results(&part, &mut track, commands, &run)?);
        }
        Ok(all)
    }

    /// Returns the force limits for each drive with which those of process and machine hold in all draws but [`MAX_ABOVE`], and the path that `correct`
    /// finds within them, from `path` on, which is within the limits themselves. Ends where there is no such path, with the last one that there is.
    ///
    /// # Errors
    /// Of `work`.
    pub(super) fn tighten_forces(
        &self,
        mut path: BoundedPath,
        correct: &dyn Fn(Vec<f64>) -> Result<BoundedPath>,
        work: &Work,
    ) -> Result<(BoundedPath, Option<TightenedForces>)> {
        let Some(drawn) = self.machines_under_limits(Uncertainty::clone)? else { return Ok((path, None)) };
        let limits = force_limits(&self.machine, &self.process.limits);
        let (untightened_mm, mut tightened, mut hindrance) = (path.summary.after.worst, limits.clone(), None);
        for _ in 0..MAX_TIGHTENINGS {
            let drives = self.drives_along(&path);
            let commands = ProgramCommands::Drives(&drives);
            let mut found = self.forces_in(&drawn, 0..TIGHTENING, &path, &commands, work)?;
            found.sort_by(|a, b| nearest(a, &limits).share().total_cmp(&nearest(b, &limits).share()));
            found.truncate(TIGHTENING - MAX_ABOVE);
            let kept: Vec<Vec<(f64, usize)>> = found.iter().flatten().cloned().collect();
            // No tightening helps where too many have no equilibrium: the check says so.
            if kept.len() < found.len() || found.last().is_none_or(|most| is_within(&nearest(most, &limits))) {
                break;
            }
            let next = (0..limits.len()).map(|drive| {
                let share = kept.iter().fold(0.0, |most: f64, forces| most.max(forces[drive].0)) / limits[drive];
                let corrected = path.points.iter().filter_map(|point| point.corrected());
                let nominal = corrected.fold(0.0, |most: f64, point| most.max(point.drive_forces[drive].abs()));
                if share > 1.0 { (1.0 - CLOSER) * nominal / share } else { tightened[drive] }
            });
            let next: Vec<f64> = next.collect();
            match correct(next.clone()) {
                Ok(found) => (path, tightened) = (found, next),
                Err(Error::Argument { problem, .. }) => {
                    hindrance = Some(problem);
                    break;
                }
                Err(other) => return Err(other),
            }
        }
        Ok((path, Some(TightenedForces { tightened, untightened_mm, hindrance })))
    }

    /// Checks by other draws that the limits of drive forces hold along the program as `written`.
    ///
    /// # Errors
    /// They hold in less than 95 %: named with drive, force and place; errors of `work`.
    pub(super) fn check_forces(
        &self,
        forces: TightenedForces,
        path: &BoundedPath,
        written: &ProgramAsWritten,
        work: &Work,
    ) -> Result<Option<ForceCheck>> {
        let TightenedForces { tightened, untightened_mm, hindrance } = forces;
        let independent = |own: &Uncertainty| own.with_independent_draws(CHECKING);
        let Some(drawn) = self.machines_under_limits(independent)? else { return Ok(None) };
        let limits = force_limits(&self.machine, &self.process.limits);
        let commands = ProgramCommands::CommandedPath(&written.sent);
        let found = self.forces_in(&drawn, 0..CHECKING, path, &commands, work)?;
        let mut all: Vec<LimitExcess> = found.iter().map(|own| nearest(own, &limits)).collect();
        all.sort_by(|a, b| a.share().total_cmp(&b.share()));
        let within = all.iter().filter(|own| is_within(own)).count();
        let p95 = all[(P95 * CHECKING as f64).ceil() as usize - 1];
        let failed = found.iter().filter(|own| own.is_err()).count();
        if within as f64 >= P95 * CHECKING as f64 {
            let share = |(own, limit): (&f64, &f64)| if own < limit { 1.0 - own / limit } else { 0.0 };
            let tightened = tightened.iter().zip(&limits).map(share).collect();
            return Ok(Some(ForceCheck { draws: CHECKING, within, failed, p95, tightened, untightened_mm }));
        }
        let why = match found.iter().find_map(|own| own.as_ref().err()) {
            Some(first) if !p95.value.is_finite() => {
                format!("{failed} have no equilibrium, the first: {}", first.reason)
            }
            _ => {
                let (label, motion) = (&self.machine.drive_labels()[p95.drive], self.machine.drives().nth(p95.drive));
                let unit = motion.map_or("N", |(_, drive)| drive.motion.shown_force_unit());
                let tighter = hindrance.map_or_else(String::new, |why| format!("; within tighter limits: {why}"));
                format!(
                    "in 95 of 100 the force of drive {label} is up to {:.1} {unit}, {}, and its limit is {} {unit}{tighter}",
                    p95.value,
                    self.place_text(p95.point),
                    p95.limit
                )
            }
        };
        let problem = format!(
            "drive forces stay within their limits in only {within} of {CHECKING} draws of machine and cutting force, expected 95 %: {why}. A smaller \
             cutting force, a higher limit or inputs that are better known let them hold"
        );
        Err(Error::argument("limits", problem))
    }
}
