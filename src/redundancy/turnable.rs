//! A path whose tool may be rotated about its axis: the task point of each point and γ, and the branches of the machine.

use std::{f64::consts::TAU, sync::Arc};

use nalgebra::{Matrix3, Rotation3, Unit, UnitQuaternion, Vector3};

use crate::{
    compensation::{Target, TaskPoint},
    input::error::{Error, Result},
    machine::{Branch, ChainError, Machine, ToolAxisSource},
    process::{CutPath, PathReference, PlacedWorkpiece, Placement, RedundancySettings, cutting::PathLoad},
    simulation::Machines,
    toolpath::{PathPoint, Toolpath},
};

/// A path on a machine under loads, for which γ is sought.
#[derive(Debug, Clone, Copy)]
pub struct GammaProblem<'a> {
    /// The nominal machine.
    pub machine: &'a Machine,
    /// Chain errors of the actual machine.
    pub errors: &'a [ChainError],
    /// Placement of the workpiece.
    pub placement: &'a Placement,
    /// Which coordinates of the pose are compensated.
    pub target: Target,
    /// The path as programmed.
    pub path: &'a CutPath,
    /// The load at each point of the path.
    pub loads: &'a [PathLoad],
    /// Objective, range, step and limits of γ.
    pub settings: &'a RedundancySettings,
}

/// The machine on one branch, or the machine that has none.
#[derive(Debug, Clone)]
pub struct BranchMachine {
    /// The arm's branch; `None` on a machine without branches.
    pub branch: Option<Branch>,
    /// The nominal machine with its home on this branch.
    pub machine: Machine,
    /// The nominal and the actual machine.
    pub(super) machines: Machines,
}

/// The machine on each branch, whatever path it follows.
#[derive(Debug, Clone, Default)]
pub struct BranchMachines {
    /// Those that have a home, in the order of [`Branch::ALL`].
    pub(super) found: Arc<[BranchMachine]>,
    /// Branches left out, and why.
    pub(super) refused: Vec<(Branch, String)>,
}

/// A path that is checked to be rotatable about its tool axis, and its machines.
#[derive(Debug)]
pub(super) struct RotatablePath<'a> {
    pub problem: GammaProblem<'a>,
    /// The machine on each branch, in the order of [`Branch::ALL`].
    pub on_branches: Arc<[BranchMachine]>,
    /// Branches left out, and why.
    pub refused: Vec<(Branch, String)>,
    /// Whether γ at which P leaves the machine's workspace box are infeasible.
    pub keeps_box: bool,
    /// Full turn of each drive, rad; `None` for a linear drive.
    pub full_turns: Vec<Option<f64>>,
    placed: PlacedWorkpiece,
    /// Tool axis: z of the tool frame in platform axes.
    axis: Unit<Vector3<f64>>,
    /// `R_WP` at each point at γ = 0.
    programmed_rotations: Vec<Matrix3<f64>>,
    cuts_nowhere: bool,
}

/// Most distance of the tip from the tool axis through P, mm.
const ON_AXIS_MM: f64 = 1e-6;

/// Most drives of a machine for which γ is sought.
pub const MAX_DRIVES: usize = 8;

/// `Err` for the argument "redundancy" with `problem` as its message.
fn refuse<T>(problem: String) -> Result<T> {
    Err(Error::Argument { argument: "redundancy".into(), problem })
}

