//! Motion of the workpiece under what the tool does to it.
//!
//! The tool bears a load that is given; the workpiece bears the opposite one at the same point. Nothing of the tool's motion enters,
//! so the equilibrium of its carrier is found first, with the engine of the machine, and gives the pose wanted of the tool.

use nalgebra::{Matrix3, Vector3};

use super::{outcome::CompensationStatus, task_point::TaskPoint};
use crate::{
    machine::Machine,
    spatial::{Pose, Wrench},
    statics::{self, Outcome, Scratch, State, equilibrium, tool_compliance},
};

/// A workpiece carrier, nominal and actual.
#[derive(Debug, Clone)]
pub(super) struct Workpiece {
    nominal: Machine,
    actual: Machine,
    scratch: Scratch,
}

impl Workpiece {
    /// Carrier of the workpiece of `nominal`, and of `actual`; `None` where the workpiece does not move.
    pub fn new(nominal: &Machine, actual: &Machine) -> Option<Self> {
        let (nominal, actual) = (nominal.carrier.clone()?, actual.carrier.clone()?);
        Some(Self { scratch: Scratch::new(&actual), nominal, actual })
    }

    /// Sets the home of both carriers to that of the carrier of `machine`.
    pub fn set_home(&mut self, machine: &Machine) {
        let Some(carrier) = &machine.carrier else { return };
        self.nominal.home.clone_from(&carrier.home);
        self.actual.home.clone_from(&carrier.home);
    }

    /// Displacement of the workpiece in O by the load of `task`: a pose `X` that takes what it carried from where it was to `X` times that. It
    /// was where the nominal carrier rests under its weight, if calibrated `at_rest`, or where the rigid one is. `tool_tip`: in platform axes, mm.
    ///
    /// # Errors
    /// The carrier has no stable equilibrium.
    pub fn displacement(
        &mut self,
        task: &TaskPoint,
        tool_tip: Vector3<f64>,
        at_rest: bool,
        settings: &statics::Settings,
    ) -> Result<Pose, CompensationStatus> {
        let (touched, load) = contact_load(task, tool_tip);
        let before = match at_rest {
            true => equilibrium_under(&mut self.nominal, touched, &Wrench::zero(), &mut self.scratch, settings)?.0,
            false => Pose { translation: touched, ..self.actual.home.pose },
        };
        let (after, _) = equilibrium_under(&mut self.actual, touched, &load, &mut self.scratch, settings)?;
        Ok(after.compose(&before.inverse()))
    }

    /// Compliance of the workpiece where the tool of `task` touches it under its load: displacement in O per force, mm/N.
    ///
    /// # Errors
    /// The carrier has no stable equilibrium.
    pub fn compliance(
        &mut self,
        task: &TaskPoint,
        tool_tip: Vector3<f64>,
        settings: &statics::Settings,
    ) -> Result<Matrix3<f64>, CompensationStatus> {
        let (touched, load) = contact_load(task, tool_tip);
        let (_, outcome) = equilibrium_under(&mut self.actual, touched, &load, &mut self.scratch, settings)?;
        let compliance = outcome.compliance.map(|compliance| tool_compliance(&compliance, Vector3::zeros()));
        Ok(compliance.unwrap_or_else(Matrix3::zeros))
    }
}

/// Point where the tool of `task` touches the workpiece (O, mm), and the load on the workpiece there.
fn contact_load(task: &TaskPoint, tool_tip: Vector3<f64>) -> (Vector3<f64>, Wrench) {
    let lever = task.pose.rotation * tool_tip;
    let on_tool = task.load.shift(lever);
    (task.pose.translation + lever, Wrench { force: -on_tool.force, moment: -on_tool.moment })
}

/// Pose in O, and outcome, of the carrier's equilibrium under a dead wrench at the point that is `touched` (O, mm) without load.
fn equilibrium_under(
    carrier: &mut Machine,
    touched: Vector3<f64>,
    load: &Wrench,
    scratch: &mut Scratch,
    settings: &statics::Settings,
) -> Result<(Pose, Outcome), CompensationStatus> {
    let at = carrier.set_touch_point(touched);
    let mut state = State::rigid(carrier, &at);
    let outcome = equilibrium(carrier, &at.drives, load, &mut state, scratch, settings);
    match outcome.status {
        statics::Status::Solved => Ok((state.pose, outcome)),
        status => {
            let reason = format!("workpiece carrier {}: {}", carrier.name, status.reason(carrier));
            Err(CompensationStatus::Workpiece { status, reason })
        }
    }
}
