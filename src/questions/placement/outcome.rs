//! What a placement study found.

use rayon::prelude::*;

use serde::Serialize;

use super::{
    PlacementStudy,
    along::Trace,
    evaluate::{Evaluation, Evaluator},
    flatness::Room,
    gaps::Gaps,
    metric::Metrics,
    refine::Refinement,
    site::Site,
    sweep::Cell,
};
use crate::{simulation::Failure, work::Work};

/// Results of a placement study.
#[derive(Debug, Clone, Serialize)]
pub struct PlacementResults {
    /// The study.
    #[serde(skip)]
    pub study: PlacementStudy,
    /// The sweep, in grid order.
    pub cells: Vec<Cell>,
    /// Indices of the cells that can be cut, best first.
    pub ranking: Vec<usize>,
    /// Where the workpiece fits between the places of the sweep.
    pub gaps: Gaps,
    /// One per start that can be cut at: those of the sweep in the order of the ranking, those between, named places.
    pub refinements: Vec<Refinement>,
    /// The best place known within the bounds; `None` if the workpiece can be cut at none.
    pub best: Option<Best>,
    /// How far the workpiece may be moved from there.
    pub flatness: Vec<Room>,
    /// Named and found places with all metrics, best first, those that cannot be cut at last.
    pub entries: Vec<Entry>,
    /// The best compromises between the metrics asked for, by the first of them.
    pub front: Vec<(Site, Metrics)>,
    /// Paths at the best and at a poor place.
    pub traces: Vec<Trace>,
}

/// The best place and how it was found. It is one of the entries.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Best {
    /// Index of its entry.
    pub entry: usize,
    /// Where.
    pub site: Site,
    /// Objective there.
    pub value: f64,
    /// What found it.
    pub found: Found,
    /// What each refinement has to say to it.
    pub agreement: Vec<Agreement>,
}

/// How a refinement's end compares with the best place.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum Agreement {
    /// Same value, same place.
    Same,
    /// Same value at another place: the optimum is flat, or there are several.
    Elsewhere,
    /// A worse value.
    Worse,
}

/// Where an entry comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum Found {
    /// It is a named place of the study.
    Named,
    /// It is the best place of the sweep.
    Sweep,
    /// It is where a refinement ended.
    Refinement(usize),
}

impl Found {
    /// Word used in tables.
    pub fn label(self) -> &'static str {
        match self {
            Found::Named => "named",
            Found::Sweep => "sweep",
            Found::Refinement(_) => "optimised",
        }
    }
}

/// A place with all metrics.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Entry {
    /// Its name.
    pub name: String,
    /// Where it comes from.
    pub found: Found,
    /// Where.
    pub site: Site,
    /// Turn of each feature about the tool's axis there, rad; `None` where none is sought or possible.
    pub turns: Vec<Option<f64>>,
    /// What happens there, whether or not the path leaves the workspace box, or why nothing does.
    pub outcome: Result<Evaluation, Failure>,
    /// The objective; infinite where there is none.
    pub value: f64,
}

/// Names of found places: the best one of the sweep, and before the number of a refinement.
const BEST_OF_SWEEP: &str = "best of the sweep";
const OPTIMISED: &str = "optimised ";

/// Whether a found place is, or could be, called so, capitals and small letters being the same.
pub(super) fn is_name_of_found(name: &str) -> bool {
    let name = name.trim().to_lowercase();
    name == BEST_OF_SWEEP || name.strip_prefix(OPTIMISED).is_some_and(|number| number.trim().parse::<usize>().is_ok())
}

/// Values are the same if they differ by less than this share.
const SAME_VALUE: f64 = 1e-3;
/// Values below this, per unit of all weights, are zero: what solving the machine leaves open.
const ZERO: f64 = 1e-8;

impl PlacementStudy {
    /// Whether a difference of the objective, or a value of it, is nothing but rounding.
    pub fn is_zero(&self, value: f64) -> bool {
        value.abs() <= ZERO * self.objective.weights.iter().map(|(_, weight)| weight).sum::<f64>()
    }
}

