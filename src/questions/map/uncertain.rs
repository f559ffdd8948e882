//! Spread of the deflection by all sources where inputs are uncertain: sampled from a surrogate at each grid point, checked there by draws of
//! the whole engine.

use std::sync::OnceLock;

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use super::{WorkspaceMapStudy, command_points, success_or_failure};
use crate::{
    compensation::{Method, Session, TaskPoint},
    input::error,
    machine::{Configuration, Machine},
    process::uncertainty::{Draws, P95, Quantiles, Response, Surrogate, Uncertainty, quantile},
    simulation::{Failure, Machines, Source},
    statics::Batch,
};

/// Distribution of the deflection by all sources at a grid point, worst over the tool angle φ.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DeflectionSpread {
    /// Half of the draws deflect less, mm.
    pub median_mm: f64,
    /// 95 % of the draws deflect less, mm.
    pub p95_mm: f64,
    /// Standard error of `p95_mm`: by the number of draws, and by the check where it corrected them.
    pub p95_standard_error_mm: f64,
    /// Probability that the deflection is within tolerance, 0 to 1; `None` without tolerance.
    pub within_tolerance: Option<f64>,
    /// What causes the largest part of the variance: a parameter, or "cutting force".
    pub main_cause: String,
    /// Its share of the sum of variances by each alone, 0 to 1.
    pub main_cause_share: f64,
    /// How far the engine differs from the surrogate in the draw at the 95 % quantile, as a share.
    pub check_difference: Option<f64>,
    /// Number of draws solved by the engine.
    pub solved_draws: usize,
    /// Number of those in which the machine has no equilibrium; they do not count as within tolerance.
    pub failed_draws: usize,
}

/// Largest difference of the engine from the surrogate that needs no further draws, as a share.
const CLOSE: f64 = 0.005;
/// Largest standard error of the 95 % quantile by the check, as a share.
const LARGEST_ERROR: f64 = 0.003;
/// Fewest and most draws next to the 95 % quantile by which it is corrected.
const FEWEST_NEXT: usize = 4;
const MOST_NEXT: usize = 32;
/// Fewest scrambles of which all draws are solved, where those next to the quantile do not suffice.
const FEWEST_SCRAMBLES: usize = 4;

/// What varies in a map, and the machines in which it does.
pub(super) struct Variations<'a> {
    study: &'a WorkspaceMapStudy,
    uncertainty: &'a Uncertainty,
    nominal: &'a Machines,
    /// Machines with each parameter alone at its ends ([`Response::ENDS`]), as far as they are solved.
    ends: Vec<[Option<Machines>; 2]>,
    /// Machines of the draws of the first scramble, made when they are needed.
    drawn: Vec<OnceLock<Option<Machines>>>,
}

impl<'a> Variations<'a> {
    /// Makes the machines with each parameter at its ends; `None` for a study without uncertainty.
    pub fn new(study: &'a WorkspaceMapStudy, nominal: &'a Machines) -> error::Result<Option<Self>> {
        let Some(uncertainty) = &study.uncertainty else { return Ok(None) };
        let end = |parameter: usize, end: usize| {
            let values = uncertainty.values_at(parameter, Response::ENDS[end]);
            let machines = || nominal.drawn(&uncertainty.machine, &values, &study.scene.errors);
            uncertainty.solved_ends(parameter)[end].then(machines).transpose()
        };
        let ends = (0..uncertainty.parameters.len()).map(|own| Ok([end(own, 0)?, end(own, 1)?]));
        let drawn = (0..Draws::PER_SCRAMBLE).map(|_| OnceLock::new()).collect();
        Ok(Some(Self { study, uncertainty, nominal, ends: ends.collect::<error::Result<_>>()?, drawn }))
    }

