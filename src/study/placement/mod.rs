//! Where on the machine a workpiece should stand.
//!
//! A grid sweep ranks all places ([`Cell`]), Nelder–Mead refines the best ones ([`Refinement`]), and named places are shown
//! beside what was found ([`Entry`]). Everything is evaluated on the actual paths with the loaded model and both sources
//! of error ([`Evaluator`]). The results do not depend on the number of threads.
//!
//! Drive forces are those of the exact correction; a place where one exceeds its limit is refused, unless the objective
//! asks for the correction within limits, which keeps them itself.

mod bounded;
mod evaluate;
mod flatness;
mod metric;
mod outcome;
mod pareto;
mod refine;
mod resolve;
mod site;
mod sweep;
mod tally;
mod trace;
mod walk;

pub use evaluate::{Evaluation, Evaluator};
pub use flatness::{End, Room, WORSE};
pub use metric::{Metric, Metrics, Objective};
pub use outcome::{Agreement, Best, Entry, Found, PlacementResults};
pub use refine::Refinement;
pub use resolve::place;
pub(super) use resolve::placement as resolve;
pub use site::{Bounds, COORDINATES, Site, SiteGrid, UNITS, is_angle};
pub use sweep::{Cell, Verdict};
pub use trace::Trace;

use super::{Work, process::CorrectionLimits};
use crate::{
    compensation::Target,
    error::Result,
    machine::{ChainError, Machine},
    process::{Extent, Feature, ForbiddenBox},
};

/// A feature and how it is cut.
#[derive(Debug, Clone)]
pub struct FeatureJob {
    /// Path, cutting force and tolerance.
    pub feature: Feature,
    /// Errors of each chain of the real machine.
    pub errors: Vec<ChainError>,
    /// Limits of corrections and forces.
    pub limits: CorrectionLimits,
    /// What compensation puts right.
    pub target: Target,
}

/// A named place.
#[derive(Debug, Clone, PartialEq)]
pub struct Candidate {
    /// Its name.
    pub name: String,
    /// Where.
    pub site: Site,
}

/// How the best place is sought.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Search {
    /// Refinements.
    pub starts: usize,
    /// Most iterations of each.
    pub max_iterations: usize,
    /// Share of the objective below which a difference is none.
    pub tolerance: f64,
    /// Whether the sweep gives up places that cannot win before all points are evaluated.
    pub coarse_to_fine: bool,
}

/// A checked placement study.
#[derive(Debug, Clone)]
pub struct PlacementStudy {
    /// The nominal machine.
    pub machine: Machine,
    /// What is cut.
    pub features: Vec<FeatureJob>,
    /// The room the workpiece takes, in W.
    pub extent: Extent,
    /// Boxes it must stay out of, in O.
    pub forbidden: Vec<ForbiddenBox>,
    /// Where it may stand.
    pub bounds: Bounds,
    /// Places of the sweep.
    pub grid: SiteGrid,
    /// What is made small.
    pub objective: Objective,
    /// How it is sought.
    pub search: Search,
    /// Named places to compare with.
    pub candidates: Vec<Candidate>,
}

/// Runs the study on the current rayon pool. The places of the sweep are the items of `work`.
///
/// # Errors
/// Of `work`.
pub fn run(study: &PlacementStudy, work: &Work) -> Result<PlacementResults> {
    let needed = study.objective.metrics();
    let evaluator = Evaluator::new(study, &needed);
    let cells = sweep::sweep(&evaluator, study, &work.part("sweep"))?;
    let ranking = sweep::ranking(study, &cells);
    let starts: Vec<Site> = sweep::starts(study, &cells, &ranking).iter().map(|&index| cells[index].site).collect();
    let refinements = refine::refine(&evaluator, study, &study.objective, &starts, work);
    work.check()?;
    let ends = outcome::front_ends(&evaluator, study, &cells, work);
    let best = outcome::best(study, &cells, &ranking, &refinements);
    let flatness = best.as_ref().map(|best| flatness::flatness(&evaluator, study, work, best));
    let everything = Evaluator::new(study, &Metric::ALL);
    let entries = outcome::entries(&everything, study, work, (&cells, &ranking, &refinements));
    work.check()?;
    let traces = trace::traces(&everything, study, &entries);
    Ok(PlacementResults {
        front: outcome::front(study, &cells, &refinements, &ends),
        flatness: flatness.unwrap_or_default(),
        best,
        entries,
        traces,
        cells,
        ranking,
        refinements,
        study: study.clone(),
    })
}

/// Evaluates the named places of `study` alone, with all metrics, best first.
pub fn compare(study: &PlacementStudy) -> Vec<Entry> {
    outcome::entries(&Evaluator::new(study, &Metric::ALL), study, &Work::default(), (&[], &[], &[]))
}

impl PlacementStudy {
    /// Named places for one feature, judged by its worst deflection; nothing is sought.
    pub fn of_places(machine: Machine, job: FeatureJob, extent: Extent, candidates: Vec<Candidate>) -> Self {
        let bounds = Bounds { low: [0.0; 6], high: [0.0; 6] };
        Self {
            machine,
            features: vec![job],
            extent,
            forbidden: Vec::new(),
            grid: SiteGrid::new(&bounds, [1; 6]),
            bounds,
            objective: Objective { weights: vec![(Metric::WorstDeflection, 1.0)], pareto: Vec::new() },
            search: Search { starts: 1, max_iterations: 1, tolerance: 1e-4, coarse_to_fine: true },
            candidates,
        }
    }
}