impl Entry {
    /// What happens there, if the workpiece can be cut there.
    pub fn feasible(&self) -> Option<&Evaluation> {
        self.outcome.as_ref().ok().filter(|evaluation| evaluation.outside_workspace.is_none())
    }

    /// Why it cannot.
    pub fn refusal(&self) -> Option<&Failure> {
        self.outcome.as_ref().map_or_else(Some, |evaluation| evaluation.outside_workspace.as_ref())
    }
}

/// The best of `entries` that can be cut at and lies within the bounds.
pub(super) fn best(study: &PlacementStudy, entries: &[Entry], refinements: &[Refinement]) -> Option<Best> {
    let is_wanted = |entry: &Entry| entry.feasible().is_some() && study.bounds.inside(&entry.site).is_some();
    let index = entries.iter().position(is_wanted)?;
    let Entry { site, value, found, .. } = entries[index];
    let site = study.bounds.inside(&site)?;
    let agreement = |found: &Refinement| {
        let more = found.value - value;
        let is_close = more <= SAME_VALUE * value.abs() || study.is_zero(more);
        match (is_close, study.is_same_place(&found.site, &site)) {
            (true, true) => Agreement::Same,
            (true, false) => Agreement::Elsewhere,
            _ => Agreement::Worse,
        }
    };
    Some(Best { entry: index, site, value, found, agreement: refinements.iter().map(agreement).collect() })
}

/// Named places, the best of the sweep and the ends of the refinements, each once; best first.
pub(super) fn entries(
    evaluator: &Evaluator,
    study: &PlacementStudy,
    work: &Work,
    (cells, ranking, refinements): (&[Cell], &[usize], &[Refinement]),
) -> Vec<Entry> {
    let mut places: Vec<(String, Found, Site)> =
        study.candidates.iter().map(|c| (c.name.clone(), Found::Named, c.site)).collect();
    places.extend(ranking.first().map(|&index| (BEST_OF_SWEEP.into(), Found::Sweep, cells[index].site)));
    for (index, refinement) in distinct(study, refinements) {
        // One that gained nothing on a named place is that place.
        let is_named = |candidate: &super::Candidate| study.bounds.inside(&candidate.site) == Some(refinement.site);
        if !study.candidates.iter().any(is_named) {
            places.push((format!("{OPTIMISED}{}", index + 1), Found::Refinement(index), refinement.site));
        }
    }
    let entry = |(number, (name, found, site)): (usize, (String, Found, Site))| {
        let outcome = evaluator.examine_kept(&work.shard(number), &site);
        let value = outcome.as_ref().map_or(f64::INFINITY, |evaluation| study.objective.value(&evaluation.metrics));
        let turns = evaluator.turns_of(&site);
        Entry { name, found, site, turns, outcome, value }
    };
    let mut entries: Vec<Entry> = places.into_par_iter().enumerate().map(entry).collect();
    // A stable sort: of equal ones, the named one first.
    entries.sort_by(|a, b| {
        let cannot = |entry: &Entry| entry.feasible().is_none();
        cannot(a).cmp(&cannot(b)).then(a.value.total_cmp(&b.value))
    });
    entries
}

/// Refinements whose ends are not those of better ones.
fn distinct<'a>(study: &PlacementStudy, refinements: &'a [Refinement]) -> Vec<(usize, &'a Refinement)> {
    let mut sorted: Vec<(usize, &Refinement)> = refinements.iter().enumerate().collect();
    sorted.sort_by(|a, b| a.1.value.total_cmp(&b.1.value));
    let mut distinct: Vec<(usize, &Refinement)> = Vec::new();
    for (index, refinement) in sorted {
        if !distinct.iter().any(|(_, other)| study.is_same_place(&other.site, &refinement.site)) {
            distinct.push((index, refinement));
        }
    }
    distinct
}
