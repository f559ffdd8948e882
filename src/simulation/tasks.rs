//! What is wanted at each point of a path: a pose of P and the load there.

use nalgebra::Vector3;

use crate::{
    compensation::{Target, TaskPoint},
    input::error::{Error, Result},
    machine::{Configuration, ExternalAxes, Machine},
    process::{
        Placed, Placement,
        cutting::{LoadError, PathLoad},
        file::Process,
    },
    simulation::external_axes::along,
    spatial::{Pose, Wrench},
    toolpath::{Orientation, PathPoint, Toolpath},
};

/// The machine being tracked along positions of a path, each from the one before.
pub(crate) struct Tracked<'a> {
    machine: &'a Machine,
    placement: &'a Placement,
    placed: Placed,
    external: Option<ExternalAxes>,
    near: Configuration,
}

impl<'a> Tracked<'a> {
    /// A machine at home, and where the workpiece is.
    pub fn new(machine: &'a Machine, placement: &'a Placement) -> Self {
        let placed = placed(machine, placement);
        Self { machine, placement, placed, external: None, near: machine.home.clone() }
    }

    /// Where the workpiece is with the external axes at `external`.
    pub fn placed(&mut self, external: Option<ExternalAxes>) -> &Placed {
        if external != self.external {
            let standing = |axes: ExternalAxes| {
                let turned = self.machine.is_turned_by_locked().then(|| self.machine.standing(&axes).ok()).flatten();
                turned.unwrap_or_else(|| self.machine.carried(&axes))
            };
            let there = external.map_or_else(|| self.machine.clone(), standing);
            self.placed = placed(&there, self.placement);
            self.external = external;
        }
        &self.placed
    }

    /// The pose `X_OP` to ask for so that the path's point stands at `position_mm` (W, mm) as far as the drives control its
    /// translations, the tool as the path's `orientation` says. Where the platform turns with its position this is the pose in which the machine stands there; what
    /// it cannot reach keeps the orientation of home, and is refused when it is asked for.
    pub fn pose(
        &mut self,
        position_mm: Vector3<f64>,
        orientation: Option<&Orientation>,
        external: Option<ExternalAxes>,
    ) -> Pose {
        let placed = self.placed(external);
        let asked = match orientation {
            Some(orientation) => placed.oriented(orientation).platform_pose(position_mm),
            None => placed.platform_pose(position_mm),
        };
        let controlled = Pose { translation: self.machine.as_controlled(asked.translation), ..asked };
        if !self.machine.turns_with_position {
            return controlled;
        }
        match self.machine.lead(self.placed.reference(), &asked, &self.near) {
            Ok(at) => {
                self.near = at;
                let Pose { rotation, translation } = self.near.pose;
                Pose { rotation, translation: self.machine.as_controlled(translation) }
            }
            Err(_) => controlled,
        }
    }
}

/// The placement on the machine, or on its workpiece carrier, with the platform oriented as at home.
pub(crate) fn placed(machine: &Machine, placement: &Placement) -> Placed {
    let mut placed = placement.on(&machine.home.pose.rotation, &machine.tool());
    if machine.is_turned_by_locked() {
        placed = placed.turned(&machine.home.pose.rotation);
    }
    match &machine.carrier {
        Some(carrier) => placed.carried(&carrier.home.pose),
        None => placed,
    }
}

/// What is wanted at each point of a path: its pose, and the cutting force as a wrench at P. `origin` names the path in
/// errors.
///
/// # Errors
/// A path that lacks what the cutting force needs.
pub fn tasks(process: &Process, path: &Toolpath, origin: &str) -> Result<Vec<TaskPoint>> {
    let fault = |source: LoadError| Error::Argument { argument: origin.to_string(), problem: source.to_string() };
    let loads = process.loads(path).map_err(fault)?;
    Ok(tasks_under(&process.machine, &process.placement, process.target, path, &loads))
}

/// What is wanted at each point of a path that is placed by `placement`, under `loads`; along axes that the drives do not
/// control, what there is.
pub fn tasks_under(
    machine: &Machine,
    placement: &Placement,
    target: Target,
    path: &Toolpath,
    loads: &[PathLoad],
) -> Vec<TaskPoint> {
    let mut unloaded = unloaded(machine, placement, target, path);
    let task = |(point, load): (&PathPoint, &PathLoad)| {
        let (task, there) = unloaded(point);
        TaskPoint { load: there.wrench(&load.on_tool(point.tangent, there.tool_axes())), ..task }
    };
    path.points().iter().zip(loads).map(task).collect()
}

/// What is wanted without load, and how workpiece and tool stand there, asked for points of `path` one after another.
pub(crate) fn unloaded<'a>(
    machine: &'a Machine,
    placement: &'a Placement,
    target: Target,
    path: &'a Toolpath,
) -> impl FnMut(&PathPoint) -> (TaskPoint, Placed) + use<'a> {
    let mut track = Tracked::new(machine, placement);
    let external = along(machine, path);
    move |point| {
        let external = external(point);
        let pose = track.pose(point.position_mm, point.orientation.as_ref(), external);
        let there = track.placed(external).turned(&pose.rotation);
        (TaskPoint { pose, load: Wrench::zero(), target, wanted: None, external }, there)
    }
}
