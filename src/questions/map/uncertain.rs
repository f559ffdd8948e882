//! Spread of the deflection by all sources where inputs are uncertain: sampled from a surrogate at each grid point, checked there by draws of
//! the whole engine.

use std::sync::OnceLock;

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use super::{SessionGroup, WorkspaceMapStudy};
use crate::{
    compensation::{Method, TaskPoint},
    input::error,
    machine::Configuration,
    process::uncertainty::{Draws, Quantiles, Response, Surrogate, Uncertainty, mean_and_error},
    simulation::{Failure, Machines, ROUNDING_MM, Source},
    statics::Batch,
    work::Work,
};

/// Distribution of the deflection by all sources at a grid point, worst over the tool angle φ.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct DeflectionSpread {
    /// Half of the draws deflect less, mm; `None` where as many have no equilibrium.
    pub median_mm: Option<f64>,
    /// 95 % of the draws deflect less, mm; `None` where more than 5 % have no equilibrium.
    pub p95_mm: Option<f64>,
    /// Standard error of `p95_mm`: by the number of draws, and by the check; `None` where draws without equilibrium leave it open.
    pub p95_standard_error_mm: Option<f64>,
    /// Probability that the deflection is within tolerance, 0 to 1; `None` without tolerance.
    pub within_tolerance: Option<f64>,
    /// What causes the largest part of the variance, a parameter or "cutting force"; `None` where nothing does, or too few draws have an equilibrium.
    pub main_cause: Option<String>,
    /// Its share of the sum of variances by each alone, 0 to 1.
    pub main_cause_share: Option<f64>,
    /// Engine over surrogate less 1 in the draw next to the 95 % quantile; `None` where the surrogate was not used.
    pub check_difference: Option<f64>,
    /// Number of draws solved by the engine.
    pub solved_draws: usize,
    /// Number of those in which the machine has no equilibrium, or there is no such machine; they do not count as within tolerance.
    pub failed_draws: usize,
    /// Why the first of these failed.
    pub first_failure: Option<String>,
}

