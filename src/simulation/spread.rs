//! Distribution of a deflection where inputs are uncertain: sampled from a surrogate, and checked by draws of the whole engine.

use std::{cell::OnceCell, sync::OnceLock};

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use super::{Failure, Machines, ROUNDING_MM, Source};
use crate::{
    compensation::TaskPoint,
    input::error,
    machine::ChainError,
    process::uncertainty::{Cause, Draws, Quantiles, Response, Surrogate, Uncertainty, mean_and_error},
};

/// Distribution of a deflection over the draws.
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
    /// What causes the largest part of the variance, a parameter, "cutting force" or "what the model leaves out"; `None` where nothing does, or too few draws have an equilibrium.
    pub main_cause: Option<String>,
    /// Its share of the sum of variances by each alone, 0 to 1.
    pub main_cause_share: Option<f64>,
    /// Engine less surrogate in the draw next to the 95 % quantile, over that quantile; `None` where the surrogate was not used.
    pub check_difference: Option<f64>,
    /// Number of draws solved by the engine.
    pub solved_draws: usize,
    /// Number of those in which the machine has no equilibrium, or there is no such machine; they do not count as within tolerance.
    pub failed_draws: usize,
    /// Why the first of these failed.
    pub first_failure: Option<String>,
}

/// Largest difference of the engine from the surrogate that needs no further draws, as a share of the 95 % quantile, and in mm.
const CLOSE: f64 = 0.005;
const CLOSE_MM: f64 = 1e-6;
/// Largest standard error of the 95 % quantile by the check, as a share.
const LARGEST_ERROR: f64 = 0.003;
/// Fewest draws next to a value by which a quantile or probability is corrected, and most: of the first scramble, whose machines are kept, and of all.
const FEWEST_NEXT: usize = 8;
const MOST_NEXT: [usize; 2] = [32, 256];
/// Fewest scrambles of which all draws are solved, where those next to the quantile do not suffice.
const FEWEST_SCRAMBLES: usize = 4;

/// Share of draws without equilibrium from which no more are solved: three times that at which there is no 95 % quantile.
const MANY_FAILED: f64 = 0.15;

/// The machines that uncertain inputs make of a nominal one.
pub(crate) struct DrawnMachines<'a> {
    /// What varies.
    pub uncertainty: &'a Uncertainty,
    nominal: &'a Machines,
    errors: &'a [ChainError],
    /// Machines with each parameter alone at its ends ([`Response::ENDS`]), as far as they are solved.
    pub ends: Vec<[Option<Machines>; 2]>,
    /// Coordinates of each parameter at these ends.
    end_coordinates: Vec<[f64; 2]>,
    /// What spreads a result ([`Uncertainty::causes`]).
    causes: Vec<(String, Cause)>,
    /// Machines of the draws of the first scramble, made when they are needed.
    drawn: Vec<OnceLock<Result<Machines, Failure>>>,
}

impl<'a> DrawnMachines<'a> {
    /// Makes the machines with each parameter at its ends; `None` where inputs are exact. `errors` are the chain errors of `nominal`.
    ///
    /// # Errors
    /// As [`Machines::drawn`].
    pub fn new(
        uncertainty: Option<&'a Uncertainty>,
        nominal: &'a Machines,
        errors: &'a [ChainError],
    ) -> error::Result<Option<Self>> {
        // Pages compute with nominal numbers.
        let Some(uncertainty) = uncertainty.filter(|_| !cfg!(target_family = "wasm")) else { return Ok(None) };
        let end = |parameter: usize, end: usize| {
            let values = uncertainty.values_at(parameter, Response::ENDS[end]);
            let machines = || nominal.drawn(&uncertainty.machine, &values, errors);
            uncertainty.solved_ends(parameter)[end].then(machines).transpose()
        };
        let ends = (0..uncertainty.parameters.len()).map(|own| Ok([end(own, 0)?, end(own, 1)?]));
        let drawn = (0..Draws::PER_SCRAMBLE).map(|_| OnceLock::new()).collect();
        let (ends, end_coordinates) = (ends.collect::<error::Result<_>>()?, uncertainty.end_coordinates());
        let causes = uncertainty.causes().collect();
        Ok(Some(Self { uncertainty, nominal, errors, ends, end_coordinates, causes, drawn }))
    }

