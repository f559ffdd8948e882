//! Sweep: every place of a grid, evaluated coarse to fine, with pruning of places that cannot win.
//!
//! All places go through the levels of the paths together. After each level the most promising ones are evaluated on all points. A place is
//! pruned as soon as its best possible objective ([`Evaluator::best_possible`]) is worse than that of all places from which starts are
//! chosen ([`choose_starts`]), and a place evaluated in full dominates it in the metrics of the Pareto front, if one is asked for. So no
//! pruned place can win, be a start, or lie on the front, on any number of threads. Whether the workpiece can be cut there is not known.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::{
    PlacementStudy,
    evaluate::{Evaluator, PartialEvaluation},
    front::dominates,
    metric::Metrics,
    site::Site,
};
use crate::{
    input::error,
    simulation::Failure,
    work::{Event, Work, if_this_shard},
};

/// Outcome of the evaluation of a place of the sweep.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum PlaceOutcome {
    /// Evaluated on all points.
    Complete(Metrics),
    /// Pruned after some levels; the metrics are no better than these, if the workpiece can be cut there at all.
    Pruned(Metrics),
    /// The workpiece cannot be cut there.
    Infeasible(Failure),
}

/// A grid point of the sweep and its outcome.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Cell {
    /// The place.
    pub site: Site,
    /// Its outcome.
    pub verdict: PlaceOutcome,
}

impl Cell {
    /// Returns its metrics, or their bounds if it was pruned; `None` where the workpiece cannot be cut.
    pub fn metrics(&self) -> Option<&Metrics> {
        match &self.verdict {
            PlaceOutcome::Complete(metrics) | PlaceOutcome::Pruned(metrics) => Some(metrics),
            PlaceOutcome::Infeasible(_) => None,
        }
    }

    /// Returns its metrics, if it was evaluated on all points.
    pub fn complete(&self) -> Option<&Metrics> {
        match &self.verdict {
            PlaceOutcome::Complete(metrics) => Some(metrics),
            _ => None,
        }
    }
}

/// Progress of a place during the sweep.
#[derive(Debug, Clone, Serialize, Deserialize)]
enum State {
    Open(PartialEvaluation),
    Closed(Box<PlaceOutcome>),
}

impl State {
    /// Returns whether the evaluation of the place has ended with a verdict.
    fn is_closed(&self) -> bool {
        matches!(self, State::Closed(_))
    }
}

/// Number of places in a piece of work.
const PIECE: usize = 16;

/// Returns the number of pieces of a level.
pub(super) fn piece_count(study: &PlacementStudy) -> usize {
    study.grid.len().div_ceil(PIECE)
}

/// Evaluates the grid of the study, and returns its cells in grid order. `Err` only from `work`.
pub(super) fn sweep(evaluator: &Evaluator, study: &PlacementStudy, work: &Work) -> error::Result<Vec<Cell>> {
    let sites: Vec<Site> = (0..study.grid.len()).map(|index| study.grid.site(index)).collect();
    let verdicts = work.summary("verdicts", || {
        let mut states = states_before_level(evaluator, study, &sites, evaluator.levels, work)?;
        step_open_states(&mut states, &work.part("rest"), |state| complete(evaluator, state, work))?;
        work.barrier()?;
        let verdict = |state| match state {
            State::Closed(verdict) => *verdict,
            // No state is open once all are complete.
            State::Open(partial) => PlaceOutcome::Pruned(evaluator.best_possible(&partial)),
        };
        Ok(states.into_iter().map(verdict).collect::<Vec<_>>())
    })?;
    Ok(sites.into_iter().zip(verdicts).map(|(site, verdict)| Cell { site, verdict }).collect())
}

/// Returns the states of all `sites` after the levels before `level`, pruned after each if the study says so. `Err` only from `work`.
fn states_before_level(
    evaluator: &Evaluator,
    study: &PlacementStudy,
    sites: &[Site],
    level: usize,
    work: &Work,
) -> error::Result<Vec<State>> {
    let open = |site: &Site| match evaluator.begin_evaluation(site) {
        Ok(partial) => State::Open(partial),
        Err(failure) => closed_state(PlaceOutcome::Infeasible(failure), work),
    };
    let Some(last) = level.checked_sub(1) else {
        return sites.par_iter().map(|site| work.check().map(|()| open(site))).collect();
    };
    let advanced = || {
        let mut states = states_before_level(evaluator, study, sites, last, work)?;
        step_open_states(&mut states, &work.part(&format!("level {last}")), |state| advance(evaluator, state, work))?;
        Ok(states)
    };
    if !study.search.coarse_to_fine {
        return advanced();
    }
    work.summary(&format!("pruned after level {last}"), || {
        let mut states = work.summary(&format!("after level {last}"), advanced)?;
        work.barrier()?;
        complete_best(evaluator, study, &mut states, &work.part(&format!("best of level {last}")))?;
        work.barrier()?;
        prune(evaluator, study, &mut states, work);
        Ok(states)
    })
}

/// Applies `step` to each open state, in pieces of `work`, those of other shards left as they are. `Err` only from `work`.
fn step_open_states(states: &mut [State], work: &Work, step: impl Fn(&mut State) + Sync) -> error::Result<()> {
    states.par_chunks_mut(PIECE).enumerate().filter(|(_, states)| !states.iter().all(State::is_closed)).try_for_each(
        |(piece, states)| {
            let work = work.shard(piece);
            let count = |states: &[State]| states.iter().filter(|state| state.is_closed()).count();
            let before = count(states);
            let stepped = || {
                let mut states = states.to_vec();
                for state in &mut states {
                    work.check()?;
                    step(state);
                }
                Ok(states)
            };
            let after = if_this_shard(work.piece(&piece, |after: &Vec<State>| count(after) - before, stepped))?;
            after.iter().for_each(|after| states.clone_from_slice(after));
            Ok(())
        },
    )
}

