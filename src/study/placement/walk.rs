//! The machine being led over points of a path, each solved from the one before.

use super::tally::{Needs, Seen};
use crate::{
    compensation::{Compensation, Demand, Method, Session, compensate},
    machine::{Machine, Motion},
    spatial::Wrench,
    statics::smallest_eigenvalue,
    study::{Failure, path::settings},
};

/// Sessions for everything a point is asked, standing at home.
///
/// [`super::super::path::run`] answers more (the modified target, which needs forward kinematics) and in blocks of its
/// own; a search asks many short pieces of paths for a few numbers.
pub(super) struct Walk<'a> {
    nominal: &'a Machine,
    needs: Needs,
    /// Most force of each drive, N or N·mm; infinite where there is no limit.
    force_limits: &'a [f64],
    /// Whether an exact correction beyond a limit is refused.
    check_forces: bool,
    both: Session<'a>,
    /// The cutting force on the nominal machine, and the unloaded real machine.
    apart: Option<[Session<'a>; 2]>,
}

impl<'a> Walk<'a> {
    pub fn new(
        nominal: &'a Machine,
        real: &'a Machine,
        needs: Needs,
        force_limits: &'a [f64],
        check_forces: bool,
    ) -> Self {
        let session = |real| Session::new(nominal, real, settings());
        Self {
            nominal,
            needs,
            force_limits,
            check_forces,
            both: session(real),
            apart: needs.departure.then(|| [session(nominal), session(real)]),
        }
    }

    /// What happens at one point.
    pub fn visit(&mut self, demand: &Demand) -> Result<Seen, Failure> {
        let plain = solved(self.nominal, compensate(&mut self.both, demand, Method::None))?;
        let mut seen = Seen { deflection: plain.position_error.norm(), ..Seen::default() };
        if self.needs.stability {
            let stiffness = plain.outcome.as_ref().and_then(|outcome| outcome.stiffness);
            seen.stability = stiffness.map(|stiffness| smallest_eigenvalue(&stiffness, self.nominal.reach));
        }
        if let Some([cutting, assembly]) = &mut self.apart {
            let cut = solved(self.nominal, compensate(cutting, demand, Method::None))?;
            let unloaded = Demand { load: Wrench::zero(), ..*demand };
            let assembled = solved(self.nominal, compensate(assembly, &unloaded, Method::None))?;
            seen.departure = (cut.position_error + assembled.position_error - plain.position_error).norm();
        }
        if self.needs.correction {
            self.correct(demand, &plain, &mut seen)?;
        }
        Ok(seen)
    }

    fn correct(&mut self, demand: &Demand, plain: &Compensation, seen: &mut Seen) -> Result<(), Failure> {
        let exact = solved(self.nominal, compensate(&mut self.both, demand, Method::Direct))?;
        let is_mixed = self.nominal.has_mixed_drives();
        for (k, (_, drive)) in self.nominal.drives().enumerate() {
            let delta = (exact.drives[k] - plain.drives[k]).abs();
            let correction = if drive.motion == Motion::Revolute { delta.to_degrees() } else { delta };
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
            if limit.is_finite() {
                let margin = (limit - force) / limit;
                seen.margin = Some(seen.margin.map_or(margin, |least| least.min(margin)));
            }
        }
        Ok(())
    }

    fn overloaded(&self, drive: usize, force: f64) -> Failure {
        let label = &self.nominal.drive_labels()[drive];
        let is_slide = self.nominal.drives().nth(drive).is_some_and(|(_, drive)| drive.motion == Motion::Prismatic);
        let unit = if is_slide { "N" } else { "N·mm" };
        let limit = self.force_limits[drive];
        let reason = format!("drive {label} needs {force:.1} {unit}, its limit is {limit:.1} {unit}");
        Failure { status: "force_limit".into(), reason }
    }
}

fn solved(machine: &Machine, answer: Compensation) -> Result<Compensation, Failure> {
    if answer.status.is_success() {
        return Ok(answer);
    }
    Err(Failure { status: answer.status.label().into(), reason: answer.status.reason(machine) })
}
