//! The loaded machine at a position: what must be commanded there under a force, and what a command leaves.

use nalgebra::Vector3;

use super::CorrectionQuestion;
use crate::{
    compensation::{Compensation, Demand, Method, Session, compensate, simulate_drives},
    input::error::{Error, Result},
    machine::Configuration,
    questions::Overrides,
    simulation::{Machines, Source},
    spatial::{Pose, Wrench},
    statics::State,
};

/// The machine that answers. What it answers depends on nothing that was asked before.
pub(super) struct Loaded<'a> {
    question: &'a CorrectionQuestion,
    session: Session,
}

impl<'a> Loaded<'a> {
    pub fn new(question: &'a CorrectionQuestion, machines: &Machines) -> Self {
        Self { question, session: machines.session(Source::All) }
    }

    /// Where the nominal machine stands with P at `position` (O, mm).
    ///
    /// # Errors
    /// It does not reach it.
    pub fn stand(&self, position: Vector3<f64>) -> Result<Configuration> {
        let machine = &self.question.machine;
        let pose = Pose { rotation: self.question.orientation, translation: machine.as_controlled(position) };
        let reached = machine.inverse_kinematics(&pose).and_then(|at| {
            match machine.turns_with_position {
                true => machine.check_asked(pose.translation, &at)?,
                false => machine.check_led(&pose, &at)?,
            }
            Ok(at)
        });
        reached.map_err(|unreachable| hole(position, None, &unreachable.to_string()))
    }

    /// Δρ of each drive by which the tool is where it is wanted under a force on its tip (O axes, N), mm or rad.
    ///
    /// # Errors
    /// There are no such commands.
    pub fn exact(&mut self, at: &Configuration, force: Vector3<f64>) -> Result<Vec<f64>> {
        let demand = self.stand_at(at, force);
        let found = compensate(&mut self.session, &demand, Method::Direct);
        self.checked(at, force, &found)?;
        Ok(found.drives.iter().zip(&at.drives).map(|(rho, nominal)| rho - nominal).collect())
    }

    /// How far the tool is from where it is wanted with the drives corrected by `correction` (mm, rad) under a force on its tip (O
    /// axes, N), in what is put right and controlled, mm (rotations at the machine's reach).
    ///
    /// # Errors
    /// The machine does not stand there.
    pub fn left_mm(&mut self, at: &Configuration, force: Vector3<f64>, correction: &[f64]) -> Result<f64> {
        let demand = self.stand_at(at, force);
        let drives: Vec<f64> = at.drives.iter().zip(correction).map(|(nominal, own)| nominal + own).collect();
        let found = simulate_drives(&mut self.session, &demand, &drives);
        self.checked(at, force, &found)?;
        match found.task_error() {
            left if left.is_finite() => Ok(left),
            _ => Err(hole(at.pose.translation, Some(force), "the error of the tool is not a number")),
        }
    }

    fn stand_at(&mut self, at: &Configuration, force: Vector3<f64>) -> Demand {
        let machine = &self.question.machine;
        self.session.stand(at, &State::rigid(machine, at));
        let moment = (at.pose.rotation * machine.tool_tip).cross(&force);
        let target = self.question.target;
        Demand { pose: at.pose, load: Wrench { force, moment }, target, wanted: None, external: None }
    }

    fn checked(&self, at: &Configuration, force: Vector3<f64>, found: &Compensation) -> Result<()> {
        match found.status.is_success() {
            true => Ok(()),
            false => Err(hole(at.pose.translation, Some(force), &found.status.reason(&self.question.machine))),
        }
    }
}

/// A position without which there is no table.
fn hole(position: Vector3<f64>, force: Option<Vector3<f64>>, reason: &str) -> Error {
    // What is nothing has no sign.
    let shown = |v: Vector3<f64>| v.map(|value| (value * 1e3).round() / 1e3 + 0.0);
    let under = force.filter(|force| *force != Vector3::zeros()).map(shown);
    let under = under.map_or_else(String::new, |f| format!(" under a force of ({:.0}, {:.0}, {:.0}) N", f.x, f.y, f.z));
    let [x, y, z]: [f64; 3] = shown(position).into();
    let problem = format!(
        "there is no correction for P at ({x:.3}, {y:.3}, {z:.3}) mm{under}: {reason}; a table has no holes: expected a smaller box"
    );
    Error::Value { file: Overrides::ORIGIN.into(), key: "box".into(), problem }
}
