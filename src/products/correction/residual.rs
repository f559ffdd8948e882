//! What is left over the box, without correction, with tables and with exact corrections: worst over forces at each point of a grid.

use nalgebra::Vector3;
use rayon::prelude::*;
use serde::Serialize;

use super::{CorrectionAnswer, CorrectionQuestion, Corrector, bound::axis_forces, loaded::Loaded};
use crate::{
    input::error::Result,
    machine::Configuration,
    simulation::Machines,
    spatial::Grid,
    work::{Event, Stage, Work},
};

/// Most points along an axis.
const MOST: usize = 9;

/// What is left at a position of P.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ResidualPoint {
    /// P in O, mm.
    pub position_mm: [f64; 3],
    /// Distance of the tool from where it is wanted, worst over no force and the largest one along each axis, mm: by
    /// [`ResidualPoint::WAYS`].
    pub left_mm: Vec<f64>,
}

impl ResidualPoint {
    /// Words of tables for the ways to correct, the last only where there is a table for each drive.
    pub const WAYS: [&str; 4] = ["none", "table", "exact", "per_joint"];
}

/// The grid that shows what is left: nodes of the table and the middles of its cells, as far as there are not too many.
pub fn residual_grid(question: &CorrectionQuestion, nodes: &Grid) -> Grid {
    let [min, max] = question.corners;
    Grid::new(min, max, nodes.counts().map(|count| (2 * count - 1).min(MOST)))
}

/// What is left at the points of `grid`, in its order, on the current rayon pool.
///
/// # Errors
/// A position that the machine does not reach, or at which it does not stand. Of `work`.
pub fn residuals(
    question: &CorrectionQuestion,
    answer: &CorrectionAnswer,
    grid: &Grid,
    work: &Work,
) -> Result<Vec<ResidualPoint>> {
    let machines = Machines::new(&question.machine, &question.errors)?;
    work.tell(Event::Stage(Stage { of: "points of the map", items: grid.len() }));
    let point = |loaded: &mut Loaded<'_>, index: usize| {
        work.check()?;
        let position = grid.position(index);
        let at = loaded.stand(position)?;
        let by = |loaded: &mut Loaded<'_>, corrector: Corrector<'_>| {
            worst(loaded, &at, question, |_, force| Ok(corrector.correction(&at, position, force)))
        };
        let mut left_mm = vec![
            by(loaded, Corrector::Nothing)?,
            by(loaded, Corrector::Table(&answer.table))?,
            worst(loaded, &at, question, |loaded, force| loaded.exact(&at, force))?,
        ];
        if let Ok((tables, _)) = &answer.per_joint {
            left_mm.push(by(loaded, Corrector::PerJoint(tables))?);
        }
        work.tell(Event::Computed(1));
        Ok(ResidualPoint { position_mm: position.into(), left_mm })
    };
    let all: Vec<Result<ResidualPoint>> =
        (0..grid.len()).into_par_iter().map_init(|| Loaded::new(question, &machines), point).collect();
    all.into_iter().collect()
}

/// The worst over the forces with the drives corrected as `correction` says of each.
fn worst(
    loaded: &mut Loaded<'_>,
    at: &Configuration,
    question: &CorrectionQuestion,
    correction: impl Fn(&mut Loaded<'_>, Vector3<f64>) -> Result<Vec<f64>>,
) -> Result<f64> {
    axis_forces(question.largest_force_N).into_iter().try_fold(0.0, |most: f64, force| {
        let correction = correction(loaded, force)?;
        Ok(most.max(loaded.left_mm(at, force, &correction)?))
    })
}