/// Returns the state of a place that has its verdict, and reports the place to `work` as computed.
fn closed_state(verdict: PlaceOutcome, work: &Work) -> State {
    work.tell(Event::Computed(1));
    State::Closed(Box::new(verdict))
}

/// Evaluates the next level of an open state; closes it if the workpiece cannot be cut there.
fn advance(evaluator: &Evaluator, state: &mut State, work: &Work) {
    if let State::Open(partial) = state
        && let Err(failure) = evaluator.advance(partial)
    {
        *state = closed_state(PlaceOutcome::Infeasible(failure), work);
    }
}

/// Evaluates an open state on all points and closes it.
fn complete(evaluator: &Evaluator, state: &mut State, work: &Work) {
    if let State::Open(partial) = state {
        let verdict = match evaluator.complete(partial.clone()) {
            Ok(evaluation) => PlaceOutcome::Complete(evaluation.metrics),
            Err(failure) => PlaceOutcome::Infeasible(failure),
        };
        *state = closed_state(verdict, work);
    }
}

/// Evaluates on all points the [`start_pool`] open states of the best outlook, to prune the others by. `Err` only from `work`.
fn complete_best(
    evaluator: &Evaluator,
    study: &PlacementStudy,
    states: &mut [State],
    work: &Work,
) -> error::Result<()> {
    let mut outlooks: Vec<(f64, usize)> = states
        .iter()
        .enumerate()
        .filter_map(|(index, state)| match state {
            State::Open(partial) => Some((study.objective.value(&evaluator.best_possible(partial)), index)),
            State::Closed(_) => None,
        })
        .collect();
    outlooks.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let mut ranks = vec![None; states.len()];
    outlooks.iter().take(start_pool(study)).enumerate().for_each(|(rank, (_, index))| ranks[*index] = Some(rank));
    let best = states.par_iter_mut().enumerate().filter_map(|(index, state)| Some((ranks[index]?, index, state)));
    best.try_for_each(|(rank, index, state)| {
        let completed = || {
            let mut state = state.clone();
            complete(evaluator, &mut state, work);
            Ok(state)
        };
        let after = if_this_shard(work.shard(rank).piece(&index, |_| 1, completed))?;
        after.into_iter().for_each(|after| *state = after);
        Ok(())
    })
}

/// Prunes the open states that can neither be a start of a refinement nor lie on the Pareto front.
fn prune(evaluator: &Evaluator, study: &PlacementStudy, states: &mut [State], work: &Work) {
    let known: Vec<Metrics> = states
        .iter()
        .filter_map(|state| match state {
            State::Closed(verdict) => match **verdict {
                PlaceOutcome::Complete(metrics) => Some(metrics),
                _ => None,
            },
            State::Open(_) => None,
        })
        .collect();
    let mut values: Vec<f64> = known.iter().map(|metrics| study.objective.value(metrics)).collect();
    values.sort_by(f64::total_cmp);
    let Some(&threshold) = values.get(start_pool(study) - 1) else { return };
    let pareto = &study.objective.pareto;
    for state in states {
        let State::Open(partial) = state else { continue };
        let outlook = evaluator.best_possible(partial);
        let is_off_front = pareto.is_empty() || known.iter().any(|metrics| dominates(metrics, &outlook, pareto));
        if study.objective.value(&outlook) > threshold && is_off_front {
            *state = closed_state(PlaceOutcome::Pruned(outlook), work);
        }
    }
}

/// Returns the indices of the cells that can be cut, best first: those evaluated on all points, then the pruned ones by their bounds.
pub(super) fn ranking(study: &PlacementStudy, cells: &[Cell]) -> Vec<usize> {
    let mut ranked: Vec<(bool, f64, usize)> = cells
        .iter()
        .enumerate()
        .filter_map(|(index, cell)| {
            let value = study.objective.value(cell.metrics()?);
            Some((cell.complete().is_none(), value, index))
        })
        .collect();
    ranked.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)).then(a.2.cmp(&b.2)));
    ranked.into_iter().map(|(_, _, index)| index).collect()
}

/// Number of best places per start from which starts are chosen.
const CHOICE: usize = 4;

/// Returns how many best places of the sweep the starts of refinements are chosen from.
fn start_pool(study: &PlacementStudy) -> usize {
    CHOICE * study.search.starts
}

/// Returns the indices of the cells that refinements start from, best first; neighbours on the grid only where there are too few others.
pub(super) fn choose_starts(study: &PlacementStudy, cells: &[Cell], ranking: &[usize]) -> Vec<usize> {
    let pool: Vec<usize> =
        ranking.iter().copied().filter(|&index| cells[index].complete().is_some()).take(start_pool(study)).collect();
    let mut chosen: Vec<usize> = Vec::new();
    for &index in &pool {
        if !chosen.iter().any(|&other| is_neighbour(study, &cells[other].site, &cells[index].site)) {
            chosen.push(index);
        }
    }
    let others: Vec<usize> = pool.into_iter().filter(|index| !chosen.contains(index)).collect();
    chosen.extend(others);
    chosen.truncate(study.search.starts);
    chosen
}

/// Returns whether two places are neighbours on the study's grid.
pub(super) fn is_neighbour(study: &PlacementStudy, a: &Site, b: &Site) -> bool {
    let bounds = &study.bounds;
    let close = |i: usize| bounds.distance(i, a.0[i], b.0[i]) <= NEXT * study.grid.step(i, bounds);
    bounds.free().into_iter().all(close)
}

/// Largest distance between neighbours along every coordinate, in steps of the grid.
const NEXT: f64 = 1.5;