/// Largest difference of the engine from the surrogate that needs no further draws, as a share.
const CLOSE: f64 = 0.005;
/// Largest standard error of the 95 % quantile by the check, as a share.
const LARGEST_ERROR: f64 = 0.003;
/// Fewest and most draws next to a value by which a quantile or probability is corrected.
const FEWEST_NEXT: usize = 8;
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
    /// Coordinates of each parameter at these ends.
    end_coordinates: Vec<[f64; 2]>,
    /// Machines of the draws of the first scramble, made when they are needed.
    drawn: Vec<OnceLock<Result<Machines, Failure>>>,
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
        let (ends, end_coordinates) = (ends.collect::<error::Result<_>>()?, uncertainty.end_coordinates());
        Ok(Some(Self { study, uncertainty, nominal, ends, end_coordinates, drawn }))
    }

    /// Sessions for a group of grid points.
    pub fn solver(&self) -> SpreadSolver<'_> {
        let group = |machines: &Machines| SessionGroup::new(machines, Source::All);
        SpreadSolver {
            variations: self,
            nominal: group(self.nominal),
            ends: self.ends.iter().map(|ends| ends.each_ref().map(|own| own.as_ref().map(group))).collect(),
        }
    }

    /// Length of the longest displacement over φ at `at` in the draw `index`, mm, the machine undeflected to begin with, or why there is none; counted
    /// in `spread`.
    fn solve_draw(&self, index: usize, at: &Configuration, spread: &mut DeflectionSpread) -> Option<f64> {
        let found = self.largest_displacement(index, at);
        spread.solved_draws += 1;
        found
            .inspect_err(|failure| {
                spread.failed_draws += 1;
                spread.first_failure.get_or_insert_with(|| failure.reason.clone());
            })
            .ok()
    }

    fn largest_displacement(&self, index: usize, at: &Configuration) -> Result<f64, Failure> {
        let Self { study, uncertainty, .. } = self;
        let make = || {
            let values = uncertainty.values_of_draw(index);
            let machines = self.nominal.drawn(&uncertainty.machine, &values, &study.scene.errors);
            machines.map_err(|error| Failure { status: "no_equilibrium".into(), reason: error.to_string() })
        };
        let machines = match self.drawn.get(index) {
            Some(kept) => kept.get_or_init(make).clone(),
            None => make(),
        }?;
        let factor = uncertainty.draws.force[index];
        let mut group = SessionGroup::new(&machines, Source::All);
        group.set_rigid(&[at; Batch::WIDTH]);
        let mut largest: f64 = 0.0;
        for phis in study.scene.phis.chunks(Batch::WIDTH) {
            let tasks: Vec<TaskPoint> = phis.iter().map(|phi| task(study, at, Some(*phi), factor)).collect();
            let lanes: Vec<usize> = (0..tasks.len()).collect();
            for answer in group.command(&study.scene.machine, None, Method::None, &lanes, |lane| tasks[lane]) {
                largest = largest.max(answer?.tool_displacement.norm());
            }
        }
        Ok(largest)
    }

    /// Distribution of the deflection at `at` from the displacements without load and under each load, checked by the engine; by the engine alone
    /// where one of these failed or the check does not end. `Err` if `work` is stopped.
    fn spread(&self, at: &Configuration, responses: &Responses, work: &Work) -> error::Result<DeflectionSpread> {
        let Ok([unloaded, loaded @ ..]) = responses.as_deref() else {
            return self.spread_by_engine(at, DeflectionSpread::default(), work);
        };
        let draws = &self.uncertainty.draws;
        let surrogate = Surrogate::new(&self.end_coordinates, unloaded, loaded, draws);
        let sizes = surrogate.largest_displacements(draws);
        let quantiles = Quantiles::of(&sizes);
        let mut spread = self.spread_with_cause(&surrogate.variances(draws));
        match self.checked(at, &sizes, quantiles, &mut spread) {
            Some(()) => Ok(spread),
            None => self.spread_by_engine(at, spread, work),
        }
    }

    /// A distribution with its main cause by `variances`, of which the last is that by the force.
    fn spread_with_cause(&self, variances: &[f64]) -> DeflectionSpread {
        let sum: f64 = variances.iter().sum();
        let largest =
            (0..variances.len()).fold(0, |most, own| if variances[own] > variances[most] { own } else { most });
        let name = self.uncertainty.parameters.get(largest).map_or("cutting force", |own| own.name());
        let has_cause = sum > ROUNDING_MM * ROUNDING_MM;
        DeflectionSpread {
            main_cause: has_cause.then(|| name.into()),
            main_cause_share: has_cause.then(|| variances[largest] / sum),
            ..DeflectionSpread::default()
        }
    }

    /// Fills `spread` with the quantiles of `sizes`, checked by the draw next to the 95 % quantile; where the engine differs there, quantiles and
    /// probability are corrected by the mean ratio in draws next to each. `None` where too few draws agree on a ratio, or one has no equilibrium.
    fn checked(
        &self,
        at: &Configuration,
        sizes: &[f64],
        quantiles: Quantiles,
        spread: &mut DeflectionSpread,
    ) -> Option<()> {
        let Quantiles { mut median, mut p95, p95_standard_error } = quantiles;
        let (mut error, mut by_tolerance) = (0.0, 1.0);
        let tolerance = self.study.scene.tolerance_mm;
        if p95 > ROUNDING_MM {
            let mut order: Vec<usize> = (0..Draws::PER_SCRAMBLE).collect();
            order.sort_by(|a, b| sizes[*a].total_cmp(&sizes[*b]));
            let ratio =
                |value: f64, spread: &mut DeflectionSpread| self.ratio_next_to(value, at, sizes, &order, spread);
            let by_p95 = ratio(p95, spread)?;
            error = by_p95.error * p95;
            if by_p95.mean != 1.0 {
                p95 *= by_p95.mean;
                median *= ratio(median, spread)?.mean;
                if let Some(tolerance) = tolerance {
                    by_tolerance = ratio(tolerance, spread)?.mean;
                }
            }
        }
        spread.median_mm = Some(median);
        spread.p95_mm = Some(p95);
        spread.p95_standard_error_mm = Some(libm::hypot(p95_standard_error, error));
        spread.within_tolerance = tolerance.map(|tolerance| share_within(sizes, tolerance / by_tolerance));
        Some(())
    }

    /// Ratio of engine and surrogate in draws of the first scramble (in ascending `order` of `sizes`) on both sides of `value`, mm: 1 if the first
    /// agrees. `None` where too few agree, or one has no equilibrium.
    fn ratio_next_to(
        &self,
        value: f64,
        at: &Configuration,
        sizes: &[f64],
        order: &[usize],
        spread: &mut DeflectionSpread,
    ) -> Option<Ratio> {
        let above = order.partition_point(|index| sizes[*index] < value).clamp(1, order.len() - 1);
        let (below, above) = order.split_at(above);
        let sides = above.iter().zip(below.iter().rev()).flat_map(|(above, below)| [*above, *below]);
        let mut ratios: Vec<f64> = Vec::new();
        for index in sides.take(MOST_NEXT) {
            ratios.push(self.solve_draw(index, at, spread)? / sizes[index]);
            let (mean, error) = mean_and_error(&ratios);
            let difference = (mean - 1.0).abs();
            if ratios.len() == 1 {
                spread.check_difference.get_or_insert(mean - 1.0);
            }
            if ratios.len() == 1 && difference <= CLOSE {
                return Some(Ratio { mean: 1.0, error: difference });
            }
            if ratios.len() >= FEWEST_NEXT && error <= LARGEST_ERROR {
                return Some(Ratio { mean, error });
            }
        }
        None
    }

    /// Fills `spread` by draws of the engine, scramble after scramble, until the 95 % quantile is known well enough. `Err` if `work` is stopped.
    fn spread_by_engine(
        &self,
        at: &Configuration,
        spread: DeflectionSpread,
        work: &Work,
    ) -> error::Result<DeflectionSpread> {
        let mut spread = DeflectionSpread { solved_draws: 0, failed_draws: 0, first_failure: None, ..spread };
        let mut solved: Vec<f64> = Vec::new();
        let quantiles = loop {
            for index in solved.len()..solved.len() + Draws::PER_SCRAMBLE {
                work.check()?;
                solved.push(self.solve_draw(index, at, &mut spread).unwrap_or(f64::INFINITY));
            }
            let found = Quantiles::of(&solved);
            let is_known = found.p95_standard_error <= LARGEST_ERROR * found.p95 || found.p95 == f64::INFINITY;
            let is_enough = solved.len() >= FEWEST_SCRAMBLES * Draws::PER_SCRAMBLE && is_known;
            if is_enough || solved.len() == Draws::COUNT {
                break found;
            }
        };
        let finite = |value: f64| Some(value).filter(|value| value.is_finite());
        spread.median_mm = finite(quantiles.median);
        spread.p95_mm = finite(quantiles.p95);
        spread.p95_standard_error_mm = spread.p95_mm.and(finite(quantiles.p95_standard_error));
        spread.within_tolerance = self.study.scene.tolerance_mm.map(|tolerance| share_within(&solved, tolerance));
        Ok(spread)
    }
}

