//! A path whose tool may be turned about its axis on a machine: what is wanted at each point for each turn, and the branches on which an
//! arm may stand.

use std::f64::consts::TAU;

use nalgebra::{Matrix3, Rotation3, Unit, UnitQuaternion, Vector3};

use crate::{
    compensation::{Target, TaskPoint},
    input::error::{Error, Result},
    machine::{Branch, ChainError, Machine, ToolAxisSource},
    process::{PathReference, Placed, Placement, RedundancySettings, cutting::PathLoad},
    simulation::{Machines, tasks::placed},
    toolpath::{PathPoint, Toolpath},
};

/// What is asked: a path at a place on a machine, under loads.
#[derive(Debug, Clone, Copy)]
pub struct TurnAsked<'a> {
    /// The nominal machine.
    pub machine: &'a Machine,
    /// Errors of each chain of the real one.
    pub errors: &'a [ChainError],
    /// Where the workpiece stands.
    pub placement: &'a Placement,
    /// What of a pose counts.
    pub target: Target,
    /// The path.
    pub path: &'a Toolpath,
    /// The load at each of its points.
    pub loads: &'a [PathLoad],
    /// How the turn is chosen.
    pub turn: &'a RedundancySettings,
}

/// A branch: the machine on a branch, or the machine that has none.
#[derive(Debug, Clone)]
pub struct OnBranch {
    /// Its branch, of an arm.
    pub branch: Option<Branch>,
    /// The machine on it.
    pub machine: Machine,
    /// What commands and answers.
    pub(super) machines: Machines,
}

/// Branches that a machine refuses, and why.
pub(super) type Refused = Vec<(Branch, String)>;

/// A checked path with its turns.
#[derive(Debug)]
pub(super) struct Turnable<'a> {
    pub asked: TurnAsked<'a>,
    /// The branches, in the order of [`Branch::ALL`].
    pub on_branches: Vec<OnBranch>,
    /// Branches that the machine refuses, and why.
    pub refused: Refused,
    /// Of each drive, what a full turn of it is, rad; `None` of a slide.
    pub full_turns: Vec<Option<f64>>,
    placed: Placed,
    /// z of the tool frame in platform axes.
    axis: Unit<Vector3<f64>>,
    /// `R_WP` at each point as the path gives it.
    unturned: Vec<Matrix3<f64>>,
    cuts_nowhere: bool,
}

/// The tip is on the tool's axis through P within this, mm.
const ON_AXIS_MM: f64 = 1e-6;

/// Most drives of a machine that is turned.
pub const MOST_DRIVES: usize = 8;

fn refuse<T>(problem: String) -> Result<T> {
    Err(Error::Argument { argument: "redundancy".into(), problem })
}

