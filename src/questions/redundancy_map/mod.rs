//! A map of turns: with the tool in given directions at places of its tip, how far the cutting force moves it at the best and at the
//! worst turn about its axis, on which branch, and where no turn is possible.

#[cfg(feature = "report")]
pub mod report;
mod resolve;
pub(crate) mod spec;

use std::{collections::BTreeMap, f64::consts::FRAC_PI_2};

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use crate::{
    input::error::Result,
    machine::Branch,
    process::{
        Placement, ToolTurn,
        cutting::{PathFrame, PathLoad},
    },
    redundancy::{Infeasible, Node, TurnAsked, at_points},
    simulation::{Failure, Scene, status_of},
    spatial::{Grid, frame_about},
    toolpath::{Orientation, PathPoint, PointSource, Toolpath, cutting_point},
    work::{Event, Work, here},
};

/// A checked map of turns.
#[derive(Debug, Clone)]
pub struct RedundancyMapStudy {
    /// Of what machine, under what.
    pub scene: Scene,
    /// Places of the tool tip, O.
    pub grid: Grid,
    /// Directions of the tool from its tip to the spindle, unit vectors in O.
    pub axes: Vec<Vector3<f64>>,
    /// The turns.
    pub turn: ToolTurn,
}

impl RedundancyMapStudy {
    /// Turns of a place.
    pub fn turns(&self) -> usize {
        (360.0 / self.turn.step_deg - 1e-9).ceil() as usize
    }
}

/// A turn at a place.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct AtTurn {
    /// γ from the least turn of the platform from home, degrees.
    pub gamma_deg: f64,
    /// The branch, of an arm.
    pub branch: Option<Branch>,
    /// Largest displacement of the tool tip over the directions of the force, mm.
    pub deflection_mm: f64,
    /// The direction of the force at which it occurs, degrees.
    pub phi_deg: f64,
}

/// The turns at a place.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Turns {
    /// The one at which the tool moves least.
    pub best: AtTurn,
    /// The one at which it moves most.
    pub worst: AtTurn,
    /// Turns that are possible on some branch.
    pub possible: usize,
}

/// A place of the tool tip with a direction of the tool.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RedundancyMapPoint {
    /// Place of the tool tip, O, mm.
    pub position_mm: [f64; 3],
    /// Index of the direction.
    pub axis: usize,
    /// The turns there.
    pub turns: std::result::Result<Turns, Failure>,
}

impl RedundancyMapPoint {
    /// Word for tables.
    pub fn status(&self) -> &str {
        status_of(&self.turns)
    }

    /// Whether some turn is possible.
    pub fn is_solved(&self) -> bool {
        self.turns.is_ok()
    }
}

/// Results of a redundancy map: of each direction the places in grid order.
#[derive(Debug, Clone, Serialize)]
pub struct RedundancyMap {
    /// The points.
    pub points: Vec<RedundancyMapPoint>,
}

/// Places computed together.
const BLOCK: usize = 64;

/// Computes all places for all directions, in parallel on the current rayon pool; the result does not depend on the number of threads.
///
/// # Errors
/// A machine that cannot turn its tool freely, and those of `work`.
pub fn run(study: &RedundancyMapStudy, work: &Work) -> Result<RedundancyMap> {
    let mut points = Vec::with_capacity(study.grid.len() * study.axes.len());
    for axis in 0..study.axes.len() {
        let work = work.after(axis * blocks_of_axis(study));
        for (number, start) in (0..study.grid.len()).step_by(BLOCK).enumerate() {
            let (work, places) = (work.dealt(number), start..study.grid.len().min(start + BLOCK));
            let found = here(work.piece(&(axis, start), Vec::len, || block(study, axis, places, &work)))?;
            points.extend(found.into_iter().flatten());
        }
    }
    work.gathered()?;
    Ok(RedundancyMap { points })
}

fn blocks_of_axis(study: &RedundancyMapStudy) -> usize {
    study.grid.len().div_ceil(BLOCK)
}

/// Blocks of all directions.
pub(super) fn blocks(study: &RedundancyMapStudy) -> usize {
    study.axes.len() * blocks_of_axis(study)
}

