//! Sequential convex programming: linearise the path, solve the convex program, go there as far as the nonlinear simulation confirms.

use super::{
    BoundedSettings, ErrorNorm,
    error::BoundedError,
    limits::{Bounds, LimitKind, Limits},
    outcome::{BoundedStatus, Errors},
    path::{Point, Simulation, Simulator},
    program::{ConvexSolution, LinearisedPath, Multiplier, NoSolution, Objective, motion_per_mm},
};
use crate::machine::{Machine, Motion};

/// Steps are halved this many times before a direction is given up.
const HALVINGS: usize = 10;
/// Share by which the second stage of the worst error may exceed the first's: interior points need it to be inside.
const STAGE_SLACK: f64 = 2e-5;
/// An improvement by less than this share is none.
const IMPROVEMENT: f64 = 1e-9;
/// Errors that are equal to this length are equal, mm.
const SAME_LENGTH: f64 = 1e-8;
/// A linearisation that promises to improve the errors by less than this share is not worth following.
const PROMISE: f64 = 1e-5;
/// Steps for the sake of forces move the tool by at most this share of the machine's characteristic length: beyond, the linearisation says
/// little. They can be long, because forces depend little on where the tool is.
const LONGEST_STEP: f64 = 0.1;

/// Corrections of all points, and the simulated machine there.
#[derive(Debug, Clone)]
pub(super) struct Iterate {
    /// Δρ, point-major, mm or rad.
    pub corrections: Vec<f64>,
    pub results: Vec<Simulation>,
    pub errors: Errors,
    /// Largest excess of a force over its limit, as a share of the limit.
    pub excess: f64,
}

/// Result of a search.
pub(super) struct SearchResult {
    pub iterate: Iterate,
    pub status: BoundedStatus,
    pub binding: Vec<Multiplier>,
    pub iterations: usize,
    pub convex_iterations: usize,
    pub is_accurate: bool,
}

/// Inputs of a search for bounded corrections.
pub(super) struct Search<'a, 'm> {
    pub points: &'a [Point],
    pub limits: &'a Limits,
    pub bounds: &'a Bounds,
    pub machine: &'m Machine,
    pub simulator: &'a mut Simulator,
    pub objective: ErrorNorm,
    /// Largest error allowed, mm, while the root mean square is the objective.
    pub largest: Option<f64>,
    pub settings: &'a BoundedSettings,
    pub progress: &'a dyn Fn(usize),
}

impl Search<'_, '_> {
    /// Finds the corrections of least objective within the limits; `Err` if a force limit cannot be kept or the convex solver fails.
    pub fn run(&mut self) -> Result<SearchResult, BoundedError> {
        let start = self.start_within_limits()?;
        match start.status {
            BoundedStatus::Unbounded => Ok(start),
            _ => self.run_from(start),
        }
    }

    /// Searches from no correction with errors up to `largest`, mm; `None` if the uncorrected path breaks a limit or has a larger error.
    pub fn run_below(&mut self, largest: f64) -> Result<Option<SearchResult>, BoundedError> {
        let unbounded = self.unbounded_iterate();
        let zero = vec![0.0; unbounded.corrections.len()];
        let mut projected = zero.clone();
        self.bounds.project(&mut projected);
        if projected != zero {
            return Ok(None);
        }
        let Ok(start) = self.simulate(zero, &unbounded) else { return Ok(None) };
        if start.excess > self.settings.force_tolerance || start.errors.worst > largest {
            return Ok(None);
        }
        self.largest = Some(largest);
        self.run_from(initial_result(start, BoundedStatus::Slow)).map(Some)
    }

    /// Iterates from `result` until the search converges, stalls or has no iterations left; `Err` if a force limit cannot be kept.
    fn run_from(&mut self, mut result: SearchResult) -> Result<SearchResult, BoundedError> {
        while result.iterations < self.settings.max_iterations {
            result.iterations += 1;
            let is_over = self.iterate_once(&mut result)?;
            if let Some(status) = is_over {
                result.status = status;
                break;
            }
        }
        if result.iterate.excess > self.settings.force_tolerance {
            return Err(self.force_error(&result.iterate));
        }
        self.take_exact_points(&mut result.iterate);
        Ok(result)
    }

    /// Iterate at the unbounded corrections, zero at points that have none; it may break the limits.
    fn unbounded_iterate(&self) -> Iterate {
        let starts: Vec<&Simulation> = self.points.iter().filter_map(Point::best_start).collect();
        let corrections = self.points.iter().zip(&starts).flat_map(|(point, result)| point.corrections(&result.drives));
        let excess = self.bounds.force_excess(starts.iter().map(|result| result.forces.as_slice()));
        new_iterate(corrections.collect(), starts.into_iter().cloned().collect(), excess)
    }