/// Checks that `machine` can rotate its tool freely about its axis along `path`. `Err` says why not, or that the path has no points.
pub(crate) fn check(machine: &Machine, placement: &Placement, path: &Toolpath) -> Result<()> {
    let name = &machine.name;
    if machine.controls.len() != 6 {
        let problem = format!(
            "machine {name} controls {} coordinates of its platform, and rotation about the tool axis is redundant only where the drives \
             control all six coordinates",
            machine.controls.len()
        );
        return refuse(problem);
    }
    if machine.redundancy > 0 || machine.drive_count() > MAX_DRIVES {
        let problem = format!(
            "machine {name} has {} drives and {} of them redundant: expected at most {MAX_DRIVES}, and the redundant ones locked ([locked], --lock)",
            machine.drive_count(),
            machine.redundancy
        );
        return refuse(problem);
    }
    if machine.tool_axis_source == ToolAxisSource::PlatformZ {
        return refuse(format!(
            "machine {name} has a tool tip at P and no tool_axis, so there is no axis to rotate about"
        ));
    }
    if machine.carrier.is_some() || !path.external_axes().is_empty() {
        return refuse(format!(
            "machine {name}: γ is not sought where the workpiece stands on a carrier, or with external axes"
        ));
    }
    let axis = machine.tool_axes.column(2);
    let beside = machine.tool_tip - axis * axis.dot(&machine.tool_tip);
    if placement.reference == PathReference::PlatformPoint && beside.norm() > ON_AXIS_MM {
        let problem = format!(
            "placement.reference is platform_point, and the tool tip of machine {name} is {:.3} mm beside the tool's axis through P, so a \
             rotation would move it: expected tool_tip",
            beside.norm()
        );
        return refuse(problem);
    }
    match path.is_empty() {
        true => refuse("the path has no points".into()),
        false => Ok(()),
    }
}

impl<'a> RotatablePath<'a> {
    /// Checks the problem and prepares the machine on each branch. `Err` says why the machine cannot rotate its tool freely.
    pub fn new(problem: GammaProblem<'a>) -> Result<Self> {
        check(problem.machine, problem.placement, problem.path)?;
        Self::on(problem, &BranchMachines::new(problem.machine, problem.errors)?)
    }

    /// Checks the problem, of which `machines` are the machine on each branch. `Err` as [`RotatablePath::new`].
    pub fn on(problem: GammaProblem<'a>, machines: &BranchMachines) -> Result<Self> {
        let GammaProblem { machine, placement, path, .. } = problem;
        check(machine, placement, path)?;
        let placed = placement.place(machine);
        let workpiece = placed.workpiece().rotation;
        let programmed_rotations = |point: &PathPoint| {
            let there =
                point.orientation.as_ref().map_or(placed, |orientation| placed.with_tool_orientation(orientation));
            workpiece.tr_mul(there.orientation())
        };
        Ok(Self {
            problem,
            on_branches: machines.found.clone(),
            refused: machines.refused.clone(),
            keeps_box: false,
            full_turns: machine.full_turns().collect(),
            axis: Unit::new_normalize(machine.tool_axes.column(2).into_owned()),
            programmed_rotations: path.points().iter().map(programmed_rotations).collect(),
            placed,
            cuts_nowhere: !path.points().iter().any(|point| point.cutting),
        })
    }

    /// Returns the index of the branch of home, or of the machine that has none; `None` where home is on none that the machine may be on.
    pub fn home_branch(&self) -> Option<usize> {
        let home = self.problem.machine.branch_of(&self.problem.machine.home);
        self.on_branches.iter().position(|own| own.branch == home)
    }

    /// Points of the path as programmed.
    pub fn points(&self) -> &[PathPoint] {
        self.problem.path.points()
    }

    /// Whether point `k` counts: the tool cuts there, or nowhere on the path.
    pub fn is_counted(&self, k: usize) -> bool {
        self.points()[k].cutting || self.cuts_nowhere
    }

    /// `R_WP`, the platform orientation in W, at point `k`, rotated by `gamma` rad about the tool axis.
    fn rotation(&self, k: usize, gamma: f64) -> Matrix3<f64> {
        self.programmed_rotations[k] * Rotation3::from_axis_angle(&self.axis, gamma)
    }

    /// Task point (pose and load, O axes) of point `k`, rotated by `gamma` rad.
    pub fn task(&self, k: usize, gamma: f64) -> TaskPoint {
        let (point, load) = (&self.points()[k], &self.problem.loads[k]);
        let rotated = self.placed.with_platform_rotation(&(self.placed.workpiece().rotation * self.rotation(k, gamma)));
        let load = rotated.wrench(&load.on_tool(point.tangent, rotated.tool_axes()));
        TaskPoint::new(rotated.platform_pose(point.position_mm), load, self.problem.target)
    }

