//! Every place of a grid, evaluated coarse to fine.
//!
//! All places go through the levels of the paths together. After each level the most promising ones are evaluated to the
//! end; a place is given up as soon as the best it can still be ([`Evaluator::outlook`]) is worse than what as many
//! places as starts are chosen from ([`starts`]) have been found to be, and worse in one and no better in any metric of
//! the Pareto front than a place that is known. Whether the workpiece could be cut at a place given up was not asked at all of its points.
//! What is given up can therefore neither win, nor be refined, nor lie on the front. Which
//! places those are does not depend on the number of threads.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::{
    PlacementStudy,
    evaluate::{Evaluator, Partial},
    front::dominates,
    metric::Metrics,
    site::Site,
};
use crate::{
    input::error,
    simulation::Failure,
    work::{Event, Work, this_shard},
};

/// What became of a place.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Verdict {
    /// Evaluated on all points.
    Complete(Metrics),
    /// Given up after some levels; the metrics are no better than these, if it can be cut there at all.
    Pruned(Metrics),
    /// The workpiece cannot be cut there.
    Infeasible(Failure),
}

/// A place of the sweep.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Cell {
    /// Where.
    pub site: Site,
    /// What became of it.
    pub verdict: Verdict,
}

impl Cell {
    /// Its metrics, exact or as far as they are known.
    pub fn metrics(&self) -> Option<&Metrics> {
        match &self.verdict {
            Verdict::Complete(metrics) | Verdict::Pruned(metrics) => Some(metrics),
            Verdict::Infeasible(_) => None,
        }
    }

    /// Its metrics, if it was evaluated on all points.
    pub fn complete(&self) -> Option<&Metrics> {
        match &self.verdict {
            Verdict::Complete(metrics) => Some(metrics),
            _ => None,
        }
    }
}

#[derive(Debug, Clone, Serialize, Deserialize)]
enum State {
    Open(Partial),
    Closed(Verdict),
}

impl State {
    fn is_closed(&self) -> bool {
        matches!(self, State::Closed(_))
    }
}

/// States of a piece.
const PIECE: usize = 16;

/// Pieces of a level.
pub(super) fn pieces(study: &PlacementStudy) -> usize {
    study.grid.len().div_ceil(PIECE)
}

/// The cells of the study's grid, in its order.
///
/// # Errors
/// Of `work`.
pub(super) fn sweep(evaluator: &Evaluator, study: &PlacementStudy, work: &Work) -> error::Result<Vec<Cell>> {
    let sites: Vec<Site> = (0..study.grid.len()).map(|index| study.grid.site(index)).collect();
    let open = |site: &Site| match evaluator.open(site) {
        Ok(partial) => State::Open(partial),
        Err(failure) => closed(Verdict::Infeasible(failure), work),
    };
    let mut states: Vec<State> = sites.par_iter().map(open).collect();
    for level in 0..evaluator.levels {
        each(&mut states, &work.part(&format!("level {level}")), |state| advance(evaluator, state, work))?;
        if study.search.coarse_to_fine {
            work.barrier()?;
            complete_best(evaluator, study, &mut states, &work.part(&format!("best of level {level}")))?;
            work.barrier()?;
            give_up(evaluator, study, &mut states, work);
        }
    }
    each(&mut states, &work.part("rest"), |state| complete(evaluator, state, work))?;
    work.barrier()?;
    let verdict = |(site, state)| match state {
        State::Closed(verdict) => Cell { site, verdict },
        // No state is open once all are complete.
        State::Open(partial) => Cell { site, verdict: Verdict::Pruned(evaluator.outlook(&partial)) },
    };
    Ok(sites.into_iter().zip(states).map(verdict).collect())
}

/// Does `step` to each open state, in pieces of `work`; those of other parts stay as they are.
fn each(states: &mut [State], work: &Work, step: impl Fn(&mut State) + Sync) -> error::Result<()> {
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
            let after = this_shard(work.piece(&piece, |after: &Vec<State>| count(after) - before, stepped))?;
            after.iter().for_each(|after| states.clone_from_slice(after));
            Ok(())
        },
    )
}