    /// Sessions for a group of grid points.
    pub fn solver(&self) -> SpreadSolver<'_> {
        let group = |machines: &Machines| LoadedGroup::new(machines);
        SpreadSolver {
            variations: self,
            nominal: group(self.nominal),
            ends: self.ends.iter().map(|ends| ends.each_ref().map(|own| own.as_ref().map(group))).collect(),
        }
    }

    /// Longest displacement over φ at `at` in the draw `index`, mm, the machine undeflected to begin with; `None` without equilibrium.
    fn largest_displacement(&self, index: usize, at: &Configuration) -> Option<f64> {
        let Self { study, uncertainty, .. } = self;
        let make = || {
            let values = uncertainty.values_of_draw(index);
            self.nominal.drawn(&uncertainty.machine, &values, &study.scene.errors).ok()
        };
        let machines = match self.drawn.get(index) {
            Some(kept) => kept.get_or_init(make).clone(),
            None => make(),
        }?;
        let factor = uncertainty.draws.force[index];
        let mut group = LoadedGroup::new(&machines);
        group.set_rigid(&[at; Batch::WIDTH]);
        let mut largest: f64 = 0.0;
        for phis in study.scene.phis.chunks(Batch::WIDTH) {
            let tasks: Vec<TaskPoint> = phis.iter().map(|phi| task(study, at, Some(*phi), factor)).collect();
            let places: Vec<usize> = (0..tasks.len()).collect();
            for displacement in group.displacements(&study.scene.machine, &places, |lane| tasks[lane]) {
                largest = largest.max(displacement.ok()?.norm());
            }
        }
        Some(largest)
    }

    /// Distribution of the deflection at `at` from the displacements without load and under each load.
    fn spread(
        &self,
        at: &Configuration,
        unloaded: &Response,
        loaded: &[Response],
    ) -> Result<DeflectionSpread, Failure> {
        let draws = &self.uncertainty.draws;
        let surrogate = Surrogate::new(self.uncertainty.end_coordinates(), unloaded, loaded);
        let mut sizes = surrogate.largest_displacements(draws);
        let quantiles = Quantiles::of(&sizes);
        let (main_cause, main_cause_share) = self.main_cause(&surrogate.variances(draws));
        let mut spread = DeflectionSpread {
            median_mm: quantiles.median,
            p95_mm: quantiles.p95,
            p95_standard_error_mm: quantiles.p95_standard_error,
            within_tolerance: None,
            main_cause,
            main_cause_share,
            check_difference: None,
            solved_draws: 0,
            failed_draws: 0,
        };
        if quantiles.p95 > 0.0 && !self.correct_by_next(at, &mut sizes, &mut spread) {
            sizes = self.correct_by_scrambles(at, &sizes, &mut spread);
        }
        if !spread.p95_mm.is_finite() {
            let DeflectionSpread { failed_draws, solved_draws, .. } = spread;
            let reason = format!(
                "in {failed_draws} of {solved_draws} draws the machine has no equilibrium: there is no 95 % quantile"
            );
            return Err(Failure { status: "no_equilibrium".into(), reason });
        }
        let within =
            |tolerance: f64| sizes.iter().filter(|size| **size <= tolerance).count() as f64 / sizes.len() as f64;
        spread.within_tolerance = self.study.scene.tolerance_mm.map(within);
        Ok(spread)
    }

    /// Name and share of the largest of `variances`, of which the last is that by the force.
    fn main_cause(&self, variances: &[f64]) -> (String, f64) {
        let sum: f64 = variances.iter().sum();
        let largest =
            (0..variances.len()).fold(0, |most, own| if variances[own] > variances[most] { own } else { most });
        let name = self.uncertainty.parameters.get(largest).map_or("cutting force", |own| own.name());
        let share = if sum > 0.0 { variances[largest] / sum } else { 0.0 };
        (name.into(), share)
    }

    /// Checks the surrogate by the draw next to the 95 % quantile, and scales `sizes` by the mean ratio of those next to it if it differs; false
    /// where too few draws agree on the ratio.
    fn correct_by_next(&self, at: &Configuration, sizes: &mut [f64], spread: &mut DeflectionSpread) -> bool {
        let p95 = spread.p95_mm;
        let mut next: Vec<usize> = (0..Draws::PER_SCRAMBLE).collect();
        next.sort_by(|a, b| (sizes[*a] - p95).abs().total_cmp(&(sizes[*b] - p95).abs()));
        let mut ratios: Vec<f64> = Vec::new();
        for index in next.into_iter().take(MOST_NEXT) {
            spread.solved_draws += 1;
            let Some(size) = self.largest_displacement(index, at) else {
                spread.failed_draws += 1;
                return false;
            };
            ratios.push(size / sizes[index]);
            let (mean, error) = mean_and_error(&ratios);
            if ratios.len() == 1 {
                spread.check_difference = Some(mean - 1.0);
                if (mean - 1.0).abs() <= CLOSE {
                    return true;
                }
            } else if ratios.len() >= FEWEST_NEXT && error <= LARGEST_ERROR {
                sizes.iter_mut().for_each(|size| *size *= mean);
                spread.median_mm *= mean;
                spread.p95_mm *= mean;
                spread.p95_standard_error_mm = libm::hypot(spread.p95_standard_error_mm, p95 * error);
                return true;
            }
        }
        false
    }

    /// Solves all draws, scramble after scramble, until it is known well enough how far quantiles are from those of the surrogate, `sizes`. Returns
    /// what was solved.
    fn correct_by_scrambles(&self, at: &Configuration, sizes: &[f64], spread: &mut DeflectionSpread) -> Vec<f64> {
        (spread.solved_draws, spread.failed_draws) = (0, 0);
        let mut solved = Vec::new();
        let mut differences: [Vec<f64>; 2] = Default::default();
        for own in sizes.chunks(Draws::PER_SCRAMBLE) {
            let first = solved.len();
            for index in first..first + own.len() {
                let found = self.largest_displacement(index, at);
                spread.failed_draws += usize::from(found.is_none());
                solved.push(found.unwrap_or(f64::INFINITY));
            }
            for (differences, share) in differences.iter_mut().zip([0.5, P95]) {
                differences.push(quantile(&mut solved[first..].to_vec(), share) - quantile(&mut own.to_vec(), share));
            }
            let [_, (mean, error)] = differences.each_ref().map(|own| mean_and_error(own));
            let is_known = error <= LARGEST_ERROR * spread.p95_mm || !mean.is_finite();
            if differences[1].len() >= FEWEST_SCRAMBLES && is_known {
                break;
            }
        }
        let [(median, _), (p95, error)] = differences.each_ref().map(|own| mean_and_error(own));
        spread.solved_draws = solved.len();
        spread.median_mm += median;
        spread.p95_mm += p95;
        spread.p95_standard_error_mm = libm::hypot(spread.p95_standard_error_mm, error);
        solved
    }
}