    /// Words for the machine with `parameter` alone at one of its ends.
    pub fn end_words(&self, parameter: usize, end: usize) -> String {
        format!("with {} at its {} quantile", self.uncertainty.parameters[parameter].name(), ["5 %", "95 %"][end])
    }

    /// Whether the model leaves something out, so that displacements without cutting force are needed as well.
    pub fn has_model_error(&self) -> bool {
        !self.uncertainty.draws.model.is_empty()
    }

    /// The displacement `loaded` that the engine found in the draw `index`, with what the model leaves out of it; `free` is that without cutting force.
    pub fn real_displacement(&self, index: usize, free: Vector3<f64>, loaded: Vector3<f64>) -> Vector3<f64> {
        loaded + self.uncertainty.draws.model_error(index, &(loaded - free))
    }

    /// Returns what `on` makes of the machines of the draw `index`; those of the first scramble are kept.
    pub fn on_draw<T>(&self, index: usize, on: impl FnOnce(&Machines) -> T) -> Result<T, Failure> {
        match self.drawn.get(index) {
            Some(kept) => kept.get_or_init(|| self.machines_of(index)).as_ref().map(on).map_err(Failure::clone),
            None => self.machines_of(index).as_ref().map(on).map_err(Failure::clone),
        }
    }

    /// Makes the machines of the draw `index`.
    fn machines_of(&self, index: usize) -> Result<Machines, Failure> {
        let values = self.uncertainty.values_of_draw(index);
        let machines = self.nominal.drawn(&self.uncertainty.machine, &values, self.errors);
        machines.map_err(|error| Failure { status: "no_equilibrium".into(), reason: error.to_string() })
    }
}

/// Size of a deflection in a draw, mm, or why it has none; of the number of the draw, its machines and its factor of the cutting force. `Err` if
/// the work is stopped.
type Solve<'a> = dyn Fn(usize, &Machines, f64) -> error::Result<Result<f64, Failure>> + 'a;

/// A deflection whose distribution is wanted.
pub(crate) struct WantedSpread<'a> {
    /// The draws, and machines of them.
    pub drawn: &'a DrawnMachines<'a>,
    /// Largest deflection that is within tolerance, mm.
    pub tolerance_mm: Option<f64>,
    /// The engine.
    pub solve: &'a Solve<'a>,
    /// Most draws solved next to a value, where each takes long.
    pub most_next: Option<usize>,
}

