//! Task points of a path: the wanted pose of P at each point, and the load there.

use nalgebra::{Matrix3, Vector3};

use crate::{
    compensation::{Target, TaskPoint},
    input::error::{Error, Result},
    machine::{Configuration, ExternalAxes, Machine},
    process::{
        CutPath, PlacedWorkpiece, Placement,
        cutting::{LoadError, PathLoad},
        file::Process,
        uncertainty::{DrawnForceAt, ForceSpread, Uncertainty},
    },
    simulation::external_axes::axes_along,
    spatial::{Pose, Wrench},
    toolpath::{Orientation, PathPoint},
};

/// Finds poses of P along a path, each from the one before, and the place of the workpiece.
pub(crate) struct PoseTracker<'a> {
    machine: &'a Machine,
    placement: &'a Placement,
    placed: PlacedWorkpiece,
    external: Option<ExternalAxes>,
    near: Configuration,
}

impl<'a> PoseTracker<'a> {
    /// Creates a tracker of a machine at home with the workpiece at `placement`.
    pub fn new(machine: &'a Machine, placement: &'a Placement) -> Self {
        let placed = placement.place(machine);
        Self { machine, placement, placed, external: None, near: machine.home.clone() }
    }

    /// Returns the place of the workpiece and tool with the external axes at `external`.
    pub fn placed(&mut self, external: Option<ExternalAxes>) -> &PlacedWorkpiece {
        if external != self.external {
            let with_external_axes = |axes: ExternalAxes| {
                let turned =
                    self.machine.is_oriented_by_locked().then(|| self.machine.with_external_axes(&axes).ok()).flatten();
                turned.unwrap_or_else(|| self.machine.with_carrier_axes(&axes))
            };
            let there = external.map_or_else(|| self.machine.clone(), with_external_axes);
            self.placed = self.placement.place(&there);
            self.external = external;
        }
        &self.placed
    }

    /// Returns the pose `X_OP` with the path's point at `position_mm` (W) and the tool at `orientation`, in the coordinates that the drives
    /// control; a tool axis turns the platform least from the orientation `near` (`R_OP`), or from that of home. With parasitic rotation this
    /// is the pose of the machine there; one out of reach keeps the orientation of home.
    pub fn pose(
        &mut self,
        position_mm: Vector3<f64>,
        orientation: Option<&Orientation>,
        external: Option<ExternalAxes>,
        near: Option<&Matrix3<f64>>,
    ) -> Pose {
        let placed = *self.placed(external);
        let placed = near.map_or(placed, |rotation| placed.turned_from(rotation));
        let asked = match orientation {
            Some(orientation) => placed.with_tool_orientation(orientation).platform_pose(position_mm),
            None => placed.platform_pose(position_mm),
        };
        let controlled = Pose { translation: self.machine.controllable_position(asked.translation), ..asked };
        if !self.machine.has_parasitic_rotation {
            return controlled;
        }
        match self.machine.track(self.placed.reference(), &asked, &self.near) {
            Ok(at) => {
                self.near = at;
                let Pose { rotation, translation } = self.near.pose;
                Pose { rotation, translation: self.machine.controllable_position(translation) }
            }
            Err(_) => controlled,
        }
    }
}

/// Returns the task point of each path point: its pose, and the cutting force as a wrench at P. `origin` names the path in errors.
///
/// # Errors
/// A path that lacks what the cutting force needs.
pub fn tasks(process: &Process, path: &CutPath, origin: &str) -> Result<Vec<TaskPoint>> {
    let fault = |source: LoadError| Error::Argument { argument: origin.to_string(), problem: source.to_string() };
    let loads = process.loads(path).map_err(fault)?;
    Ok(tasks_under(&process.machine, &process.placement, process.target, path, &loads))
}

/// Returns the task point of each point of a path at `placement`, under `loads`; uncontrolled coordinates are those of the machine.
pub fn tasks_under(
    machine: &Machine,
    placement: &Placement,
    target: Target,
    path: &CutPath,
    loads: &[PathLoad],
) -> Vec<TaskPoint> {
    let mut unloaded = unloaded_tasks(machine, placement, target, path);
    let task = |(k, load): (usize, &PathLoad)| {
        let point = &path.points()[k];
        let (task, there) = unloaded(point);
        let load = there.wrench(&load.on_tool(point.tangent, there.tool_axes()));
        TaskPoint { load, aside: against_bend(path, k, &there), ..task }
    };
    loads.iter().enumerate().map(task).collect()
}

/// Returns where the tool tip should be beside its point `k` of the path for the wall to be where it is wanted, O axes, mm.
pub(crate) fn against_bend(path: &CutPath, k: usize, there: &PlacedWorkpiece) -> Vector3<f64> {
    let bend = path.engagements().get(k).and_then(|own| own.bend.as_ref());
    bend.map_or_else(Vector3::zeros, |bend| -(there.workpiece().rotation * bend.aimed_mm))
}

/// Returns what draws change of the force at each point of a path at `placement`, whose force has these `components`; nothing where one factor is for all of it.
pub(crate) fn drawn_forces_at(
    uncertainty: &Uncertainty,
    machine: &Machine,
    placement: &Placement,
    path: &CutPath,
    components: Option<&[Vec<PathLoad>; ForceSpread::COMPONENTS.len()]>,
) -> Vec<DrawnForceAt> {
    if components.is_none() && uncertainty.tools.len() < 2 {
        return Vec::new();
    }
    let of = |loads: &Vec<PathLoad>| tasks_under(machine, placement, Target::ToolTip, path, loads);
    let components: Vec<Vec<TaskPoint>> = components.into_iter().flatten().map(of).collect();
    let at = |(k, tool)| drawn_force_at(uncertainty.tool_index(tool), &components, k);
    path.cutting_tools().into_iter().enumerate().map(at).collect()
}

/// Returns what draws change of the force at the point `k` of a path, where the tool with this index cuts and `components` have the loads of the components at each point, if any vary.
pub(crate) fn drawn_force_at(tool: usize, components: &[Vec<TaskPoint>], k: usize) -> DrawnForceAt {
    let load = |own: usize| components.get(own).map_or_else(Wrench::zero, |own| own[k].load);
    DrawnForceAt { tool, components: std::array::from_fn(load) }
}

/// Returns a function from a path point to its task point without load and the place of workpiece and tool, to be called in path order.
pub(crate) fn unloaded_tasks<'a>(
    machine: &'a Machine,
    placement: &'a Placement,
    target: Target,
    path: &'a CutPath,
) -> impl FnMut(&PathPoint) -> (TaskPoint, PlacedWorkpiece) + use<'a> {
    let mut track = PoseTracker::new(machine, placement);
    let external = axes_along(machine, path.external_axes());
    let head = Some(machine).filter(|_| !path.led_axes().is_empty()).and_then(Machine::with_commanded_head);
    let led = head.as_ref().map(|head| axes_along(head, &[path.external_axes(), path.led_axes()].concat()));
    move |point| {
        let (external, led) = (external(point), led.as_ref().and_then(|led| led(point)));
        let as_led = led.zip(head.as_ref()).and_then(|(led, head)| head.with_external_axes(&led).ok());
        let near = as_led.as_ref().map(|head| &head.home.pose.rotation);
        let pose = track.pose(point.position_mm, point.orientation.as_ref(), external, near);
        let there = track.placed(external).with_platform_rotation(&pose.rotation);
        let asked = point.arm.map(|arm| arm.asked());
        (TaskPoint { external, led, asked, ..TaskPoint::new(pose, Wrench::zero(), target) }, there)
    }
}