    /// Start at the unbounded corrections projected into the limits on correction, travel and change, or at zero ones if these fail.
    fn start_within_limits(&mut self) -> Result<SearchResult, BoundedError> {
        let unbounded = self.unbounded_iterate();
        let mut corrections = unbounded.corrections.clone();
        self.bounds.project(&mut corrections);
        let is_exact = self.points.iter().all(|point| point.exact.is_some());
        let (is_inside, keeps_forces) = (corrections == unbounded.corrections, unbounded.excess <= 0.0);
        let mut zero = vec![0.0; corrections.len()];
        let start = match self.simulate(corrections, &unbounded) {
            Ok(start) => start,
            Err(_) => {
                self.bounds.project(&mut zero);
                self.simulate(zero, &unbounded)?
            }
        };
        let is_unbounded = is_exact && is_inside && keeps_forces;
        Ok(initial_result(start, if is_unbounded { BoundedStatus::Unbounded } else { BoundedStatus::Slow }))
    }

    /// Simulates the path at `corrections` (point-major, mm or rad), each point near its equilibrium in `near`; `Err` if one has none.
    fn simulate(&mut self, corrections: Vec<f64>, near: &Iterate) -> Result<Iterate, BoundedError> {
        let count = self.bounds.drive_count();
        let mut results = Vec::with_capacity(self.points.len());
        for (k, (point, correction)) in self.points.iter().zip(corrections.chunks_exact(count)).enumerate() {
            let old = &near.results[k];
            // Points that stay where they are need no new simulation.
            if near.corrections[k * count..(k + 1) * count] == *correction {
                results.push(old.clone());
                continue;
            }
            let drives: Vec<f64> = point.command.drives.iter().zip(correction).map(|(rho, u)| rho + u).collect();
            let result = self.simulator.simulate(point, &drives, &old.state);
            results.push(result.map_err(|status| BoundedError::Start { point: self.bounds.index[k], status })?);
            (self.progress)(k + 1);
        }
        let excess = self.bounds.force_excess(results.iter().map(|result| result.forces.as_slice()));
        Ok(new_iterate(corrections, results, excess))
    }

    /// Linearises the path at `result` and steps once; returns the final status if the search is over, `None` to go on.
    fn iterate_once(&mut self, result: &mut SearchResult) -> Result<Option<BoundedStatus>, BoundedError> {
        let now = &result.iterate;
        let mut bounds = self.bounds.clone();
        if bounds.has_force_limits() {
            self.narrow_to_trusted(&mut bounds, now);
        }
        let program = LinearisedPath::new(&now.results, &now.corrections, &bounds);
        let solution = match self.solve_objective(&program) {
            Ok(solution) => Some(solution),
            // There are none with smaller errors than those reached, or none that can be told from them.
            Err(_) if self.largest.is_some() => return Ok(Some(BoundedStatus::Stalled)),
            Err(NoSolution::Infeasible) if self.bounds.has_force_limits() => None,
            Err(NoSolution::Infeasible) => return Err(BoundedError::Convex { status: "PrimalInfeasible".into() }),
            // What has been reached keeps all limits.
            Err(NoSolution::Other(_)) if result.iterations > 1 && now.excess <= self.settings.force_tolerance => {
                return Ok(Some(BoundedStatus::Stalled));
            }
            Err(NoSolution::Other(status)) => return Err(BoundedError::Convex { status }),
        };
        if let Some(solved) = solution {
            result.convex_iterations += solved.iterations;
            result.is_accurate &= solved.is_accurate;
            let predicted = program.errors_after(&solved.step);
            let next = self.step_along(&solved.step, now);
            result.binding = solved.binding;
            let keeps_forces = now.excess <= self.settings.force_tolerance;
            match next {
                Some(next) => {
                    let is_over = keeps_forces && !self.improves(&next, now);
                    result.iterate = next;
                    return Ok(is_over.then_some(BoundedStatus::Converged));
                }
                None if keeps_forces && self.is_promising(&predicted, &result.iterate.errors) => {
                    return Ok(Some(BoundedStatus::Stalled));
                }
                None if keeps_forces => return Ok(Some(BoundedStatus::Converged)),
                None => {}
            }
        }
        // The force limits cannot be kept within the linearisation, or not by going to its solution: forces first.
        let solved = program.solve(Objective::Excess).map_err(convex_error)?;
        result.convex_iterations += solved.iterations;
        match self.step_along(&solved.step, &result.iterate) {
            Some(next) => result.iterate = next,
            None => return Err(self.force_error(&result.iterate)),
        }
        Ok(None)
    }

