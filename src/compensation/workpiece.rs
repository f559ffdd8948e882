//! Where the workpiece stands under what the tool does to it.
//!
//! The tool bears a load that is given; the workpiece bears the opposite one at the same point. Nothing of the tool's motion enters,
//! so its carrier settles first, with the engine of the machine, and tells where the tool is wanted.

use nalgebra::Vector3;

use super::{demand::Demand, outcome::CompensationStatus};
use crate::{
    machine::Machine,
    spatial::{Pose, Wrench},
    statics::{self, State, Workspace, equilibrium},
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

    /// How the load of `demand` has moved the workpiece in O: a pose `X` that takes what it carried from where it was to `X` times
    /// that. It was where the nominal carrier rests under its weight, if it is zeroed `at_rest`, or else where the rigid one stands.
    /// `tool_tip`: `p_PT` in platform axes, mm.
    ///
    /// # Errors
    /// The carrier has no stable equilibrium.
    pub fn moved(
        &mut self,
        demand: &Demand,
        tool_tip: Vector3<f64>,
        at_rest: bool,
        settings: &statics::Settings,
    ) -> Result<Pose, CompensationStatus> {
        let lever = demand.pose.rotation * tool_tip;
        let touched = demand.pose.translation + lever;
        let on_tool = demand.load.shift(lever);
        let load = Wrench { force: -on_tool.force, moment: -on_tool.moment };
        let before = match at_rest {
            true => settled(&mut self.nominal, touched, &Wrench::zero(), &mut self.workspace, settings)?,
            false => Pose { translation: touched, ..self.real.home.pose },
        };
        let after = settled(&mut self.real, touched, &load, &mut self.workspace, settings)?;
        Ok(after.compose(&before.inverse()))
    }
}

/// Where the point of a `carrier` that is `touched` (O, mm) without load settles under a dead wrench there.
fn settled(
    carrier: &mut Machine,
    touched: Vector3<f64>,
    load: &Wrench,
    workspace: &mut Workspace,
    settings: &statics::Settings,
) -> Result<Pose, CompensationStatus> {
    let at = carrier.touched_at(touched);
    let mut state = State::rigid(carrier, &at);
    match equilibrium(carrier, &at.drives, load, &mut state, workspace, settings).status {
        statics::Status::Solved => Ok(state.pose),
        status => {
            let reason = format!("workpiece carrier {}: {}", carrier.name, status.reason(carrier));
            Err(CompensationStatus::Workpiece { status, reason })
        }
    }
}
