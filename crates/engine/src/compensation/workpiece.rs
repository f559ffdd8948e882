//! Where the workpiece stands under what the tool does to it.
//!
//! The tool bears a load that is given; the workpiece bears the opposite one at the same point. Nothing of the tool's motion enters,
//! so its carrier settles first, with the engine of the machine, and tells where the tool is wanted.

use nalgebra::{Matrix3, Vector3};

use super::{outcome::CompensationStatus, task_point::TaskPoint};
use crate::{
    machine::Machine,
    spatial::{Pose, Wrench},
    statics::{self, Outcome, State, Workspace, equilibrium, tool_compliance},
};

/// A workpiece carrier, nominal and as it answers.
#[derive(Debug, Clone)]
pub(super) struct Workpiece {
    nominal: Machine,
    real: Machine,
    workspace: Workspace,
}

impl Workpiece {
    /// The carrier of the workpiece of `nominal`, and the one that answers with `real`; `None` where it stands fast.
    pub fn new(nominal: &Machine, real: &Machine) -> Option<Self> {
        let (nominal, real) = (nominal.carrier.clone()?, real.carrier.clone()?);
        Some(Self { workspace: Workspace::new(&real), nominal, real })
    }

    /// Has the carrier stand as that of `machine` does.
    pub fn stand(&mut self, machine: &Machine) {
        let Some(carrier) = &machine.carrier else { return };
        self.nominal.home.clone_from(&carrier.home);
        self.real.home.clone_from(&carrier.home);
    }

    /// How the load of `task` has moved the workpiece in O: a pose `X` that takes what it carried from where it was to `X` times
    /// that. It was where the nominal carrier rests under its weight, if it is zeroed `at_rest`, or else where the rigid one stands.
    /// `tool_tip`: `p_PT` in platform axes, mm.
    ///
    /// # Errors
    /// The carrier has no stable equilibrium.
    pub fn moved(
        &mut self,
        task: &TaskPoint,
        tool_tip: Vector3<f64>,
        at_rest: bool,
        settings: &statics::Settings,
    ) -> Result<Pose, CompensationStatus> {
        let (touched, load) = on_workpiece(task, tool_tip);
        let before = match at_rest {
            true => settled(&mut self.nominal, touched, &Wrench::zero(), &mut self.workspace, settings)?.0,
            false => Pose { translation: touched, ..self.real.home.pose },
        };
        let (after, _) = settled(&mut self.real, touched, &load, &mut self.workspace, settings)?;
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
        let (touched, load) = on_workpiece(task, tool_tip);
        let (_, outcome) = settled(&mut self.real, touched, &load, &mut self.workspace, settings)?;
        let compliance = outcome.compliance.map(|compliance| tool_compliance(&compliance, Vector3::zeros()));
        Ok(compliance.unwrap_or_else(Matrix3::zeros))
    }
}

/// Where the tool of `task` touches (O, mm), and the load on the workpiece there.
fn on_workpiece(task: &TaskPoint, tool_tip: Vector3<f64>) -> (Vector3<f64>, Wrench) {
    let lever = task.pose.rotation * tool_tip;
    let on_tool = task.load.shift(lever);
    (task.pose.translation + lever, Wrench { force: -on_tool.force, moment: -on_tool.moment })
}

/// Where the point of a `carrier` that is `touched` (O, mm) without load settles under a dead wrench there.
fn settled(
    carrier: &mut Machine,
    touched: Vector3<f64>,
    load: &Wrench,
    workspace: &mut Workspace,
    settings: &statics::Settings,
) -> Result<(Pose, Outcome), CompensationStatus> {
    let at = carrier.touched_at(touched);
    let mut state = State::rigid(carrier, &at);
    let outcome = equilibrium(carrier, &at.drives, load, &mut state, workspace, settings);
    match outcome.status {
        statics::Status::Solved => Ok((state.pose, outcome)),
        status => {
            let reason = format!("workpiece carrier {}: {}", carrier.name, status.reason(carrier));
            Err(CompensationStatus::Workpiece { status, reason })
        }
    }
}
