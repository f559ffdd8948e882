//! Nodes of all γ at independent points: what redundancy maps are made of.

use rayon::prelude::*;

use super::{
    nodes::{Node, Solver},
    turnable::{GammaProblem, RotatablePath},
};
use crate::{input::error::Result, machine::Branch};

/// Nodes of the lattice at independent points.
#[derive(Debug, Clone)]
pub(crate) struct NodesAtPoints {
    /// Values of γ, rad.
    pub gammas: Vec<f64>,
    /// The branches; a single `None` on a machine without.
    pub branches: Vec<Option<Branch>>,
    /// For each point its nodes γ by γ, the branches of each.
    pub nodes: Vec<Vec<Node>>,
}

/// Solves each γ on each branch at each point of the path of `problem`, on the current rayon pool; independent of the number of threads.
/// `Err` if the machine cannot rotate its tool freely, or from `check`, which is called before each point.
pub(crate) fn nodes_at_points(
    problem: GammaProblem<'_>,
    check: impl Fn() -> Result<()> + Sync,
) -> Result<NodesAtPoints> {
    let path = RotatablePath::new(problem)?;
    let gammas = path.gammas();
    let nodes: Result<Vec<Vec<Node>>> = (0..path.points().len())
        .into_par_iter()
        .map_init(
            || Solver::new(&path),
            |solver, k| {
                check()?;
                Ok(solver.layer(k, &gammas))
            },
        )
        .collect();
    Ok(NodesAtPoints { nodes: nodes?, branches: path.on_branches.iter().map(|on| on.branch).collect(), gammas })
}