/// Refuses a `machine` whose turn about the tool's axis is not free, with the reason.
///
/// # Errors
/// It is not, or the path has no points.
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
    if machine.redundancy > 0 || machine.drive_count() > MOST_DRIVES {
        let problem = format!(
            "machine {name} has {} drives and {} of them redundant: expected at most {MOST_DRIVES}, and the redundant ones locked ([locked], --lock)",
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

impl<'a> Turnable<'a> {
    /// Checks what is asked.
    ///
    /// # Errors
    /// A machine that cannot turn its tool freely; the message says why.
    pub fn new(asked: TurnAsked<'a>) -> Result<Self> {
        let TurnAsked { machine, errors, placement, path, .. } = asked;
        check(machine, placement, path)?;
        let placed = placed(machine, placement);
        let workpiece = placed.workpiece().rotation;
        let unturned = |point: &PathPoint| {
            let there = point.orientation.as_ref().map_or(placed, |orientation| placed.oriented(orientation));
            workpiece.tr_mul(there.orientation())
        };
        let (on_branches, refused) = on_branches(machine, errors)?;
        Ok(Self {
            asked,
            on_branches,
            refused,
            full_turns: machine.full_turns().collect(),
            axis: Unit::new_normalize(machine.tool_axes.column(2).into_owned()),
            unturned: path.points().iter().map(unturned).collect(),
            placed,
            cuts_nowhere: !path.points().iter().any(|point| point.cutting),
        })
    }

    pub fn points(&self) -> &[PathPoint] {
        self.asked.path.points()
    }

    /// Whether what is left at point `k` counts: the tool cuts there, if it does anywhere.
    pub fn counts(&self, k: usize) -> bool {
        self.points()[k].cutting || self.cuts_nowhere
    }

    /// `R_WP` at point `k`, turned by `turn` rad.
    fn platform(&self, k: usize, turn: f64) -> Matrix3<f64> {
        self.unturned[k] * Rotation3::from_axis_angle(&self.axis, turn)
    }

    /// What is wanted at point `k`, turned by `turn` rad.
    pub fn task(&self, k: usize, turn: f64) -> TaskPoint {
        let (point, load) = (&self.points()[k], &self.asked.loads[k]);
        let there = self.placed.turned(&(self.placed.workpiece().rotation * self.platform(k, turn)));
        TaskPoint {
            pose: there.platform_pose(point.position_mm),
            load: there.wrench(&load.on_tool(point.tangent, there.tool_axes())),
            target: self.asked.target,
            wanted: None,
            external: None,
        }
    }

    /// What counts of `error`, the distance from where the tool should be at point `k`, O axes, mm.
    pub fn cost(&self, k: usize, error: &Vector3<f64>) -> f64 {
        let there = &self.placed.workpiece().rotation;
        let axis = there * (self.unturned[k] * *self.axis);
        self.asked.turn.cost.of(error, there * self.points()[k].tangent, axis)
    }

    /// The path with its platform turned by `turns`, rad, one for each point.
    pub fn turned(&self, turns: &[f64]) -> Toolpath {
        let mut platforms: Vec<UnitQuaternion<f64>> = Vec::with_capacity(turns.len());
        for (k, turn) in turns.iter().enumerate() {
            let rotation = Rotation3::from_matrix_unchecked(self.platform(k, *turn));
            let own = UnitQuaternion::from_rotation_matrix(&rotation);
            // Of the two quaternions of an orientation, the one that goes on from the point before.
            let is_opposite = platforms.last().is_some_and(|before| before.coords.dot(&own.coords) < 0.0);
            platforms.push(if is_opposite { UnitQuaternion::new_unchecked(-own.into_inner()) } else { own });
        }
        self.asked.path.clone().with_platforms(&platforms)
    }

    /// Whether the turns of the lattice go round: after the last comes the first.
    pub fn wraps(&self) -> bool {
        let [low, high] = self.asked.turn.range_deg;
        (high - low).to_radians() > TAU * (1.0 - 1e-9)
    }

    /// The turns of the lattice, rad.
    pub fn turns(&self) -> Vec<f64> {
        let [low, high] = self.asked.turn.range_deg;
        let steps = ((high - low) / self.asked.turn.step_deg - 1e-9).ceil().max(1.0) as usize;
        let step = (high - low) / steps as f64;
        let count = if self.wraps() { steps } else { steps + 1 };
        (0..count).map(|k| (low + step * k as f64).to_radians()).collect()
    }
}

/// The branches on which `machine` may stand, and those that it refuses.
fn on_branches(machine: &Machine, errors: &[ChainError]) -> Result<(Vec<OnBranch>, Refused)> {
    let on_branch = |branch, machine: Machine| -> Result<OnBranch> {
        Ok(OnBranch { branch, machines: Machines::new(&machine, errors)?, machine })
    };
    let own = machine.branch.map_or_else(|| Branch::ALL.to_vec(), |branch| vec![branch]);
    if machine.branch_of(&machine.home).is_none() {
        return Ok((vec![on_branch(None, machine.clone())?], Vec::new()));
    }
    let (mut on_branches, mut refused) = (Vec::new(), Vec::new());
    for branch in own {
        let there = match machine.branch {
            Some(_) => Ok(machine.clone()),
            None => machine.on_branch(branch),
        };
        match there.and_then(|machine| on_branch(Some(branch), machine)) {
            Ok(found) => on_branches.push(found),
            Err(Error::Argument { problem, .. }) => refused.push((branch, problem)),
            Err(other) => return Err(other),
        }
    }
    Ok((on_branches, refused))
}