/// Ratio of engine and surrogate, and its standard error.
struct Ratio {
    mean: f64,
    error: f64,
}

/// Share of `sizes` that are at most `tolerance`.
fn share_within(sizes: &[f64], tolerance: f64) -> f64 {
    sizes.iter().filter(|size| **size <= tolerance).count() as f64 / sizes.len() as f64
}

/// The task at `at` under the cutting force times `factor` at φ, or without it.
fn task(study: &WorkspaceMapStudy, at: &Configuration, phi: Option<f64>, factor: f64) -> TaskPoint {
    let task = Source::All.task(&study.scene.task(at.pose, phi));
    if factor == 1.0 { task } else { TaskPoint { load: task.load.scale(factor), ..task } }
}

/// Solver of the spread at neighbouring grid points side by side; that of one point does not depend on the others.
pub(super) struct SpreadSolver<'a> {
    variations: &'a Variations<'a>,
    nominal: SessionGroup,
    ends: Vec<[Option<SessionGroup>; 2]>,
}

impl SpreadSolver<'_> {
    /// Distribution of the deflection at each of `configurations` whose displacements under each load are in `nominal`; `None` for the others. `Err`
    /// if `work` is stopped.
    pub fn solve<'d>(
        &mut self,
        configurations: &[&Configuration],
        nominal: impl Iterator<Item = Option<&'d [Vector3<f64>]>>,
        work: &Work,
    ) -> error::Result<Vec<Option<DeflectionSpread>>> {
        let Self { variations, nominal: group, ends } = self;
        let (study, parameters) = (variations.study, &variations.uncertainty.parameters);
        let response = |nominal: Vector3<f64>| Response { nominal, ends: vec![[None; 2]; parameters.len()] };
        let of_point = |loaded: &[Vector3<f64>]| {
            Ok(std::iter::once(Vector3::zeros()).chain(loaded.iter().copied()).map(response).collect())
        };
        let mut points: Vec<Option<Responses>> = nominal.map(|loaded| loaded.map(of_point)).collect();
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
        let spread = |(point, at): (Option<Responses>, &&Configuration)| {
            point.map(|responses| variations.spread(at, &responses, work)).transpose()
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
    fn solve(
        &mut self,
        group: &mut SessionGroup,
        loads: usize,
        words: &str,
        put: impl Fn(&mut Response, Vector3<f64>),
    ) {
        let Self { study, configurations, points } = self;
        group.set_rigid(configurations);
        for load in 0..loads {
            let phi = load.checked_sub(1).map(|load| study.scene.phis[load]);
            let lanes: Vec<usize> = (0..points.len()).filter(|lane| matches!(points[*lane], Some(Ok(_)))).collect();
            let task = |lane: usize| task(study, configurations[lane], phi, 1.0);
            let found = group.command(&study.scene.machine, None, Method::None, &lanes, task);
            for (lane, found) in lanes.into_iter().zip(found) {
                match (found, &mut points[lane]) {
                    (Ok(answer), Some(Ok(responses))) => put(&mut responses[load], answer.tool_displacement),
                    (Err(Failure { status, reason }), point) => {
                        *point = Some(Err(Failure { status, reason: format!("{words}: {reason}") }));
                    }
                    (Ok(_), _) => {}
                }
            }
        }
    }
}
