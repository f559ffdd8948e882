//! Where on the machine a workpiece should stand.
//!
//! A grid sweep ranks all places ([`Cell`]); where the workpiece fits between them is looked for ([`Gaps`]); Nelder–Mead
//! refines the best ones and the named ones within the bounds ([`Refinement`]). Named and found places are then examined
//! side by side ([`Entry`]), and the best of them that can be cut at and lies within the bounds is recommended ([`Best`]).
//! Everything is evaluated on the actual paths with the loaded model and both sources of error ([`Evaluator`]). The results
//! do not depend on the number of threads.
//!
//! The workpiece can be cut at a place if it keeps the forbidden boxes with their clearance, P stays within the machine's
//! workspace box, the rigid machine reaches all points, the loaded one stands at those where the tool cuts, and there the
//! exact correction exists, with drives within their travel and forces within their limits; whatever the objective is. One
//! that asks for the correction within limits asks for that instead, which keeps travel and forces itself.

mod along;
mod boxes;
mod evaluate;
mod flatness;
mod front;
mod gaps;
mod metric;
mod outcome;
mod polish;
mod refine;
#[cfg(feature = "report")]
pub mod report;
mod resolve;
mod site;
pub(crate) mod spec;
mod sweep;
mod tally;
#[cfg(not(target_family = "wasm"))]
mod turned;
mod walk;

pub(crate) use along::stride;
pub use along::{Along, AlongPoint, Trace};
pub use boxes::Table;
pub use evaluate::{Evaluation, Evaluator, levels};
pub use flatness::{End, Room, Sight, WORSE, way};
pub use front::{dominates, undominated};
pub use gaps::Gaps;
pub use metric::{Metric, Metrics, Objective};
pub use outcome::{Agreement, Best, Entry, Found, PlacementResults};
pub use polish::basis;
pub use refine::{Refinement, Start};
pub(crate) use resolve::at_point;
pub use resolve::{CLEARANCE_MM, place};
pub use site::{Bounds, COORDINATES, Site, SiteGrid, UNITS, is_angle};
pub use sweep::{Cell, Verdict};

use crate::{
    compensation::Target,
    input::error::Result,
    machine::{ChainError, Machine},
    process::{CuttingRule, Extent, Feature, ForbiddenBox, PathReference, file::CorrectionLimits},
    simulation::{Machines, tasks::placed},
    spatial::Pose,
    work::{Event, Stage, Work},
};

/// A feature and how it is cut.
#[derive(Debug, Clone)]
pub struct FeatureJob {
    /// Path, cutting force and tolerance.
    pub feature: Feature,
    /// The nominal machine and those that answer, which have the chain errors.
    pub machines: Machines,
    /// Errors of each chain.
    pub errors: Vec<ChainError>,
    /// Limits of corrections and forces.
    pub limits: CorrectionLimits,
    /// What compensation puts right.
    pub target: Target,
    /// Which moves of its path cut.
    pub cuts: CuttingRule,
    /// How the turn about the tool's axis is sought at each place, if it is.
    #[cfg(not(target_family = "wasm"))]
    pub turn: Option<crate::process::RedundancySettings>,
}

impl FeatureJob {
    /// The nominal machine with the feature's tool.
    pub fn machine(&self) -> &Machine {
        &self.machines.nominal
    }

    /// What is said of a place outside the workspace box, where the turn about the tool's axis is sought.
    fn at_every_turn(&self) -> &'static str {
        #[cfg(not(target_family = "wasm"))]
        if self.turn.is_some() {
            return "; no rotation about the tool axis keeps the path within the box and the machine within its limits";
        }
        ""
    }
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
    /// Most iterations of a search by Nelder–Mead, which then goes on from where it ended.
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
    /// The table on which it is to stand.
    pub table: Option<Table>,
    /// Boxes it must stay out of, in O.
    pub forbidden: Vec<ForbiddenBox>,
    /// How far it must stay from them on every side, mm.
    pub clearance_mm: f64,
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
    let gaps = gaps::gaps(&evaluator, study, &cells, work)?;
    let starts = starts(study, &cells, &ranking, &gaps);
    work.tell(Event::Stage(Stage { of: "searches", items: starts.len() + front::searches(study) }));
    let refinements = refine::refine(&evaluator, study, &study.objective, &starts, work)?;
    let front = front::front(&evaluator, study, &cells, &refinements, work)?;
    let everything = Evaluator::new(study, &Metric::ALL);
    let entries = outcome::entries(&everything, study, work, (&cells, &ranking, &refinements));
    work.barrier()?;
    let best = outcome::best(study, &entries, &refinements);
    work.tell(Event::Stage(Stage { of: "ways from the best place", items: 2 * study.bounds.free().len() }));
    let flatness = best.as_ref().map(|best| flatness::flatness(&evaluator, study, work, best)).transpose()?;
    let traces = along::traces(&everything, study, &entries, best.as_ref());
    Ok(PlacementResults {
        front,
        gaps,
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

/// Where refinements start: best places of the sweep and those found between, as many as there are starts of each, and
/// every named place within the bounds.
fn starts(study: &PlacementStudy, cells: &[Cell], ranking: &[usize], gaps: &Gaps) -> Vec<(Start, Site)> {
    let swept = sweep::starts(study, cells, ranking).into_iter().map(|index| (Start::Sweep, cells[index].site));
    let between = gaps.sites.iter().take(study.search.starts).map(|site| (Start::Between, *site));
    let named = study.candidates.iter().enumerate();
    let named = named.filter_map(|(k, candidate)| Some((Start::Named(k), study.bounds.inside(&candidate.site)?)));
    swept.chain(between).chain(named).collect()
}

/// Evaluates the named places of `study` alone, with all metrics, best first.
pub fn compare(study: &PlacementStudy) -> Vec<Entry> {
    outcome::entries(&Evaluator::new(study, &Metric::ALL), study, &Work::default(), (&[], &[], &[]))
}

/// Places are the same if every coordinate differs by less than this share of its range.
const SAME_PLACE: f64 = 0.02;

impl PlacementStudy {
    /// Whether two places differ by little.
    fn is_same_place(&self, a: &Site, b: &Site) -> bool {
        let is_same = |i: usize| self.bounds.distance(i, a.0[i], b.0[i]) <= SAME_PLACE * self.bounds.range(i);
        self.bounds.free().into_iter().all(is_same)
    }

    /// Whether a feature has limits of corrections or forces.
    pub(crate) fn has_limits(&self) -> bool {
        self.features.iter().any(|job| job.limits.is_limited())
    }

    /// `X_OW` at `site`.
    pub(crate) fn workpiece(&self, site: &Site) -> Pose {
        *placed(&self.machine, &site.placement(PathReference::default())).workpiece()
    }

    /// Named places for one feature, judged by its worst deflection; nothing is sought.
    pub fn of_places(machine: Machine, job: FeatureJob, extent: Extent, candidates: Vec<Candidate>) -> Self {
        let bounds = Bounds { low: [0.0; 6], high: [0.0; 6] };
        Self {
            machine,
            features: vec![job],
            extent,
            table: None,
            forbidden: Vec::new(),
            clearance_mm: 0.0,
            grid: SiteGrid::new(&bounds, [1; 6]),
            bounds,
            objective: Objective { weights: vec![(Metric::WorstDeflection, 1.0)], pareto: Vec::new() },
            search: Search { starts: 1, max_iterations: 1, tolerance: 1e-4, coarse_to_fine: true },
            candidates,
        }
    }
}
