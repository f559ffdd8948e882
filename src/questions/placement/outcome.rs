//! Results of a placement study, and how the best place is chosen from them.

use rayon::prelude::*;

use serde::{Deserialize, Serialize};

use super::{
    PlacementStudy,
    along::Trace,
    evaluate::{Evaluation, Evaluator},
    first_distinct,
    gaps::Gaps,
    margins::Margin,
    metric::Metrics,
    refine::Refinement,
    site::Site,
    sweep::Cell,
    turned::Setup,
    uncertain::PlaceSpread,
};
use crate::{
    simulation::Failure,
    work::{Event, Stage, Work},
};

/// Results of a placement study.
#[derive(Debug, Clone, Serialize)]
pub struct PlacementResults {
    /// The study.
    #[serde(skip)]
    pub study: PlacementStudy,
    /// Cells of the sweep, in grid order.
    pub cells: Vec<Cell>,
    /// Indices of the cells that can be cut, best first.
    pub ranking: Vec<usize>,
    /// Places between the grid points of the sweep where the workpiece fits.
    pub gaps: Gaps,
    /// Refinements from each start that can be cut: those of the sweep in the order of the ranking, those between, named places.
    pub refinements: Vec<Refinement>,
    /// The best place found within the bounds; `None` if the workpiece can be cut at none.
    pub best: Option<Best>,
    /// Margins of the best place along each free coordinate.
    pub flatness: Vec<Margin>,
    /// Named and found places with all metrics, best first; those that cannot be cut last.
    pub entries: Vec<Entry>,
    /// Pareto front of the metrics asked for, sorted by the first of them.
    pub front: Vec<(Site, Metrics)>,
    /// Paths at the best place and at the poorest.
    pub traces: Vec<Trace>,
    /// How near bodies come at the best place along the path of each feature; `None` without bodies.
    #[cfg(not(target_family = "wasm"))]
    pub clearance: Vec<Option<(Site, crate::simulation::clearance::PathClearance)>>,
}

/// The best place and how it was found. It is one of the entries.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Best {
    /// Index of its entry.
    pub entry: usize,
    /// The place.
    pub site: Site,
    /// Its objective.
    pub value: f64,
    /// How it was found.
    pub found: Origin,
    /// How the end of each refinement compares with it.
    pub agreement: Vec<Agreement>,
}

/// How a refinement's end compares with the best place.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum Agreement {
    /// Same value at the same place.
    Same,
    /// Same value at another place: the optimum is flat, or there are several.
    Elsewhere,
    /// A worse value.
    Worse,
}

/// Origin of an entry.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Origin {
    /// A named place of the study.
    Named,
    /// The best place of the sweep.
    Sweep,
    /// The end of the refinement of this index.
    Refinement(usize),
}

impl Origin {
    /// Returns the word for the origin in tables.
    pub fn label(self) -> &'static str {
        match self {
            Origin::Named => "named",
            Origin::Sweep => "sweep",
            Origin::Refinement(_) => "optimised",
        }
    }
}

/// A named or found place with all metrics.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Entry {
    /// Its name.
    pub name: String,
    /// Where the place comes from.
    pub found: Origin,
    /// The place.
    pub site: Site,
    /// γ of each feature there, rad; `None` as programmed, or where none is possible.
    pub gammas: Vec<Option<f64>>,
    /// Its evaluation, also where the path leaves the workspace box, or why there is none.
    pub outcome: Result<Evaluation, Failure>,
    /// The objective; infinite without an evaluation.
    pub value: f64,
    /// How sure it is; `None` where inputs are taken as exact, or the workpiece cannot be cut.
    pub spread: Option<PlaceSpread>,
}

/// Name of the best place of the sweep.
const BEST_OF_SWEEP: &str = "best of the sweep";
/// Name of the end of a refinement, before its number.
const OPTIMISED: &str = "optimised ";

/// Returns whether `name`, in capitals or small letters, is one that results give to places that the search finds.
pub(super) fn is_name_of_found(name: &str) -> bool {
    let name = name.trim().to_lowercase();
    name == BEST_OF_SWEEP || name.strip_prefix(OPTIMISED).is_some_and(|number| number.trim().parse::<usize>().is_ok())
}

/// Largest relative difference between objectives that count as the same.
const SAME_VALUE: f64 = 1e-3;
/// Objectives below this, per unit of all weights, are zero within solver tolerance.
const ZERO: f64 = 1e-8;

impl PlacementStudy {
    /// Returns whether an objective, or a difference of two, is zero within solver tolerance.
    pub fn is_zero(&self, value: f64) -> bool {
        value.abs() <= ZERO * self.objective.weights.iter().map(|(_, weight)| weight).sum::<f64>()
    }
}

impl Entry {
    /// Returns the evaluation, if the workpiece can be cut there, else `None`.
    pub fn feasible(&self) -> Option<&Evaluation> {
        self.outcome.as_ref().ok().filter(|evaluation| evaluation.outside_workspace.is_none())
    }

    /// Returns why the workpiece cannot be cut there, if it cannot.
    pub fn refusal(&self) -> Option<&Failure> {
        self.outcome.as_ref().map_or_else(Some, |evaluation| evaluation.outside_workspace.as_ref())
    }
}