impl WantedSpread<'_> {
    /// Size in the draw `index`, mm; `None` if it has none. Counted in `spread`.
    fn solve_draw(&self, index: usize, spread: &mut DeflectionSpread) -> error::Result<Option<f64>> {
        let factor = self.drawn.uncertainty.draws.force[index];
        let found = self.drawn.on_draw(index, |machines| (self.solve)(index, machines, factor));
        let found = found.unwrap_or_else(|failure| Ok(Err(failure)))?;
        spread.solved_draws += 1;
        if let Err(failure) = &found {
            spread.failed_draws += 1;
            spread.first_failure.get_or_insert_with(|| failure.reason.clone());
        }
        Ok(found.ok())
    }

    /// Distribution of the longest of the displacements without load (the first of `responses`) and under each load, and its size in the draws. Where
    /// there are no `responses`, or the engine does not agree with the surrogate of them, by the engine.
    pub fn spread(&self, responses: Option<&[Response]>) -> error::Result<(DeflectionSpread, Sizes)> {
        let draws = &self.drawn.uncertainty.draws;
        let Some([unloaded, loaded @ ..]) = responses else {
            return self.spread_by_engine(DeflectionSpread::default());
        };
        let surrogate = Surrogate::new(&self.drawn.end_coordinates, unloaded, loaded, draws);
        let sizes = surrogate.largest_displacements(draws);
        let causes = self.drawn.causes.iter().map(|(_, cause)| cause);
        let mut spread = self.spread_with_cause(&surrogate.variances(draws, causes));
        match self.check(&sizes, &mut spread)? {
            true => Ok((spread, Sizes { mm: sizes, is_by_engine: false })),
            false => self.spread_by_engine(spread),
        }
    }

    /// A distribution with its main cause by the `variances` of each cause.
    fn spread_with_cause(&self, variances: &[f64]) -> DeflectionSpread {
        let sum: f64 = variances.iter().sum();
        let largest =
            (0..variances.len()).fold(0, |most, own| if variances[own] > variances[most] { own } else { most });
        let has_cause = sum > ROUNDING_MM * ROUNDING_MM;
        DeflectionSpread {
            main_cause: has_cause.then(|| self.drawn.causes[largest].0.clone()),
            main_cause_share: has_cause.then(|| variances[largest] / sum),
            ..DeflectionSpread::default()
        }
    }

    /// Fills `spread` with the quantiles of `sizes` in the draws (infinite without equilibrium), checked by the draw next to the 95 % quantile; where
    /// the engine differs there, quantiles and probability are corrected by the mean difference in draws next to each. Returns whether the engine
    /// agrees or corrected them: not where too few draws agree on a difference, or one has no equilibrium.
    pub fn check(&self, sizes: &[f64], spread: &mut DeflectionSpread) -> error::Result<bool> {
        let Quantiles { median, p95, p95_standard_error } = Quantiles::of(sizes);
        spread.fill(median, p95, p95_standard_error);
        spread.within_tolerance = self.tolerance_mm.map(|tolerance| share_within(sizes, tolerance));
        if p95 <= ROUNDING_MM || !p95.is_finite() {
            return Ok(true);
        }
        let in_order = |draws: usize| {
            let mut order: Vec<usize> = (0..draws).filter(|index| sizes[*index].is_finite()).collect();
            order.sort_by(|a, b| sizes[*a].total_cmp(&sizes[*b]));
            order
        };
        let (few, all) = (in_order(Draws::PER_SCRAMBLE), OnceCell::new());
        let mut next_to = |value: f64, is_known: &dyn Fn(&Difference) -> bool| {
            let most_next = self.most_next.unwrap_or(usize::MAX).max(FEWEST_NEXT);
            let [most, most_of_all] = MOST_NEXT.map(|most| most.min(most_next));
            let found = self.difference_next_to((value, p95), sizes, (&few, most), is_known, spread)?;
            match found {
                None if spread.failed_draws == 0 => {
                    let all = all.get_or_init(|| in_order(sizes.len()));
                    self.difference_next_to((value, p95), sizes, (all, most_of_all), is_known, spread)
                }
                found => Ok(found),
            }
        };
        let is_small = |found: &Difference| found.error_mm <= (LARGEST_ERROR * p95).max(CLOSE_MM);
        let Some(by_p95) = next_to(p95, &is_small)? else { return Ok(false) };
        let (mut by_median, mut by_tolerance) = (0.0, 0.0);
        if by_p95.mean_mm != 0.0 {
            let Some(found) = next_to(median, &is_small)? else { return Ok(false) };
            by_median = found.mean_mm;
            if let Some(tolerance) = self.tolerance_mm {
                // Far from all draws it changes nothing.
                let is_sure = |found: &Difference| {
                    let [most, least] =
                        [1.0, -1.0].map(|sign| share_within(sizes, tolerance - found.mean_mm + sign * found.error_mm));
                    most - least <= LARGEST_ERROR
                };
                let Some(found) = next_to(tolerance, &is_sure)? else { return Ok(false) };
                by_tolerance = found.mean_mm;
            }
        }
        spread.fill(median + by_median, p95 + by_p95.mean_mm, libm::hypot(p95_standard_error, by_p95.error_mm));
        spread.within_tolerance = self.tolerance_mm.map(|tolerance| share_within(sizes, tolerance - by_tolerance));
        Ok(true)
    }

    /// Difference of engine and surrogate in the `most` draws of `order` (by ascending `sizes`) on both sides of `value`, mm: none if the first
    /// agrees, measured by the quantile `p95`. `None` where it is not known well enough after these, or one has no equilibrium.
    fn difference_next_to(
        &self,
        (value, p95): (f64, f64),
        sizes: &[f64],
        (order, most): (&[usize], usize),
        is_known: &dyn Fn(&Difference) -> bool,
        spread: &mut DeflectionSpread,
    ) -> error::Result<Option<Difference>> {
        let middle = order.partition_point(|index| sizes[*index] < value);
        let (mut below, mut above) = (order[..middle].iter().rev(), order[middle..].iter());
        // By turns above and below, on one side alone behind the last of the other.
        let nearest = (0..order.len()).map_while(|turn| match turn % 2 {
            0 => above.next().or_else(|| below.next()),
            _ => below.next().or_else(|| above.next()),
        });
        let mut differences: Vec<f64> = Vec::new();
        for &index in nearest.take(most) {
            let Some(solved) = self.solve_draw(index, spread)? else { return Ok(None) };
            differences.push(solved - sizes[index]);
            let (mean_mm, error_mm) = mean_and_error(&differences);
            if differences.len() == 1 {
                spread.check_difference.get_or_insert(mean_mm / p95);
                if mean_mm.abs() <= (CLOSE * p95).max(CLOSE_MM) {
                    return Ok(Some(Difference { mean_mm: 0.0, error_mm: mean_mm.abs() }));
                }
            }
            let found = Difference { mean_mm, error_mm };
            if differences.len() >= FEWEST_NEXT && is_known(&found) {
                return Ok(Some(found));
            }
        }
        Ok(None)
    }

    /// Fills `spread` by draws of the engine, scramble after scramble, until the 95 % quantile is known well enough; returns their sizes as well.
    fn spread_by_engine(&self, spread: DeflectionSpread) -> error::Result<(DeflectionSpread, Sizes)> {
        let mut spread = DeflectionSpread { solved_draws: 0, failed_draws: 0, first_failure: None, ..spread };
        let mut solved: Vec<f64> = Vec::new();
        let quantiles = loop {
            for index in solved.len()..solved.len() + Draws::PER_SCRAMBLE {
                solved.push(self.solve_draw(index, &mut spread)?.unwrap_or(f64::INFINITY));
            }
            let found = Quantiles::of(&solved);
            let is_known = found.p95_standard_error <= LARGEST_ERROR * found.p95 || found.p95 == f64::INFINITY;
            let is_enough = solved.len() >= FEWEST_SCRAMBLES * Draws::PER_SCRAMBLE && is_known;
            // Draws without equilibrium take long, and here they are far more than leave a 95 % quantile.
            let is_lost = spread.failed_draws as f64 > MANY_FAILED * solved.len() as f64;
            if is_lost || is_enough || solved.len() == Draws::COUNT {
                break found;
            }
        };
        spread.fill(quantiles.median, quantiles.p95, quantiles.p95_standard_error);
        spread.within_tolerance = self.tolerance_mm.map(|tolerance| share_within(&solved, tolerance));
        Ok((spread, Sizes { mm: solved, is_by_engine: true }))
    }
}