/// Mean of `values`, and its standard error.
fn mean_and_error(values: &[f64]) -> (f64, f64) {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let variance = values.iter().map(|value| (value - mean) * (value - mean)).sum::<f64>() / (count - 1.0);
    (mean, (variance / count).sqrt())
}

/// The task at `at` under the cutting force times `factor` at φ, or without it.
fn task(study: &WorkspaceMapStudy, at: &Configuration, phi: Option<f64>, factor: f64) -> TaskPoint {
    let task = Source::All.task(&study.scene.task(at.pose, phi));
    if factor == 1.0 { task } else { TaskPoint { load: task.load.scale(factor), ..task } }
}

/// Sessions of one machine, solved side by side.
struct LoadedGroup {
    sessions: Vec<Session>,
    batch: Batch,
}

impl LoadedGroup {
    fn new(machines: &Machines) -> Self {
        Self { sessions: vec![machines.session(Source::All); Batch::WIDTH], batch: machines.batch(Source::All) }
    }

    /// Commands each session its entry of `at`, the machine undeflected.
    fn set_rigid(&mut self, at: &[&Configuration]) {
        for (session, at) in self.sessions.iter_mut().zip(at) {
            session.set_rigid(at);
        }
    }

    /// Solves the task of each session in `lanes`; returns displacements of the tool tip, O axes, mm.
    fn displacements(
        &mut self,
        machine: &Machine,
        lanes: &[usize],
        task: impl Fn(usize) -> TaskPoint,
    ) -> Vec<Result<Vector3<f64>, Failure>> {
        let answers = command_points(&mut self.sessions, &mut self.batch, Method::None, lanes, task);
        let judged = answers.into_iter().map(|answer| success_or_failure(machine, None, answer));
        judged.map(|answer| Ok(answer?.tool_displacement)).collect()
    }
}