/// Returns the index of the best of `entries` that can be cut and lies within the bounds, and its place; `None` if there is none.
fn best_entry(study: &PlacementStudy, entries: &[Entry]) -> Option<(usize, Site)> {
    let mut can_be_cut = entries.iter().enumerate().filter(|(_, entry)| entry.feasible().is_some());
    can_be_cut.find_map(|(index, entry)| Some((index, study.bounds.inside(&entry.site)?)))
}

/// Returns the place of [`best_entry`] as it is cut, with its objective.
pub(super) fn best_setup(study: &PlacementStudy, entries: &[Entry]) -> Option<(Setup, f64)> {
    let (index, site) = best_entry(study, entries)?;
    Some((Setup { site, gammas: entries[index].gammas.clone() }, entries[index].value))
}

/// Returns the best of `entries` that can be cut and lies within the bounds, with how each refinement agrees; `None` if there is none.
pub(super) fn choose_best(study: &PlacementStudy, entries: &[Entry], refinements: &[Refinement]) -> Option<Best> {
    let (index, site) = best_entry(study, entries)?;
    let Entry { value, found, .. } = entries[index];
    let agreement = |refinement: &Refinement| {
        let excess = refinement.value - value;
        let is_close = excess <= SAME_VALUE * value.abs() || study.is_zero(excess);
        match (is_close, study.is_same_place(&refinement.site, &site)) {
            (true, true) => Agreement::Same,
            (true, false) => Agreement::Elsewhere,
            _ => Agreement::Worse,
        }
    };
    Some(Best { entry: index, site, value, found, agreement: refinements.iter().map(agreement).collect() })
}

/// Returns named places, the best of the sweep and the ends of the refinements, each once: name, origin, coordinates.
pub(super) fn entry_places(
    study: &PlacementStudy,
    cells: &[Cell],
    ranking: &[usize],
    refinements: &[Refinement],
) -> Vec<(String, Origin, Site)> {
    let mut places: Vec<(String, Origin, Site)> =
        study.candidates.iter().map(|c| (c.name.clone(), Origin::Named, c.site)).collect();
    places.extend(ranking.first().map(|&index| (BEST_OF_SWEEP.into(), Origin::Sweep, cells[index].site)));
    for (index, refinement) in distinct_refinements(study, refinements) {
        // One that gained nothing on a named place is that place, if both are at the same γ.
        let is_named = |candidate: &super::Candidate| study.bounds.inside(&candidate.site) == Some(refinement.site);
        if study.seeks_gamma() || !study.candidates.iter().any(is_named) {
            places.push((format!("{OPTIMISED}{}", index + 1), Origin::Refinement(index), refinement.site));
        }
    }
    places
}

/// Evaluators of named and of found places, with all metrics.
pub(super) struct EntryEvaluators {
    pub found: Evaluator,
    /// Of named places that stay as programmed, if they are evaluated otherwise.
    pub programmed: Option<Evaluator>,
}

impl EntryEvaluators {
    /// Returns the evaluator of the place of this name and origin.
    pub fn of(&self, name: &str, origin: Origin) -> &Evaluator {
        let is_at_best = |named: &super::Candidate| named.at_best_gamma && named.name == name;
        let is_programmed = origin == Origin::Named && !self.found.study.candidates.iter().any(is_at_best);
        self.programmed.as_ref().filter(|_| is_programmed).unwrap_or(&self.found)
    }
}

/// Evaluates `places` (name, origin, coordinates) with all metrics, found ones as they are printed, and returns them as entries, feasible ones first, then by objective.
pub(super) fn evaluate_entries(
    evaluators: &EntryEvaluators,
    study: &PlacementStudy,
    work: &Work,
    places: Vec<(String, Origin, Site)>,
) -> Vec<Entry> {
    work.tell(Event::Stage(Stage { of: "places compared", items: places.len() }));
    let entry = |(number, (name, found, site)): (usize, (String, Origin, Site))| {
        let evaluator = evaluators.of(&name, found);
        let is_found = std::ptr::eq(evaluator, &evaluators.found);
        let work = work.shard(number).part(if is_found { "found" } else { "named" });
        // A named place is as its author wrote it.
        let (site, outcome) = match found {
            Origin::Named => (site, evaluator.examine_in_work(&work, &site)),
            _ => evaluator.examine_printed(&work, &site),
        };
        let value = outcome.as_ref().map_or(f64::INFINITY, |evaluation| study.objective.value(&evaluation.metrics));
        let gammas = evaluator.setup(&site).gammas;
        work.tell(Event::Computed(1));
        Entry { name, found, site, gammas, outcome, value, spread: None }
    };
    let mut entries: Vec<Entry> = places.into_par_iter().enumerate().map(entry).collect();
    // A stable sort: of equal ones, the named one first.
    entries.sort_by(|a, b| {
        let is_infeasible = |entry: &Entry| entry.feasible().is_none();
        is_infeasible(a).cmp(&is_infeasible(b)).then(a.value.total_cmp(&b.value))
    });
    entries
}

/// Returns the refinements that do not end at the place of a better one, best first.
fn distinct_refinements<'a>(study: &PlacementStudy, refinements: &'a [Refinement]) -> Vec<(usize, &'a Refinement)> {
    let mut sorted: Vec<(usize, &Refinement)> = refinements.iter().enumerate().collect();
    sorted.sort_by(|a, b| a.1.value.total_cmp(&b.1.value));
    first_distinct(sorted, usize::MAX, |(_, a), (_, b)| study.is_same_place(&a.site, &b.site))
}
