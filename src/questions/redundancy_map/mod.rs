//! Redundancy map: on a grid, the deflection at the best and the worst rotation γ about the tool axis, and where no γ is possible.

#[cfg(feature = "report")]
pub mod report;
mod resolve;
pub(crate) mod spec;

use std::{collections::BTreeMap, f64::consts::FRAC_PI_2, ops::Range};

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use crate::{
    input::error::Result,
    machine::Branch,
    process::{
        CutPath, Placement, RedundancySettings,
        cutting::{PathFrame, PathLoad},
    },
    redundancy::{GammaProblem, Infeasible, Node, nodes_at_points},
    simulation::{Failure, LoadCase},
    spatial::{Grid, frame_about},
    toolpath::{Orientation, PathPoint, PointSource, Toolpath, cutting_point},
    work::{Event, Work, if_this_shard},
};

/// A checked redundancy map.
#[derive(Debug, Clone)]
pub struct RedundancyMapStudy {
    /// Machine, cutting force, its directions, and chain errors.
    pub load_case: LoadCase,
    /// Positions of the tool tip, O, mm.
    pub grid: Grid,
    /// Tool directions from the tip to the spindle, unit vectors in O.
    pub axes: Vec<Vector3<f64>>,
    /// Settings of the search over γ.
    pub settings: RedundancySettings,
}

impl RedundancyMapStudy {
    /// Returns the number of values of γ.
    pub fn gamma_count(&self) -> usize {
        (360.0 / self.settings.step_deg - 1e-9).ceil() as usize
    }
}

/// Deflection at one value of γ.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct AtGamma {
    /// γ from the smallest rotation of the platform from home, degrees.
    pub gamma_deg: f64,
    /// The branch of inverse kinematics, of an arm.
    pub branch: Option<Branch>,
    /// Largest displacement of the tool tip over the directions of the force, mm.
    pub deflection_mm: f64,
    /// The direction of the force at which it occurs, degrees.
    pub phi_deg: f64,
}

/// Best and worst γ at a point.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct GammaExtremes {
    /// The γ at which the tool moves least.
    pub best: AtGamma,
    /// The γ at which the tool moves most.
    pub worst: AtGamma,
    /// Number of values of γ that are possible on some branch.
    pub possible: usize,
}

/// Results at one position of the tool tip with one direction of the tool.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RedundancyMapPoint {
    /// Position of the tool tip, O, mm.
    pub position_mm: [f64; 3],
    /// Index of the tool direction.
    pub axis: usize,
    /// Best and worst γ, or why none is possible.
    pub gammas: std::result::Result<GammaExtremes, Failure>,
}

/// Results of a redundancy map.
#[derive(Debug, Clone, Serialize)]
pub struct RedundancyMap {
    /// The points, direction by direction, each in grid order.
    pub points: Vec<RedundancyMapPoint>,
}

/// Number of grid points computed together.
const BLOCK: usize = 64;

/// Computes all grid points for all directions in parallel on the current rayon pool; the results do not depend on the number of threads.
/// `Err` if the machine cannot rotate its tool freely, or `work` was stopped or could not be kept.
pub fn run(study: &RedundancyMapStudy, work: &Work) -> Result<RedundancyMap> {
    let mut points = Vec::with_capacity(study.grid.len() * study.axes.len());
    for (number, (axis, indices)) in blocks(study).enumerate() {
        let work = work.shard(number);
        let block =
            if_this_shard(work.piece(&(axis, indices.start), Vec::len, || run_block(study, axis, indices, &work)))?;
        points.extend(block.into_iter().flatten());
    }
    work.barrier()?;
    Ok(RedundancyMap { points })
}

/// Returns each block of the map: index of the tool direction, and range of grid indices.
pub(super) fn blocks(study: &RedundancyMapStudy) -> impl Iterator<Item = (usize, Range<usize>)> {
    let (axes, points) = (study.axes.len(), study.grid.len());
    let of_axis = move |axis| (0..points).step_by(BLOCK).map(move |start| (axis, start..points.min(start + BLOCK)));
    (0..axes).flat_map(of_axis)
}

