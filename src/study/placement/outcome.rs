//! What a placement study found.

use rayon::prelude::*;

use super::{
    PlacementStudy,
    evaluate::{Evaluation, Evaluator},
    flatness::Room,
    metric::{Metrics, Objective},
    pareto,
    refine::{Refinement, refine},
    site::Site,
    sweep::Cell,
    trace::Trace,
};
use crate::study::{Failure, Work};

/// Results of a placement study.
#[derive(Debug, Clone)]
pub struct PlacementResults {
    /// The study.
    pub study: PlacementStudy,
    /// The sweep, in grid order.
    pub cells: Vec<Cell>,
    /// Indices of the cells that can be cut, best first.
    pub ranking: Vec<usize>,
    /// One per start, in the order of the ranking.
    pub refinements: Vec<Refinement>,
    /// The best place; `None` if the workpiece can be cut nowhere.
    pub best: Option<Best>,
    /// How far the workpiece may be moved from there.
    pub flatness: Vec<Room>,
    /// Named and found places with all metrics, best first, those that cannot be cut last.
    pub entries: Vec<Entry>,
    /// The best compromises between the metrics asked for, by the first of them.
    pub front: Vec<(Site, Metrics)>,
    /// Paths at the best and at a poor place.
    pub traces: Vec<Trace>,
}

/// The best place and how it was found.
#[derive(Debug, Clone, PartialEq)]
pub struct Best {
    /// Where.
    pub site: Site,
    /// Objective there.
    pub value: f64,
    /// Index of the refinement that found it; `None`: it is a place of the sweep that no refinement improved.
    pub refinement: Option<usize>,
    /// What each refinement has to say to it.
    pub agreement: Vec<Agreement>,
}

/// How a refinement's end compares with the best place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Agreement {
    /// Same value, same place.
    Same,
    /// Same value at another place: the optimum is flat, or there are several.
    Elsewhere,
    /// A worse value.
    Worse,
}

/// Where an entry comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
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
#[derive(Debug, Clone, PartialEq)]
pub struct Entry {
    /// Its name.
    pub name: String,
    /// Where it comes from.
    pub found: Found,
    /// Where.
    pub site: Site,
    /// What happens there, or why it cannot be cut there.
    pub outcome: Result<Evaluation, Failure>,
    /// The objective; infinite where it cannot be cut.
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
/// Places are the same if every coordinate differs by less than this share of its range.
const SAME_PLACE: f64 = 0.02;

fn is_same_place(study: &PlacementStudy, a: &Site, b: &Site) -> bool {
    study.bounds.free().into_iter().all(|i| (a.0[i] - b.0[i]).abs() <= SAME_PLACE * study.bounds.range(i))
}

pub(super) fn best(
    study: &PlacementStudy,
    cells: &[Cell],
    ranking: &[usize],
    refinements: &[Refinement],
) -> Option<Best> {
    let cell = &cells[*ranking.first()?];
    let (mut site, mut value, mut refinement) = (cell.site, study.objective.value(cell.complete()?), None);
    for (index, found) in refinements.iter().enumerate() {
        if found.value < value {
            (site, value, refinement) = (found.site, found.value, Some(index));
        }
    }
    let agreement = |found: &Refinement| {
        let is_close = found.value - value <= SAME_VALUE * value.abs();
        match (is_close, is_same_place(study, &found.site, &site)) {
            (true, true) => Agreement::Same,
            (true, false) => Agreement::Elsewhere,
            _ => Agreement::Worse,
        }
    };
    Some(Best { site, value, refinement, agreement: refinements.iter().map(agreement).collect() })
}

/// Named places, the best of the sweep and the ends of the refinements, each once; best first.
pub(super) fn entries(
    evaluator: &Evaluator<'_>,
    study: &PlacementStudy,
    work: &Work,
    (cells, ranking, refinements): (&[Cell], &[usize], &[Refinement]),
) -> Vec<Entry> {
    let mut places: Vec<(String, Found, Site)> =
        study.candidates.iter().map(|c| (c.name.clone(), Found::Named, c.site)).collect();
    places.extend(ranking.first().map(|&index| (BEST_OF_SWEEP.into(), Found::Sweep, cells[index].site)));
    for (index, refinement) in distinct(study, refinements) {
        places.push((format!("{OPTIMISED}{}", index + 1), Found::Refinement(index), refinement.site));
    }
    let entry = |(name, found, site): (String, Found, Site)| {
        let outcome = evaluator.examine_kept(work, &site);
        let value = outcome.as_ref().map_or(f64::INFINITY, |evaluation| study.objective.value(&evaluation.metrics));
        Entry { name, found, site, outcome, value }
    };
    let mut entries: Vec<Entry> = places.into_par_iter().map(entry).collect();
    // A stable sort: of equal ones, the named one first.
    entries.sort_by(|a, b| a.value.total_cmp(&b.value));
    entries
}

/// Refinements whose ends are not those of better ones.
fn distinct<'a>(study: &PlacementStudy, refinements: &'a [Refinement]) -> Vec<(usize, &'a Refinement)> {
    let mut sorted: Vec<(usize, &Refinement)> = refinements.iter().enumerate().collect();
    sorted.sort_by(|a, b| a.1.value.total_cmp(&b.1.value));
    let mut distinct: Vec<(usize, &Refinement)> = Vec::new();
    for (index, refinement) in sorted {
        if !distinct.iter().any(|(_, other)| is_same_place(study, &other.site, &refinement.site)) {
            distinct.push((index, refinement));
        }
    }
    distinct
}

/// Refinements of each metric of the Pareto front alone: its ends.
pub(super) fn front_ends(
    evaluator: &Evaluator<'_>,
    study: &PlacementStudy,
    cells: &[Cell],
    work: &Work,
) -> Vec<Refinement> {
    let end = |metric: &super::Metric| {
        let objective = Objective { weights: vec![(*metric, 1.0)], pareto: Vec::new() };
        let complete = cells.iter().filter_map(|cell| Some((objective.value(cell.complete()?), cell.site)));
        let start = complete.min_by(|a, b| a.0.total_cmp(&b.0))?.1;
        refine(evaluator, study, &objective, &[start], work).pop()
    };
    study.objective.pareto.par_iter().filter_map(end).collect()
}

/// The places of sweep and refinements that no other dominates.
pub(super) fn front(
    study: &PlacementStudy,
    cells: &[Cell],
    refinements: &[Refinement],
    ends: &[Refinement],
) -> Vec<(Site, Metrics)> {
    let mut places: Vec<(Site, Metrics)> =
        cells.iter().filter_map(|cell| Some((cell.site, *cell.complete()?))).collect();
    for refinement in refinements.iter().chain(ends) {
        places.extend(&refinement.visited);
    }
    pareto::front(&places, &study.objective.pareto)
}
