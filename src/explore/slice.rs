//! Solves a plane of the workspace under a load: displacement of the tool and correction at each node.

use serde::{Deserialize, Serialize};

use super::{
    Explorer,
    tool::{LoadRequest, shown_values},
};
use crate::{
    compensation::{Method, Session, Target, TaskPoint, compensate},
    input::{
        check::LARGEST,
        error::{Error, Result},
    },
    inspect::point::PointLoad,
    machine::Configuration,
    simulation::{Failure, Source},
    spatial::Grid,
};

/// Most nodes of a plane.
const MAX_NODES: usize = 40_000;

/// Nodes of a plane through the workspace box of P, to be solved.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SliceRequest {
    /// The axis of O that is normal to the plane: 0, 1 or 2.
    pub axis: usize,
    /// Coordinate of the plane on that axis, mm.
    pub level: f64,
    /// Numbers of nodes along the two other axes, in their order.
    pub counts: [usize; 2],
    /// Range of nodes to solve, first and one past the last; the first of the two axes runs fastest.
    pub nodes: [usize; 2],
    /// The load; a milling force without φ is taken over a whole turn, where the worst counts.
    pub load: LoadRequest,
}

/// Results at the nodes of a plane, `None` where there is no solution.
#[derive(Debug, Clone, Serialize)]
pub struct SliceResult {
    /// Range of nodes solved, first and one past the last.
    pub nodes: [usize; 2],
    /// Largest displacement of the tool tip, mm.
    pub displacement: Vec<Option<f64>>,
    /// Largest correction of a drive, mm, or degrees where all drives are revolute joints; of machines with both, of prismatic joints.
    pub correction: Vec<Option<f64>>,
    /// Largest force of a drive at the nominal command, N, or N·mm where all drives are revolute joints; of machines with both, of prismatic joints.
    pub force: Vec<Option<f64>>,
    /// Distance to singularity.
    pub conditioning: Vec<Option<f64>>,
    /// Failure of each node without solution.
    pub failures: Vec<(usize, Failure)>,
}

impl Explorer {
    /// Solves nodes of a plane. Each is solved on its own, so that its values do not depend on which others are requested.
    ///
    /// # Errors
    /// The plane, its nodes or the load are invalid.
    pub fn slice(&self, request: &SliceRequest) -> Result<SliceResult> {
        let grid = self.grid(request)?;
        let loads = request.load.loads()?;
        let mut answer = SliceResult {
            nodes: [request.nodes[0].min(grid.len()), request.nodes[1].min(grid.len())],
            displacement: Vec::new(),
            correction: Vec::new(),
            force: Vec::new(),
            conditioning: Vec::new(),
            failures: Vec::new(),
        };
        let session = self.machines.session(Source::All);
        for index in answer.nodes[0]..answer.nodes[1] {
            let at = self.machine.inverse_kinematics_at(grid.position(index)).map_err(Failure::from);
            let node = at.as_ref().map_err(Clone::clone).and_then(|at| self.node(session.clone(), at, &loads));
            answer.conditioning.push(at.as_ref().ok().map(|at| self.machine.conditioning(at)));
            answer.displacement.push(node.as_ref().ok().map(|node| node.displacement));
            answer.correction.push(node.as_ref().ok().and_then(|node| node.correction));
            answer.force.push(node.as_ref().ok().map(|node| node.force));
            answer.failures.extend(node.err().map(|failure| (index, failure)));
        }
        Ok(answer)
    }

    /// Returns the grid of the plane's nodes (P in O, mm), with one node along its normal; an error if plane or counts are invalid.
    fn grid(&self, plane: &SliceRequest) -> Result<Grid> {
        let refuse = |problem: String| Err(Error::argument("slice", problem));
        if plane.axis > 2 || plane.level.is_nan() || plane.level.abs() > LARGEST {
            return refuse(format!("expected an axis of 0 to 2 and a level, got {} and {}", plane.axis, plane.level));
        }
        let nodes = plane.counts[0].checked_mul(plane.counts[1]);
        if nodes.is_none_or(|nodes| nodes == 0 || nodes > MAX_NODES) {
            return refuse(format!("expected 1 to {MAX_NODES} nodes, got {:?}", plane.counts));
        }
        let (mut min, mut max) = (self.machine.workspace.min, self.machine.workspace.max);
        (min[plane.axis], max[plane.axis]) = (plane.level, plane.level);
        let mut others = plane.counts.into_iter();
        let counts = std::array::from_fn(|i| if i == plane.axis { 1 } else { others.next().unwrap_or(1) });
        Ok(Grid::new(min, max, counts))
    }

    /// Returns the largest values over `loads` at a configuration, solved from its rigid state; or why a load has no equilibrium.
    fn node(
        &self,
        mut session: Session,
        at: &Configuration,
        loads: &[PointLoad],
    ) -> std::result::Result<Node, Failure> {
        let machine = &self.machine;
        let mut node = Node { displacement: 0.0, correction: Some(0.0), force: 0.0 };
        session.set_rigid(at);
        let mut corrected = session.clone();
        for (index, load) in loads.iter().enumerate() {
            let load = load.wrench(&machine.tool_at(&at.pose.rotation));
            let task = TaskPoint::new(at.pose, load, Target::ToolTip);
            let plain = compensate(&mut session, &task, Method::None);
            if !plain.status.is_success() {
                let reason = plain.status.reason(machine);
                return Err(Failure { status: plain.status.label().into(), reason });
            }
            node.displacement = node.displacement.max(plain.tool_displacement.norm());
            node.force = node.force.max(self.largest_of_kind(&plain.drive_forces));
            if index == 0 {
                corrected.set_state(at, session.state());
            }
            let exact = compensate(&mut corrected, &task, Method::Direct);
            let delta: Vec<f64> = exact.drives.iter().zip(&at.drives).map(|(rho, nominal)| rho - nominal).collect();
            let correction = exact.status.is_success().then(|| self.largest_of_kind(&shown_values(machine, &delta)));
            node.correction = node.correction.zip(correction).map(|(most, own)| most.max(own));
        }
        Ok(node)
    }

    /// Returns the largest absolute value over the drives of the machine's first kind: slides, if it has any.
    fn largest_of_kind(&self, values: &[f64]) -> f64 {
        let kind = self.machine.drive_kinds().next();
        let of_kind = values.iter().zip(self.machine.drives()).filter(|(_, (_, drive))| Some(drive.motion) == kind);
        of_kind.map(|(value, _)| value.abs()).fold(0.0, f64::max)
    }
}

/// Largest values at a node.
struct Node {
    displacement: f64,
    correction: Option<f64>,
    force: f64,
}