    /// Solves the program for the objective. The worst error is found first and then, with it given, the least sum of squares: so the
    /// points that are not the worst are as good as they can be, and the solution is unique.
    fn solve_objective(&self, program: &LinearisedPath<'_>) -> Result<ConvexSolution, NoSolution> {
        match self.objective {
            ErrorNorm::Rms => match self.largest {
                Some(largest) => program.solve(Objective::Within(largest * (1.0 - STAGE_SLACK))),
                None => program.solve(Objective::Squares),
            },
            ErrorNorm::Worst => {
                let first = program.solve(Objective::Largest)?;
                let within = first.extra * (1.0 + STAGE_SLACK) + SAME_LENGTH;
                Ok(match program.solve(Objective::Within(within)) {
                    Ok(second) => with_first_prices(second, first),
                    // What the first stage found is right; its best points may be less good than they could be.
                    Err(_) => first,
                })
            }
        }
    }

    /// Halves the step until an iterate is better than `now`; `None` if none is.
    fn step_along(&mut self, step: &[f64], now: &Iterate) -> Option<Iterate> {
        let mut share = 1.0;
        for _ in 0..HALVINGS {
            let moved = now.corrections.iter().zip(step).map(|(u, d)| u + share * d);
            let mut corrections: Vec<f64> = moved.collect();
            self.bounds.project(&mut corrections);
            if let Ok(next) = self.simulate(corrections, now)
                && self.is_better(&next, now)
            {
                return Some(next);
            }
            share *= 0.5;
        }
        None
    }

    /// Whether `next` is better than `now`: forces nearer to their limits first, then smaller errors within them.
    fn is_better(&self, next: &Iterate, now: &Iterate) -> bool {
        let tolerance = self.settings.force_tolerance;
        if now.excess > tolerance {
            return next.excess <= tolerance || next.excess < (1.0 - 1e-3) * now.excess;
        }
        let (new, old) = (&next.errors, &now.errors);
        next.excess <= tolerance
            && self.largest.is_none_or(|largest| new.worst <= largest)
            && match self.objective {
                ErrorNorm::Rms => new.rms < old.rms,
                // Within what the second stage gives away, the sum of squares decides.
                ErrorNorm::Worst => {
                    let given_away = 2.0 * (STAGE_SLACK * old.worst + SAME_LENGTH);
                    new.worst < old.worst - given_away || (new.worst < old.worst + given_away && new.rms < old.rms)
                }
            }
    }

    /// Whether `next` is better than `now` by more than rounding.
    fn improves(&self, next: &Iterate, now: &Iterate) -> bool {
        let rms = is_less(next.errors.rms, now.errors.rms, IMPROVEMENT);
        match self.objective {
            ErrorNorm::Rms => rms,
            ErrorNorm::Worst => rms || is_less(next.errors.worst, now.errors.worst, STAGE_SLACK),
        }
    }

    /// Whether the errors `promised` by a linearisation are better than those `now` by an amount that matters.
    fn is_promising(&self, promised: &Errors, now: &Errors) -> bool {
        match self.objective {
            ErrorNorm::Rms => is_less(promised.rms, now.rms, PROMISE),
            ErrorNorm::Worst => is_less(promised.worst, now.worst, 2.0 * STAGE_SLACK),
        }
    }

    /// Replaces the corrections of a point by its unbounded ones where the limits and its neighbours allow: its error vanishes, nothing
    /// else changes. What the convex solver left there is its tolerance.
    fn take_exact_points(&mut self, iterate: &mut Iterate) {
        let count = self.bounds.drive_count();
        for k in (0..self.points.len()).chain((0..self.points.len()).rev()) {
            let point = &self.points[k];
            let Some(exact) = &point.exact else { continue };
            let correction: Vec<f64> = point.corrections(&exact.drives).collect();
            let keeps_forces = self.bounds.force_excess(std::iter::once(exact.forces.as_slice())) <= 0.0;
            if keeps_forces && self.bounds.allows(k, &correction, &iterate.corrections) {
                iterate.corrections[k * count..(k + 1) * count].copy_from_slice(&correction);
                iterate.results[k] = exact.clone();
            }
        }
        iterate.errors = Errors::from_lengths(iterate.results.iter().map(|result| result.error.norm()));
        iterate.excess = self.bounds.force_excess(iterate.results.iter().map(|result| result.forces.as_slice()));
    }