/// Solver of the spread at neighbouring grid points side by side; that of one point does not depend on the others.
pub(super) struct SpreadSolver<'a> {
    variations: &'a Variations<'a>,
    nominal: LoadedGroup,
    ends: Vec<[Option<LoadedGroup>; 2]>,
}

impl SpreadSolver<'_> {
    /// Distribution of the deflection at each of `configurations` whose displacements under each load are in `nominal`; `None` for the others.
    pub fn solve(
        &mut self,
        configurations: &[&Configuration],
        nominal: &[Option<Vec<Vector3<f64>>>],
    ) -> Vec<Option<Result<DeflectionSpread, Failure>>> {
        let Self { variations, nominal: group, ends } = self;
        let (study, parameters) = (variations.study, &variations.uncertainty.parameters);
        let response = |nominal: Vector3<f64>| Response { nominal, ends: vec![[None; 2]; parameters.len()] };
        let of_point = |loaded: &Vec<Vector3<f64>>| {
            Ok(std::iter::once(Vector3::zeros()).chain(loaded.iter().copied()).map(response).collect())
        };
        let mut points: Vec<Option<Responses>> = nominal.iter().map(|loaded| loaded.as_ref().map(of_point)).collect();
        let mut sweep = Sweep { study, configurations, points: &mut points };
        sweep.solve(group, 1, "without cutting force", |response, found| response.nominal = found);
        for (own, (ends, parameter)) in ends.iter_mut().zip(parameters).enumerate() {
            for (end, group) in ends.iter_mut().enumerate() {
                let Some(group) = group else { continue };
                let words = format!("with {} at its {} quantile", parameter.name(), ["5 %", "95 %"][end]);
                let loads = 1 + study.scene.phis.len();
                sweep.solve(group, loads, &words, |response, found| response.ends[own][end] = Some(found));
            }
        }
        let spread = |(point, at): (Option<Responses>, &&Configuration)| match point?.as_deref() {
            Ok([unloaded, loaded @ ..]) => Some(variations.spread(at, unloaded, loaded)),
            Ok([]) => None,
            Err(failure) => Some(Err(failure.clone())),
        };
        points.into_iter().zip(configurations).map(spread).collect()
    }
}

/// Displacements at one point without load and then under each load, or why one of them is missing.
type Responses = Result<Vec<Response>, Failure>;

/// A group of points whose displacements are being solved.
struct Sweep<'a> {
    study: &'a WorkspaceMapStudy,
    configurations: &'a [&'a Configuration],
    /// `None` where even the nominal machine has no displacement.
    points: &'a mut [Option<Responses>],
}

impl Sweep<'_> {
    /// Solves the first `loads` of no load and the cutting force at each φ with the machine of `group`, and hands each displacement to `put`. A
    /// point at which one is missing fails; `words` say with which machine.
    fn solve(&mut self, group: &mut LoadedGroup, loads: usize, words: &str, put: impl Fn(&mut Response, Vector3<f64>)) {
        let Self { study, configurations, points } = self;
        group.set_rigid(configurations);
        for load in 0..loads {
            let phi = load.checked_sub(1).map(|load| study.scene.phis[load]);
            let lanes: Vec<usize> = (0..points.len()).filter(|lane| matches!(points[*lane], Some(Ok(_)))).collect();
            let task = |lane: usize| task(study, configurations[lane], phi, 1.0);
            let found = group.displacements(&study.scene.machine, &lanes, task);
            for (lane, found) in lanes.into_iter().zip(found) {
                match (found, &mut points[lane]) {
                    (Ok(displacement), Some(Ok(responses))) => put(&mut responses[load], displacement),
                    (Err(Failure { status, reason }), point) => {
                        *point = Some(Err(Failure { status, reason: format!("{words}: {reason}") }));
                    }
                    (Ok(_), _) => {}
                }
            }
        }
    }
}
