//! Placement: where on the machine a workpiece should stand.
//!
//! A grid sweep ranks all places ([`Cell`]); [`Gaps`] holds places between its grid points; Nelder–Mead refines the best ones and the named
//! ones within the bounds ([`Refinement`]). Named and found places are then compared with all metrics ([`Entry`]), and the best of them
//! that can be cut and lies within the bounds is recommended ([`Best`]). Everything is evaluated on the actual paths with the loaded model
//! and all sources of error ([`Evaluator`]), named places as programmed, found ones at the best γ if it is sought. The results do not depend
//! on the number of threads.
//!
//! The workpiece can be cut at a place if it stays clear of the forbidden boxes and P within the machine's workspace box, the rigid machine
//! reaches all points, and at those where the tool cuts there is a static equilibrium and an exact correction with drives within their
//! travel and forces within their limits; whatever the objective is. An objective of the correction within limits asks for that correction
//! instead. All this holds wherever it is clamped within the [`Allowance`] of the place, and the objective is the worst there.

mod allowance;
mod along;
#[cfg(not(target_family = "wasm"))]
mod bodies;
mod boxes;
mod evaluate;
mod few;
mod front;
mod gaps;
mod margins;
mod metric;
mod outcome;
mod polish;
mod refine;
#[cfg(feature = "report")]
pub mod report;
mod resolve;
mod runs;
mod site;
pub(crate) mod spec;
mod sweep;
mod tally;
mod turned;
mod uncertain;
mod walk;

pub use allowance::Allowance;
pub(crate) use along::stride;
pub use along::{PlacePoint, PlaceResults, Trace};
pub use boxes::Table;
pub use evaluate::{Evaluation, Evaluator, levels};
pub use front::{dominates, undominated};
pub use gaps::Gaps;
pub use margins::{End, Margin, Probe, WORSE, margin_along};
pub use metric::{Metric, Metrics, Objective};
use outcome::EntryEvaluators;
pub use outcome::{Agreement, Best, Entry, Origin, PlacementResults};
pub use polish::basis;
pub use refine::{Refinement, Start};
pub(crate) use resolve::reference_position;
pub use resolve::{CLEARANCE_MM, parse_place};
pub use site::{Bounds, COORDINATES, Site, SiteGrid, UNITS, is_angle};
pub use sweep::{Cell, PlaceOutcome};
pub use uncertain::PlaceSpread;

use std::sync::Arc;

use crate::{
    compensation::Target,
    input::error::Result,
    machine::Machine,
    process::{
        CuttingRule, Extent, Feature, ForbiddenBox, ForceText, PathReference, VerdictTable, cutting::PathLoad,
        file::CorrectionLimits, uncertainty::ForceSpread,
    },
    simulation::{Machines, TrackedPath, spread::DrawnMachines, spread_along::SpreadPath},
    spatial::Pose,
    work::{Event, Stage, Work},
};
use turned::Setup;

/// A feature of the workpiece with everything needed to simulate its cutting.
#[derive(Debug, Clone)]
pub struct FeatureJob {
    /// Path, cutting force and tolerance.
    pub feature: Feature,
    /// Its machine, tolerance and what is uncertain, with the workpiece where its process file places it.
    pub tracked: TrackedPath,
    /// The nominal machine and the actual ones, which have the chain errors.
    pub machines: Machines,
    /// Limits of corrections and forces.
    pub limits: CorrectionLimits,
    /// Components of the pose error that compensation corrects.
    pub target: Target,
    /// Rule for which moves of its path cut.
    pub cuts: CuttingRule,
    /// What must be known of its force.
    pub force_text: ForceText,
    /// What the verdict is about, and bounds of what is not computed.
    pub verdict: VerdictTable,
    /// Loads of the components of the force at each point of its path, where one of them varies by itself.
    pub components: Option<[Vec<PathLoad>; ForceSpread::COMPONENTS.len()]>,
    /// Settings of the search for γ, the rotation about the tool axis, at each place, if there is one.
    pub gamma_search: Option<crate::process::RedundancySettings>,
    /// Points that were worst at other places, indices in path order, if all these points are chosen ones.
    pub worst: Option<Vec<usize>>,
    /// Bodies of its machine and of what surrounds it; `None` where its process names no cell.
    #[cfg(not(target_family = "wasm"))]
    pub bodies: Option<Arc<crate::simulation::clearance::MachineCell>>,
}

impl FeatureJob {
    /// Returns the nominal machine with the feature's tool.
    pub fn machine(&self) -> &Machine {
        &self.machines.nominal
    }

    /// Returns what uncertain inputs make of its machines; `None` where all are exact. `Err` as [`Machines::drawn`].
    fn drawn(&self) -> Result<Option<DrawnMachines>> {
        self.tracked.drawn(&self.machines)
    }

    /// Returns its path with the workpiece at `site`, of which the spread of the largest distance alone is wanted.
    fn spread<'a>(&self, site: &Site, drawn: &'a DrawnMachines) -> SpreadPath<'a> {
        let placement = site.placement(self.feature.reference);
        SpreadPath { placement, audits: 0, by_drive: false, ..self.tracked.spread(drawn) }
    }
}