fn block(
    study: &RedundancyMapStudy,
    axis: usize,
    places: std::ops::Range<usize>,
    work: &Work,
) -> Result<Vec<RedundancyMapPoint>> {
    let positions: Vec<Vector3<f64>> = places.map(|index| study.grid.position(index)).collect();
    let path = path(study, axis, &positions);
    let frame = PathFrame { force: study.scene.force };
    let loads = vec![PathLoad::PathFrame(frame); path.len()];
    let asked = TurnAsked {
        machine: &study.scene.machine,
        errors: &study.scene.errors,
        placement: &Placement::default(),
        target: study.scene.target,
        path: &path,
        loads: &loads,
        turn: &study.turn,
    };
    let found = at_points(asked, || work.check())?;
    let of_places = found.nodes.chunks(study.scene.phis.len()).zip(&positions);
    let points: Vec<RedundancyMapPoint> = of_places
        .map(|(nodes, position)| RedundancyMapPoint {
            position_mm: (*position).into(),
            axis,
            turns: turns(study, &found.turns, &found.branches, nodes),
        })
        .collect();
    work.tell(Event::Computed(points.len()));
    let unsolved = points.iter().filter(|point| !point.is_solved()).count();
    if unsolved > 0 {
        work.tell(Event::Unsolved(unsolved));
    }
    Ok(points)
}

/// Each of `positions` with the force in each direction.
fn path(study: &RedundancyMapStudy, axis: usize, positions: &[Vector3<f64>]) -> Toolpath {
    let axis = study.axes[axis];
    let tool_axes = frame_about(-axis);
    let point = |(segment, (position, phi)): (usize, (&Vector3<f64>, f64))| {
        let heading = phi + FRAC_PI_2;
        let tangent = tool_axes * Vector3::new(heading.cos(), heading.sin(), 0.0);
        PathPoint {
            orientation: Some(Orientation::ToolAxis(axis)),
            source: PointSource { segment, parameter: 1.0 },
            ..cutting_point(*position, tangent, 0.0, 1.0)
        }
    };
    let all = positions.iter().flat_map(|position| study.scene.phis.iter().map(move |phi| (position, *phi)));
    Toolpath::assemble(all.enumerate().map(point).collect())
}

/// What the nodes of a place, one list for each direction of the force, come to.
fn turns(
    study: &RedundancyMapStudy,
    turns: &[f64],
    branches: &[Option<Branch>],
    nodes: &[Vec<Node>],
) -> std::result::Result<Turns, Failure> {
    let (mut best, mut worst): (Option<AtTurn>, Option<AtTurn>) = (None, None);
    let (mut possible, mut infeasible_turns) = (0, BTreeMap::<Infeasible, usize>::new());
    for (k, turn) in turns.iter().enumerate() {
        let mut is_possible = false;
        for (s, branch) in branches.iter().enumerate() {
            match over_phis(study, nodes, k * branches.len() + s) {
                Ok((deflection_mm, phi)) => {
                    is_possible = true;
                    let (gamma_deg, phi_deg) = (turn.to_degrees(), phi.to_degrees());
                    let here = AtTurn { gamma_deg, branch: *branch, deflection_mm, phi_deg };
                    if best.is_none_or(|best| deflection_mm < best.deflection_mm) {
                        best = Some(here);
                    }
                    if worst.is_none_or(|worst| deflection_mm > worst.deflection_mm) {
                        worst = Some(here);
                    }
                }
                Err(infeasible) => *infeasible_turns.entry(infeasible).or_default() += 1,
            }
        }
        possible += usize::from(is_possible);
    }
    best.zip(worst)
        .map(|(best, worst)| Turns { best, worst, possible })
        .ok_or_else(|| none_of(turns.len(), &infeasible_turns))
}

/// The largest deflection of a node over the directions of the force, and its direction, rad.
fn over_phis(
    study: &RedundancyMapStudy,
    nodes: &[Vec<Node>],
    node: usize,
) -> std::result::Result<(f64, f64), Infeasible> {
    let mut largest = (-1.0, 0.0);
    for (nodes, phi) in nodes.iter().zip(&study.scene.phis) {
        let cost_mm = nodes[node]?.cost_mm;
        if cost_mm > largest.0 {
            largest = (cost_mm, *phi);
        }
    }
    Ok(largest)
}

/// Why none of `turns` turns is possible: what hinders most.
fn none_of(turns: usize, infeasible_turns: &BTreeMap<Infeasible, usize>) -> Failure {
    // Branches that do not lead there say least.
    let told = infeasible_turns.iter().filter(|(infeasible, _)| **infeasible != Infeasible::Unreachable);
    let most = told.max_by_key(|(_, count)| **count).map_or(Infeasible::Unreachable, |(infeasible, _)| *infeasible);
    let counts: Vec<String> =
        infeasible_turns.iter().map(|(infeasible, count)| format!("{count} {}", infeasible.words())).collect();
    let reason = format!("none of {turns} values of γ is possible on any branch: {}", counts.join(", "));
    Failure { status: most.label().into(), reason }
}