fn closed(verdict: Verdict, work: &Work) -> State {
    work.tell(Event::Computed(1));
    State::Closed(verdict)
}

fn advance(evaluator: &Evaluator, state: &mut State, work: &Work) {
    if let State::Open(partial) = state
        && let Err(failure) = evaluator.advance(partial)
    {
        *state = closed(Verdict::Infeasible(failure), work);
    }
}

fn complete(evaluator: &Evaluator, state: &mut State, work: &Work) {
    if let State::Open(partial) = state {
        let verdict = match evaluator.complete(partial.clone()) {
            Ok(evaluation) => Verdict::Complete(evaluation.metrics),
            Err(failure) => Verdict::Infeasible(failure),
        };
        *state = closed(verdict, work);
    }
}

/// Completes the open states that look best, as many as starts are chosen from.
fn complete_best(
    evaluator: &Evaluator,
    study: &PlacementStudy,
    states: &mut [State],
    work: &Work,
) -> error::Result<()> {
    let mut looks: Vec<(f64, usize)> = states
        .iter()
        .enumerate()
        .filter_map(|(index, state)| match state {
            State::Open(partial) => Some((study.objective.value(&evaluator.outlook(partial)), index)),
            State::Closed(_) => None,
        })
        .collect();
    looks.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let mut ranks = vec![None; states.len()];
    looks.iter().take(pool(study)).enumerate().for_each(|(rank, (_, index))| ranks[*index] = Some(rank));
    let best = states.par_iter_mut().enumerate().filter_map(|(index, state)| Some((ranks[index]?, index, state)));
    best.try_for_each(|(rank, index, state)| {
        let completed = || {
            let mut state = state.clone();
            complete(evaluator, &mut state, work);
            Ok(state)
        };
        let after = this_shard(work.shard(rank).piece(&index, |_| 1, completed))?;
        after.into_iter().for_each(|after| *state = after);
        Ok(())
    })
}

/// Closes the open states that cannot be wanted any more.
fn give_up(evaluator: &Evaluator, study: &PlacementStudy, states: &mut [State], work: &Work) {
    let known: Vec<Metrics> = states
        .iter()
        .filter_map(|state| match state {
            State::Closed(Verdict::Complete(metrics)) => Some(*metrics),
            _ => None,
        })
        .collect();
    let mut values: Vec<f64> = known.iter().map(|metrics| study.objective.value(metrics)).collect();
    values.sort_by(f64::total_cmp);
    let Some(&threshold) = values.get(pool(study) - 1) else { return };
    let pareto = &study.objective.pareto;
    for state in states {
        let State::Open(partial) = state else { continue };
        let outlook = evaluator.outlook(partial);
        let is_off_front = pareto.is_empty() || known.iter().any(|metrics| dominates(metrics, &outlook, pareto));
        if study.objective.value(&outlook) > threshold && is_off_front {
            *state = closed(Verdict::Pruned(outlook), work);
        }
    }
}

/// Indices of the cells that can be cut, best first: those evaluated on all points by their value, then those given up
/// by the best they could be; equal ones in grid order.
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

/// Starts are chosen from so many times as many of the best places.
const CHOICE: usize = 4;

/// Number of best places that starts are chosen from.
fn pool(study: &PlacementStudy) -> usize {
    CHOICE * study.search.starts
}

/// Indices of the cells that refinements start from: the best ones no two of which are neighbours on the grid, or else
/// the best ones; of those known exactly, best first.
pub(super) fn starts(study: &PlacementStudy, cells: &[Cell], ranking: &[usize]) -> Vec<usize> {
    let pool: Vec<usize> =
        ranking.iter().copied().filter(|&index| cells[index].complete().is_some()).take(pool(study)).collect();
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

/// Whether two places are neighbours on the study's grid.
pub(super) fn is_neighbour(study: &PlacementStudy, a: &Site, b: &Site) -> bool {
    let bounds = &study.bounds;
    let close = |i: usize| bounds.distance(i, a.0[i], b.0[i]) <= NEXT * study.grid.step(i, bounds);
    bounds.free().into_iter().all(close)
}

/// Places at most so many steps apart along every coordinate are neighbours.
const NEXT: f64 = 1.5;