/// A named place of the workpiece.
#[derive(Debug, Clone, PartialEq)]
pub struct Candidate {
    /// Its name.
    pub name: String,
    /// Pose of W there.
    pub site: Site,
    /// Whether it is judged at its best γ, if one is sought, as found places are; else as programmed.
    pub at_best_gamma: bool,
}

/// Settings of the search for the best place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Search {
    /// Number of best places of the sweep that are refined.
    pub starts: usize,
    /// Largest number of iterations of a Nelder–Mead search, which then continues from where it ended.
    pub max_iterations: usize,
    /// Differences of the objective below this share are negligible.
    pub tolerance: f64,
    /// Whether the sweep prunes places that cannot win before all points are evaluated.
    pub coarse_to_fine: bool,
}

/// A checked placement study.
#[derive(Debug, Clone)]
pub struct PlacementStudy {
    /// The nominal machine with the tool of the first feature.
    pub machine: Machine,
    /// The features to be cut.
    pub features: Vec<FeatureJob>,
    /// Box that the workpiece occupies, W, mm.
    pub extent: Extent,
    /// The table on which the workpiece must stand, if one is given.
    pub table: Option<Table>,
    /// Boxes that the workpiece must stay out of, O.
    pub forbidden: Vec<ForbiddenBox>,
    /// Smallest distance from these boxes on every side, mm.
    pub clearance_mm: f64,
    /// Bounds of the coordinates of the place.
    pub bounds: Bounds,
    /// How far from a place the workpiece may stand once it is clamped.
    pub allowance: Allowance,
    /// Grid of the sweep.
    pub grid: SiteGrid,
    /// The objective to be minimised.
    pub objective: Objective,
    /// Settings of the search.
    pub search: Search,
    /// Named places for comparison.
    pub candidates: Vec<Candidate>,
}

/// Runs the study on the current rayon pool; the items of `work` are the grid points of the sweep, then the searches. `Err` if it was
/// stopped, its pieces could not be kept, or another shard computes them.
pub fn run(study: &PlacementStudy, work: &Work) -> Result<PlacementResults> {
    let evaluator = Arc::new(Evaluator::new(study, &study.objective.metrics()));
    let Found { cells, ranking, gaps, refinements, front } = search(&evaluator, study, work)?;
    let evaluators = study.entry_evaluators(&evaluator);
    let places = outcome::entry_places(study, &cells, &ranking, &refinements);
    let mut entries = outcome::evaluate_entries(&evaluators, study, work, places);
    work.barrier()?;
    uncertain::add_spread(&evaluators, study, &mut entries, work)?;
    let best = outcome::choose_best(study, &entries, &refinements);
    let flatness = margins::margins(&evaluator, study, work, outcome::best_setup(study, &entries))?;
    let traces = along::traces(&evaluators, study, &entries, best.as_ref());
    #[cfg(not(target_family = "wasm"))]
    let clearance = best.as_ref().map_or_else(Vec::new, |best| {
        let at_best = entries[best.entry].feasible().and_then(|own| own.metrics.get(Metric::WorstDeflection));
        let setup = Setup { site: best.site, gammas: entries[best.entry].gammas.clone() };
        evaluators.found.clearances(&setup, at_best.unwrap_or(0.0))
    });
    Ok(PlacementResults {
        #[cfg(not(target_family = "wasm"))]
        clearance,
        front,
        gaps,
        flatness,
        best,
        entries,
        traces,
        cells,
        ranking,
        refinements,
        study: study.clone(),
    })
}

/// Computes the pieces of [`run`], with summaries of finished stages, so that the last pieces need little of the first. `Err` as [`run`].
fn compute(study: &PlacementStudy, work: &Work) -> Result<()> {
    let evaluator = Arc::new(Evaluator::new(study, &study.objective.metrics()));
    let best = work.summary("best", || {
        let places = work.summary("entries", || {
            let Found { cells, ranking, refinements, .. } = search(&evaluator, study, work)?;
            Ok(outcome::entry_places(study, &cells, &ranking, &refinements))
        })?;
        let evaluators = study.entry_evaluators(&evaluator);
        let mut entries = outcome::evaluate_entries(&evaluators, study, work, places);
        work.barrier()?;
        uncertain::add_spread(&evaluators, study, &mut entries, work)?;
        Ok(outcome::best_setup(study, &entries))
    })?;
    margins::margins(&evaluator, study, work, best).map(drop)
}

/// What a search finds before named and found places are compared.
struct Found {
    cells: Vec<Cell>,
    ranking: Vec<usize>,
    gaps: Gaps,
    refinements: Vec<Refinement>,
    front: Vec<(Site, Metrics)>,
}