    /// Whether P leaves the machine's workspace box at `task`.
    pub fn is_outside(&self, task: &TaskPoint) -> bool {
        self.problem.machine.outside_workspace(task.pose.translation).is_some()
    }

    /// Number of points at which P leaves the workspace box, with γ (rad) at each.
    pub fn outside_count(&self, gamma: impl Fn(usize) -> f64) -> usize {
        (0..self.points().len()).filter(|k| self.is_outside(&self.task(*k, gamma(*k)))).count()
    }

    /// The part of `error`, the position error of the tool at point `k` (O axes, mm), that the cost setting measures, mm.
    pub fn cost(&self, k: usize, error: &Vector3<f64>) -> f64 {
        let workpiece = &self.placed.workpiece().rotation;
        let axis = workpiece * (self.programmed_rotations[k] * *self.axis);
        self.problem.settings.cost.deviation(error, workpiece * self.points()[k].tangent, axis)
    }

    /// The path with its platform orientations rotated by `gammas`, rad, one for each point.
    pub fn rotated(&self, gammas: &[f64]) -> CutPath {
        let mut platforms: Vec<UnitQuaternion<f64>> = Vec::with_capacity(gammas.len());
        for (k, gamma) in gammas.iter().enumerate() {
            let rotation = Rotation3::from_matrix_unchecked(self.rotation(k, *gamma));
            let q = UnitQuaternion::from_rotation_matrix(&rotation);
            // Of the two quaternions of an orientation, the one that goes on from the point before.
            let is_opposite = platforms.last().is_some_and(|before| before.coords.dot(&q.coords) < 0.0);
            platforms.push(if is_opposite { UnitQuaternion::new_unchecked(-q.into_inner()) } else { q });
        }
        self.problem.path.clone().with_platforms(&platforms)
    }

    /// Whether the range of γ is a full turn, so that the last value neighbours the first.
    pub fn is_cyclic(&self) -> bool {
        let [low, high] = self.problem.settings.range_deg;
        (high - low).to_radians() > TAU * (1.0 - 1e-9)
    }

    /// Values of γ on the lattice, rad.
    pub fn gammas(&self) -> Vec<f64> {
        let [low, high] = self.problem.settings.range_deg;
        if low == high {
            return vec![low.to_radians()];
        }
        let steps = ((high - low) / self.problem.settings.step_deg - 1e-9).ceil().max(1.0) as usize;
        let step = (high - low) / steps as f64;
        let count = if self.is_cyclic() { steps } else { steps + 1 };
        (0..count).map(|k| (low + step * k as f64).to_radians()).collect()
    }
}

impl BranchMachines {
    /// Puts `machine` on each branch. `Err` if `errors` do not fit it.
    pub fn new(machine: &Machine, errors: &[ChainError]) -> Result<Self> {
        let on_branch = |branch, machine: Machine| -> Result<BranchMachine> {
            Ok(BranchMachine { branch, machines: Machines::new(&machine, errors)?, machine })
        };
        let branches = machine.branch.map_or_else(|| Branch::ALL.to_vec(), |branch| vec![branch]);
        if machine.branch_of(&machine.home).is_none() {
            return Ok(Self { found: [on_branch(None, machine.clone())?].into(), refused: Vec::new() });
        }
        let (mut found, mut refused) = (Vec::new(), Vec::new());
        for branch in branches {
            let machine_there = match machine.branch {
                Some(_) => Ok(machine.clone()),
                None => machine.on_branch(branch),
            };
            match machine_there.and_then(|machine| on_branch(Some(branch), machine)) {
                Ok(own) => found.push(own),
                Err(Error::Argument { problem, .. }) => refused.push((branch, problem)),
                Err(other) => return Err(other),
            }
        }
        Ok(Self { found: found.into(), refused })
    }
}