    /// Narrows `bounds` to where the linearisation at `now` can be trusted.
    fn narrow_to_trusted(&self, bounds: &mut Bounds, now: &Iterate) {
        let length = LONGEST_STEP * self.machine.characteristic_length;
        let steps: Vec<f64> = (0..bounds.drive_count()).map(|i| length * motion_per_mm(&now.results, i)).collect();
        bounds.narrow(&now.corrections, &steps);
    }

    /// Error that names the force most above its limit, and the kinds of limits without which it could be kept.
    fn force_error(&self, iterate: &Iterate) -> BoundedError {
        let shares = iterate.results.iter().enumerate().flat_map(|(k, result)| {
            let forces = result.forces.iter().zip(&self.bounds.force).enumerate();
            forces.map(move |(i, (force, limit))| (k, i, force.abs() / limit))
        });
        let (k, i, _) = shares.max_by(|a, b| a.2.total_cmp(&b.2)).unwrap_or((0, 0, 0.0));
        let kinds = [LimitKind::Correction, LimitKind::Travel, LimitKind::Change];
        let motion = self.machine.drives().nth(i).map_or(Motion::Prismatic, |(_, drive)| drive.motion);
        BoundedError::Force {
            drive: self.machine.drive_labels()[i].clone(),
            point: self.bounds.index[k],
            least: iterate.results[k].forces[i].abs(),
            limit: self.bounds.force[i],
            unit: motion.shown_force_unit(),
            conflicts: kinds.into_iter().filter(|kind| self.forces_kept_without(*kind, iterate)).collect(),
        }
    }

    /// Whether a moderate step, by linear sensitivities, would keep the force limits without the limits of `kind`.
    fn forces_kept_without(&self, kind: LimitKind, iterate: &Iterate) -> bool {
        let mut limits = self.limits.clone();
        match kind {
            LimitKind::Correction if limits.correction.is_some() => limits.correction = None,
            LimitKind::Change if limits.correction_change.is_some() => limits.correction_change = None,
            LimitKind::Travel => {
                limits.travel = Some(vec![(f64::NEG_INFINITY, f64::INFINITY); self.bounds.drive_count()]);
            }
            _ => return false,
        }
        let nominal: Vec<&[f64]> = self.points.iter().map(|point| point.command.drives.as_slice()).collect();
        let Ok(mut bounds) = Bounds::new(&limits, self.machine, self.bounds.index.clone(), &nominal) else {
            return false;
        };
        if bounds.range == self.bounds.range && bounds.change == self.bounds.change {
            return false;
        }
        self.narrow_to_trusted(&mut bounds, iterate);
        let program = LinearisedPath::new(&iterate.results, &iterate.corrections, &bounds);
        program.solve(Objective::Excess).is_ok_and(|solved| solved.extra <= self.settings.force_tolerance)
    }
}

/// Result of a search before its first step: `start`, with no limits known to bind.
fn initial_result(start: Iterate, status: BoundedStatus) -> SearchResult {
    SearchResult { iterate: start, status, binding: Vec::new(), iterations: 0, convex_iterations: 0, is_accurate: true }
}

/// Iterate of these corrections, with the errors of its simulations.
fn new_iterate(corrections: Vec<f64>, results: Vec<Simulation>, excess: f64) -> Iterate {
    let errors = Errors::from_lengths(results.iter().map(|result| result.error.norm()));
    Iterate { corrections, results, errors, excess }
}

/// Whether `new` is less than `old` by more than `share` of it.
fn is_less(new: f64, old: f64, share: f64) -> bool {
    new < old * (1.0 - share)
}

/// Error of a program without a solution.
fn convex_error(failure: NoSolution) -> BoundedError {
    let status = match failure {
        NoSolution::Infeasible => "PrimalInfeasible".into(),
        NoSolution::Other(status) => status,
    };
    BoundedError::Convex { status }
}

/// Solution of the second stage with the multipliers of the first: those of the worst error.
fn with_first_prices(second: ConvexSolution, first: ConvexSolution) -> ConvexSolution {
    let price = |limit| first.binding.iter().find(|m| m.limit == limit).map_or(0.0, |m| m.value);
    let mut binding: Vec<Multiplier> =
        second.binding.iter().map(|m| Multiplier { limit: m.limit, value: price(m.limit) }).collect();
    let only_first = first.binding.iter().filter(|m| !binding.iter().any(|other| other.limit == m.limit));
    let only_first: Vec<Multiplier> = only_first.copied().collect();
    binding.extend(only_first);
    ConvexSolution {
        binding,
        extra: first.extra,
        is_accurate: first.is_accurate && second.is_accurate,
        iterations: first.iterations + second.iterations,
        ..second
    }
}