/// Computes the grid points with these `indices` for the tool direction `axis` (index). `Err` if `work` was stopped.
fn run_block(
    study: &RedundancyMapStudy,
    axis: usize,
    indices: Range<usize>,
    work: &Work,
) -> Result<Vec<RedundancyMapPoint>> {
    let positions: Vec<Vector3<f64>> = indices.map(|index| study.grid.position(index)).collect();
    let path = block_path(study, axis, &positions);
    let frame = PathFrame { force: study.load_case.force };
    let loads = vec![PathLoad::PathFrame(frame); path.len()];
    let problem = GammaProblem {
        machine: &study.load_case.machine,
        errors: &study.load_case.errors,
        placement: &Placement::default(),
        target: study.load_case.target,
        path: &path,
        loads: &loads,
        settings: &study.settings,
    };
    let lattice = nodes_at_points(problem, || work.check())?;
    let by_position = lattice.nodes.chunks(study.load_case.phis.len()).zip(&positions);
    let points: Vec<RedundancyMapPoint> = by_position
        .map(|(nodes, position)| RedundancyMapPoint {
            position_mm: (*position).into(),
            axis,
            gammas: gamma_extremes(study, &lattice.gammas, &lattice.branches, nodes),
        })
        .collect();
    work.tell(Event::Computed(points.len()));
    let unsolved = points.iter().filter(|point| point.gammas.is_err()).count();
    if unsolved > 0 {
        work.tell(Event::Unsolved(unsolved));
    }
    Ok(points)
}

/// Returns a toolpath that visits each of `positions` (tool tip, O, mm) once for each direction of the cutting force.
fn block_path(study: &RedundancyMapStudy, axis: usize, positions: &[Vector3<f64>]) -> CutPath {
    let axis = study.axes[axis];
    let tool_axes = frame_about(-axis);
    let point = |(segment, (position, phi)): (usize, (&Vector3<f64>, f64))| {
        let heading = phi + FRAC_PI_2;
        let tangent = tool_axes * Vector3::new(libm::cos(heading), libm::sin(heading), 0.0);
        PathPoint {
            orientation: Some(Orientation::ToolAxis(axis)),
            source: PointSource { segment, parameter: 1.0 },
            arm: None,
            ..cutting_point(*position, tangent, 0.0, 1.0)
        }
    };
    let pairs = positions.iter().flat_map(|position| study.load_case.phis.iter().map(move |phi| (position, *phi)));
    Toolpath::assemble(pairs.enumerate().map(point).collect()).into()
}

/// Returns the best and the worst γ at a point from its `nodes`, a list per direction of the force. `Err` if no γ is possible.
fn gamma_extremes(
    study: &RedundancyMapStudy,
    gammas: &[f64],
    branches: &[Option<Branch>],
    nodes: &[Vec<Node>],
) -> std::result::Result<GammaExtremes, Failure> {
    let (mut best, mut worst): (Option<AtGamma>, Option<AtGamma>) = (None, None);
    let (mut possible, mut infeasible_gammas) = (0, BTreeMap::<Infeasible, usize>::new());
    for (k, gamma) in gammas.iter().enumerate() {
        let mut is_possible = false;
        for (s, branch) in branches.iter().enumerate() {
            match largest_over_phi(study, nodes, k * branches.len() + s) {
                Ok((deflection_mm, phi)) => {
                    is_possible = true;
                    let (gamma_deg, phi_deg) = (gamma.to_degrees(), phi.to_degrees());
                    let candidate = AtGamma { gamma_deg, branch: *branch, deflection_mm, phi_deg };
                    best = best.filter(|best| best.deflection_mm <= deflection_mm).or(Some(candidate));
                    worst = worst.filter(|worst| worst.deflection_mm >= deflection_mm).or(Some(candidate));
                }
                Err(infeasible) => *infeasible_gammas.entry(infeasible).or_default() += 1,
            }
        }
        possible += usize::from(is_possible);
    }
    best.zip(worst)
        .map(|(best, worst)| GammaExtremes { best, worst, possible })
        .ok_or_else(|| no_gamma_failure(gammas.len(), &infeasible_gammas))
}

/// Returns the largest deflection of a node (index) over directions of the force, mm, and that direction, rad. `Err` if one is infeasible.
fn largest_over_phi(
    study: &RedundancyMapStudy,
    nodes: &[Vec<Node>],
    node: usize,
) -> std::result::Result<(f64, f64), Infeasible> {
    nodes.iter().zip(&study.load_case.phis).try_fold((-1.0, 0.0), |largest, (nodes, phi)| {
        let cost_mm = nodes[node]?.cost_mm;
        Ok(if cost_mm > largest.0 { (cost_mm, *phi) } else { largest })
    })
}

/// Returns the failure that none of `gammas` values of γ is possible, with the most frequent reason.
fn no_gamma_failure(gammas: usize, infeasible_gammas: &BTreeMap<Infeasible, usize>) -> Failure {
    // Branches that do not lead there say least.
    let others = infeasible_gammas.iter().filter(|(infeasible, _)| **infeasible != Infeasible::Unreachable);
    let usual = others.max_by_key(|(_, count)| **count).map_or(Infeasible::Unreachable, |(infeasible, _)| *infeasible);
    let counts: Vec<String> =
        infeasible_gammas.iter().map(|(infeasible, count)| format!("{count} {}", infeasible.text())).collect();
    let reason = format!("none of {gammas} values of γ is possible on any branch: {}", counts.join(", "));
    Failure { status: usual.label().into(), reason }
}
