//! Every turn at every point, on its own: what redundancy maps are made of.

use rayon::prelude::*;

use super::{
    nodes::{Node, Solver},
    turnable::{TurnAsked, Turnable},
};
use crate::{input::error::Result, machine::Branch};

/// What the loaded tool does at each turn and on each branch at points that have nothing to do with one another.
#[derive(Debug, Clone)]
pub(crate) struct AtPoints {
    /// The turns, rad.
    pub turns: Vec<f64>,
    /// The branches.
    pub branches: Vec<Option<Branch>>,
    /// Of each point, turn by turn, what each branch comes to.
    pub nodes: Vec<Vec<Node>>,
}

/// Solves every turn on every branch at each point of the path of `asked`, on the current rayon pool. What is found does not depend on
/// its threads.
///
/// # Errors
/// A machine that cannot turn its tool freely, and those of `check`, which is called before each point.
pub(crate) fn at_points(asked: TurnAsked<'_>, check: impl Fn() -> Result<()> + Sync) -> Result<AtPoints> {
    let path = Turnable::new(asked)?;
    let turns = path.turns();
    let nodes: Result<Vec<Vec<Node>>> = (0..path.points().len())
        .into_par_iter()
        .map_init(
            || Solver::new(&path),
            |solver, k| {
                check()?;
                Ok(solver.layer(k, &turns))
            },
        )
        .collect();
    Ok(AtPoints { nodes: nodes?, branches: path.on_branches.iter().map(|on_branch| on_branch.branch).collect(), turns })
}