impl DeflectionSpread {
    /// Why there is no 95 % quantile; `None` where there is one.
    pub fn reason(&self) -> Option<String> {
        let Self { p95_mm: None, solved_draws, failed_draws, first_failure, .. } = self else { return None };
        let first = first_failure.as_deref().unwrap_or_default();
        Some(format!("{failed_draws} of {solved_draws} draws have no equilibrium; the first: {first}"))
    }

    /// Sets quantiles and standard error as far as they are finite, mm.
    fn fill(&mut self, median: f64, p95: f64, standard_error: f64) {
        let finite = |value: f64| Some(value).filter(|value| value.is_finite());
        self.median_mm = finite(median);
        self.p95_mm = finite(p95);
        self.p95_standard_error_mm = self.p95_mm.and(finite(standard_error));
    }
}

/// Sizes of a deflection in the draws: all of them from the surrogate as it is, or the first ones from the engine (infinite without equilibrium).
pub(crate) struct Sizes {
    pub mm: Vec<f64>,
    pub is_by_engine: bool,
}

/// Engine less surrogate, and the standard error of that.
struct Difference {
    mean_mm: f64,
    error_mm: f64,
}

/// The task of all sources with the cutting force times `factor`.
pub(crate) fn under(task: &TaskPoint, factor: f64) -> TaskPoint {
    let task = Source::All.task(task);
    if factor == 1.0 { task } else { TaskPoint { load: task.load.scale(factor), ..task } }
}

/// Share of `sizes` that are at most `tolerance`.
fn share_within(sizes: &[f64], tolerance: f64) -> f64 {
    sizes.iter().filter(|size| **size <= tolerance).count() as f64 / sizes.len() as f64
}
