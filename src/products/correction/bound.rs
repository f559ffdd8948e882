//! The farthest that the tool is from where it is wanted, sought over all positions of a box and all forces up to the largest one.
//!
//! The loaded machine itself is asked, in three steps that are the same each time: on a lattice of half the cells of the table, where the
//! error of linear interpolation is largest, without force and with the largest one along each axis; at the points of a Halton
//! sequence (J. H. Halton, Numerische Mathematik 2, 1960) over position and force; and by Nelder–Mead from the worst of these, each in
//! another cell. What is found is no proof, but the largest of a great many values.

use nalgebra::Vector3;
use rayon::prelude::*;
use serde::Serialize;

use super::{
    CorrectionQuestion, Corrector,
    cases::{Case, force_directions, lattice, spread},
    climb::climb,
    loaded::Loaded,
};
use crate::{
    input::error::Result,
    simulation::Machines,
    spatial::Grid,
    work::{Event, Stage, Work},
};

/// A largest error, and where it was found.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[allow(non_snake_case, reason = "the unit is N, not n")]
pub struct Worst {
    /// Distance of the tool from where it is wanted, mm.
    pub error_mm: f64,
    /// P in O, mm.
    pub position_mm: [f64; 3],
    /// Force on the tool tip in O axes, N.
    pub force_N: [f64; 3],
    /// How many positions and forces were looked at.
    pub looked_at: usize,
}

/// Points of the Halton sequence.
const SPREAD: usize = 2048;
/// Searches by Nelder–Mead.
const STARTS: usize = 16;

/// The worst that is found with `corrector`, on the current rayon pool; `cells` is the grid whose cells are looked into. One on the
/// lattice that is larger than `enough` mm ends the search.
///
/// # Errors
/// A position that the machine does not reach, or at which it does not stand. Of `work`.
pub fn worst(
    question: &CorrectionQuestion,
    machines: &Machines,
    corrector: &Corrector<'_>,
    cells: &Grid,
    enough: f64,
    work: &Work,
) -> Result<Worst> {
    let search = Search { question, machines, corrector, cells };
    let mut cases = lattice(question, cells);
    work.tell(Event::Stage(Stage { of: "points off the grid", items: cases.len() + SPREAD }));
    let mut found = search.errors(&cases, work)?;
    let ends_here = found.iter().any(|error| *error > enough);
    if !ends_here {
        let spread: Vec<Case> = (1..=SPREAD).map(|index| spread(question, index)).collect();
        found.extend(search.errors(&spread, work)?);
        cases.extend(spread);
    }
    let looked_at = cases.len();
    let mut ranked: Vec<usize> = (0..looked_at).collect();
    ranked.sort_by(|&a, &b| found[b].total_cmp(&found[a]).then(a.cmp(&b)));
    let starts = if ends_here { Vec::new() } else { search.apart(&cases, &ranked) };
    let ends = starts.par_iter().map_init(
        || Loaded::new(question, machines),
        |loaded, &start| {
            work.check()?;
            climb(&search, loaded, cases[start], found[start])
        },
    );
    let mut looked_at = looked_at;
    for (case, error, count) in ends.collect::<Result<Vec<_>>>()? {
        looked_at += count;
        cases.push(case);
        found.push(error);
    }
    let largest = (0..cases.len()).max_by(|&a, &b| found[a].total_cmp(&found[b]).then(b.cmp(&a))).unwrap_or(0);
    Ok(Worst { looked_at, ..of(cases[largest], found[largest]) })
}

/// The worst at the nodes of `nodes` alone, under forces of several sizes and in many directions.
pub(super) fn worst_at_nodes(
    question: &CorrectionQuestion,
    machines: &Machines,
    corrector: &Corrector<'_>,
    nodes: &Grid,
    work: &Work,
) -> Result<f64> {
    let search = Search { question, machines, corrector, cells: nodes };
    let forces: Vec<Vector3<f64>> = force_directions(question.largest_force_N);
    let cases: Vec<Case> =
        (0..nodes.len()).flat_map(|node| forces.iter().map(move |force| (nodes.position(node), *force))).collect();
    Ok(search.errors(&cases, work)?.into_iter().fold(0.0, f64::max))
}

fn of((position, force): Case, error_mm: f64) -> Worst {
    Worst { error_mm, position_mm: position.into(), force_N: force.into(), looked_at: 0 }
}

/// A way to correct, and the cells that are looked into.
pub(super) struct Search<'a> {
    pub question: &'a CorrectionQuestion,
    machines: &'a Machines,
    corrector: &'a Corrector<'a>,
    pub cells: &'a Grid,
}

impl Search<'_> {
    fn errors(&self, cases: &[Case], work: &Work) -> Result<Vec<f64>> {
        let error = |loaded: &mut Loaded<'_>, case: &Case| {
            work.check()?;
            let error = self.error(loaded, case);
            work.tell(Event::Computed(1));
            error
        };
        let all: Vec<Result<f64>> =
            cases.par_iter().map_init(|| Loaded::new(self.question, self.machines), error).collect();
        all.into_iter().collect()
    }

    /// How far the tool is off there, mm.
    pub fn error(&self, loaded: &mut Loaded<'_>, (position, force): &Case) -> Result<f64> {
        let at = loaded.stand(*position)?;
        loaded.left_mm(&at, *force, &self.corrector.correction(&at, *position, *force))
    }

    /// The worst cases, no two of them in the same cell.
    fn apart(&self, cases: &[Case], ranked: &[usize]) -> Vec<usize> {
        let cell = |index: usize| {
            let (position, _) = cases[index];
            [0, 1, 2].map(|axis| self.cells.axes[axis].partition_point(|node| *node <= position[axis]))
        };
        let mut starts: Vec<usize> = Vec::new();
        for &index in ranked {
            if starts.len() == STARTS {
                break;
            }
            if !starts.iter().any(|&other| cell(other) == cell(index)) {
                starts.push(index);
            }
        }
        starts
    }
}