/// Sweeps the grid, looks between its points, refines the best places and computes the Pareto front. `Err` only from `work`.
fn search(evaluator: &Evaluator, study: &PlacementStudy, work: &Work) -> Result<Found> {
    let cells = sweep::sweep(evaluator, study, &work.part("sweep"))?;
    let ranking = sweep::ranking(study, &cells);
    let gaps = work.summary("gaps", || gaps::find_gaps(evaluator, study, &cells, work))?;
    let starts = refinement_starts(study, &cells, &ranking, &gaps);
    work.tell(Event::Stage(Stage { of: "searches", items: starts.len() }));
    let refinements = refine::refine(evaluator, study, &study.objective, &starts, work)?;
    let front = work.summary("front", || front::pareto_front(evaluator, study, &cells, &refinements, work))?;
    Ok(Found { cells, ranking, gaps, refinements, front })
}

/// Returns the starts of refinements: best places of the sweep, places found between its grid points, named places within the bounds.
fn refinement_starts(study: &PlacementStudy, cells: &[Cell], ranking: &[usize], gaps: &Gaps) -> Vec<(Start, Site)> {
    let swept = sweep::choose_starts(study, cells, ranking).into_iter().map(|index| (Start::Sweep, cells[index].site));
    let between = gaps.sites.iter().take(study.search.starts).map(|site| (Start::Between, *site));
    let named = study.candidates.iter().enumerate();
    let named = named.filter_map(|(k, candidate)| Some((Start::Named(k), study.bounds.inside(&candidate.site)?)));
    let swept: Vec<(Start, Site)> = swept.collect();
    // A search from the same place ends at the same place.
    let between: Vec<_> = between.filter(|(_, site)| !swept.iter().any(|(_, other)| other == site)).collect();
    swept.into_iter().chain(between).chain(named).collect()
}

/// Evaluates only the named places of `study`, with all metrics, each at its best γ if one is sought, best first.
pub fn compare(study: &PlacementStudy) -> Vec<Entry> {
    let places = outcome::entry_places(study, &[], &[], &[]);
    let seeker = Arc::new(Evaluator::new(study, &study.objective.metrics()));
    let evaluators = EntryEvaluators { found: Evaluator::of_all(&seeker), programmed: None };
    outcome::evaluate_entries(&evaluators, study, &Work::default(), places)
}

/// Returns the first `most` of `all`, none of which is alike another as `are_alike` says.
fn first_distinct<T>(all: impl IntoIterator<Item = T>, most: usize, are_alike: impl Fn(&T, &T) -> bool) -> Vec<T> {
    let mut distinct: Vec<T> = Vec::new();
    for own in all {
        if distinct.len() < most && !distinct.iter().any(|other| are_alike(other, &own)) {
            distinct.push(own);
        }
    }
    distinct
}

/// Largest difference of each coordinate between places that count as the same, as a share of its range.
const SAME_PLACE: f64 = 0.02;

impl PlacementStudy {
    /// Returns whether all free coordinates of two places differ by at most [`SAME_PLACE`] of their range.
    fn is_same_place(&self, a: &Site, b: &Site) -> bool {
        let is_same = |i: usize| self.bounds.distance(i, a.0[i], b.0[i]) <= SAME_PLACE * self.bounds.range(i);
        self.bounds.free().into_iter().all(is_same)
    }

    /// Returns whether γ, the rotation about the tool axis, of a feature is sought.
    pub(crate) fn seeks_gamma(&self) -> bool {
        self.features.iter().any(|job| job.gamma_search.is_some())
    }

    /// Returns the study without searches for γ: tools keep their programmed rotation about their axes.
    fn as_programmed(&self) -> Self {
        let as_programmed = |job: &FeatureJob| FeatureJob { gamma_search: None, ..job.clone() };
        Self { features: self.features.iter().map(as_programmed).collect(), ..self.clone() }
    }

    /// Returns the evaluators of named places, most of which stay as programmed, and of found places, with all metrics; `seeker` has found γ so far.
    fn entry_evaluators(&self, seeker: &Arc<Evaluator>) -> EntryEvaluators {
        EntryEvaluators {
            found: Evaluator::of_all(seeker),
            programmed: self.seeks_gamma().then(|| Evaluator::new(&self.as_programmed(), &Metric::ALL)),
        }
    }

    /// Returns whether a feature has limits of corrections or forces.
    pub(crate) fn has_limits(&self) -> bool {
        self.features.iter().any(|job| job.limits.is_limited())
    }

    /// Returns whether bodies are looked at along all features; pages look at none.
    pub(crate) fn has_cell(&self) -> bool {
        #[cfg(not(target_family = "wasm"))]
        return self.features.iter().all(|job| job.bodies.is_some());
        #[cfg(target_family = "wasm")]
        return false;
    }

    /// Returns the pose `X_OW` of the workpiece at `site`.
    pub(crate) fn workpiece_pose(&self, site: &Site) -> Pose {
        *site.placement(PathReference::default()).place(&self.machine).workpiece()
    }

    /// Makes a study that compares the places `candidates` for one feature by its worst deflection, without a search.
    pub fn for_candidates(machine: Machine, job: FeatureJob, extent: Extent, candidates: Vec<Candidate>) -> Self {
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
            allowance: Allowance::default(),
            objective: Objective { weights: vec![(Metric::WorstDeflection, 1.0)], pareto: Vec::new() },
            search: Search { starts: 1, max_iterations: 1, tolerance: 1e-4, coarse_to_fine: true },
            candidates,
        }
    }
}
