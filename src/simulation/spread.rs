//! Distribution of a deflection where inputs are uncertain: sampled from a surrogate, and checked by draws of the whole engine.

use std::{
    borrow::Cow,
    cell::OnceCell,
    collections::{BTreeMap, btree_map::Entry},
    sync::OnceLock,
};

use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::{Failure, Machines, ROUNDING_MM, Source};
use crate::{
    FOR_PAGES,
    compensation::TaskPoint,
    input::error,
    machine::ChainError,
    process::uncertainty::{
        Cause, Cut, DrawnForceAt, Draws, ForceFactors, P95, Quantiles, Response, Shares, Surrogate, Uncertainty,
        Values, mean_and_error, quantile,
    },
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
    /// What causes the largest part of the variance, a parameter, "cutting force" or a component of it, "tool wear" or "what the model leaves out"; `None` where nothing does, or too few draws have an equilibrium.
    pub main_cause: Option<String>,
    /// Its share of the sum of variances by each alone, 0 to 1.
    pub main_cause_share: Option<f64>,
    /// Engine less surrogate in the first draw solved next to the 95 % quantile, over that quantile; `None` where none was solved, or it has no equilibrium.
    pub check_difference: Option<f64>,
    /// Whether the engine differs from the surrogate, so that quantiles and probability are corrected, or by the engine.
    pub is_corrected: bool,
    /// Number of draws solved by the engine.
    pub solved_draws: usize,
    /// Number of those in which the machine has no equilibrium, or there is no such machine; they do not count as within tolerance.
    pub failed_draws: usize,
    /// Share of the draws that are known to have none, 0 to 1; the others are taken to have one.
    pub failed_share: f64,
    /// Why the first of these failed.
    pub first_failure: Option<String>,
    /// What draws say of it that were chosen at random, whatever the estimate is in them.
    pub audit: Audit,
}

/// What becomes of a 95 % quantile if what spreads the deflection is measured.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct IfMeasured {
    /// What is measured, a parameter, "cutting force" or a component of it, "tool wear" or "what the model leaves out".
    pub cause: String,
    /// How well it is known then.
    pub known: String,
    /// The quantile as it is, and then, mm.
    pub p95_mm: [f64; 2],
}

impl IfMeasured {
    /// The one of `all` that is worth most; `None` for none.
    pub fn worth_most(all: impl IntoIterator<Item = Self>) -> Option<Self> {
        all.into_iter().min_by(|a, b| a.p95_mm[1].total_cmp(&b.p95_mm[1]))
    }
}

/// Draws chosen at random and solved by the engine beside those of the check.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Audit {
    /// Number of draws.
    pub draws: usize,
    /// Number of those in which the machine has no equilibrium.
    pub failed: usize,
    /// Number of these in which the estimate has one.
    pub unforeseen: usize,
    /// Number of the others at points where the estimate is not corrected.
    pub compared: usize,
    /// Number of these in which it is off by more than 1 % of the 95 % quantile.
    pub apart: usize,
    /// Largest difference there, as a share of that quantile.
    pub largest: f64,
}

impl Audit {
    /// Adds the draws of `other`.
    pub fn add(&mut self, other: &Self) {
        self.draws += other.draws;
        self.failed += other.failed;
        self.unforeseen += other.unforeseen;
        self.compared += other.compared;
        self.apart += other.apart;
        self.largest = self.largest.max(other.largest);
    }
}

/// Share of the variance from which on it may be worth a measurement.
const WORTH_MEASURING: f64 = 0.05;

/// Largest difference from the estimate that an audit lets pass, as a share of the 95 % quantile.
const APART: f64 = 0.01;

/// Largest difference of the engine from the surrogate that needs no further draws, as a share of the 95 % quantile, and in mm.
const CLOSE: f64 = 0.005;
const CLOSE_MM: f64 = 1e-6;
/// Largest standard error of the 95 % quantile by the check, as a share, and after the last draw where that by their number is below half of it; and
/// largest difference of the probability by one such error to each side.
const LARGEST_ERROR: f64 = 0.003;
const LARGEST_PROBABILITY_ERROR: f64 = 0.01;
/// Fewest draws, at a point or at those next to it, that show how far engine and surrogate differ in others.
const FEWEST_ALIKE: usize = 4;
/// Fewest draws next to a value by which a quantile or probability is corrected, and most: of the first scramble, whose machines are kept, and of all.
const FEWEST_NEXT: usize = 8;
const MAX_NEXT: [usize; 2] = [32, 256];
/// Fewest scrambles of which all draws are solved, where those next to the quantile do not suffice.
const FEWEST_SCRAMBLES: usize = 4;

/// Where the weakest machine falls over, the draws are solved from the weakest on until so many one after another stand, for the force and for each stiffness.
const STANDING: usize = 12;
/// Machines of so many of these are kept for other points.
const KEPT: usize = 5 * STANDING;
/// Share of draws without equilibrium from which those next to the 95 % quantile are near them.
const FEW_FAILED: f64 = 0.002;
/// Share of draws without equilibrium from which all are solved: there is no 95 % quantile.
const LOST: f64 = 1.0 - P95;

/// Share of draws without equilibrium from which no more are solved: three times that at which there is no 95 % quantile.
const MANY_FAILED: f64 = 0.15;

/// Makes the machines with each parameter alone at its ends ([`Response::ENDS`]), as far as they are solved; `errors` are the chain errors of `nominal`.
///
/// # Errors
/// As [`Machines::drawn`].
pub(crate) fn machines_at_ends(
    uncertainty: &Uncertainty,
    nominal: &Machines,
    errors: &[ChainError],
) -> error::Result<Vec<[Option<Machines>; 2]>> {
    let end = |parameter: usize, end: usize| {
        let values = uncertainty.values_at(parameter, Response::ENDS[end]);
        let machines = || nominal.drawn(&uncertainty.machine, &values, errors);
        uncertainty.solved_ends(parameter)[end].then(machines).transpose()
    };
    (0..uncertainty.parameters.len()).map(|own| Ok([end(own, 0)?, end(own, 1)?])).collect()
}

/// The machines that uncertain inputs make of a nominal one.
#[derive(Debug)]
pub(crate) struct DrawnMachines {
    /// What varies.
    pub uncertainty: Uncertainty,
    /// The nominal and actual machines, with nominal numbers.
    pub machines: Machines,
    errors: Vec<ChainError>,
    /// Machines with each parameter alone at its ends ([`Response::ENDS`]), as far as they are solved.
    pub ends: Vec<[Option<Machines>; 2]>,
    /// Coordinates of each parameter at these ends.
    pub end_coordinates: Vec<[f64; 2]>,
    /// What spreads a result ([`Uncertainty::causes`]).
    causes: Vec<(String, Cause)>,
    /// Machines of draws that many points need, made when the first does: those of the first scramble and the weakest; `None` of others.
    drawn: Vec<Option<OnceLock<Result<Machines, Failure>>>>,
    /// The machine with all stiffnesses as low as any in the weakest draw, made when it is needed.
    weakest: OnceLock<Result<Machines, Failure>>,
}

impl DrawnMachines {
    /// Makes the machines with each parameter at its ends; `None` where inputs are exact. `errors` are the chain errors of `machines`.
    ///
    /// # Errors
    /// As [`Machines::drawn`].
    pub fn new(
        uncertainty: Option<&Uncertainty>,
        machines: &Machines,
        errors: &[ChainError],
    ) -> error::Result<Option<Self>> {
        // Pages compute with nominal numbers.
        let Some(uncertainty) = uncertainty.filter(|_| !FOR_PAGES) else { return Ok(None) };
        let mut drawn: Vec<_> =
            (0..Draws::COUNT).map(|index| (index < Draws::PER_SCRAMBLE).then(OnceLock::new)).collect();
        let weakest = uncertainty.draws.from_weakest.iter().flat_map(|order| &order[..KEPT]);
        weakest.for_each(|index| drawn[*index] = Some(OnceLock::new()));
        let (ends, end_coordinates) = (machines_at_ends(uncertainty, machines, errors)?, uncertainty.end_coordinates());
        let causes = uncertainty.causes().collect();
        let weakest = OnceLock::new();
        let (uncertainty, machines, errors) = (uncertainty.clone(), machines.clone(), errors.to_vec());
        Ok(Some(Self { uncertainty, machines, errors, ends, end_coordinates, causes, drawn, weakest }))
    }

    /// The same machines with the cause called `name` measured, and how well it is known then ([`Uncertainty::measured`]).
    ///
    /// # Errors
    /// As [`DrawnMachines::new`].
    pub fn measured(&self, name: &str) -> error::Result<Option<(Self, &'static str)>> {
        let Some((uncertainty, known)) = self.uncertainty.measured(name) else { return Ok(None) };
        Ok(Self::new(Some(&uncertainty), &self.machines, &self.errors)?.map(|own| (own, known)))
    }

    /// Returns the surrogate of displacements without load and under each load where this `cut` is made; where components of the force vary by
    /// themselves, of those under a load, and then with each of these components twice.
    ///
    /// # Panics
    /// There are no `responses`.
    pub fn surrogate(&self, responses: &[Response], cut: Cut) -> Surrogate {
        let [unloaded, loads @ ..] = responses else { panic!("a response without load") };
        let with = |loads| Surrogate::new(&self.end_coordinates, unloaded, loads, &self.uncertainty.draws).of_cut(cut);
        match loads.split_at_checked(1) {
            Some((load, twice)) if self.uncertainty.force.has_components() => {
                let varied = self.uncertainty.force.varied_components().map(|(own, _)| own);
                with(load).with_components(&self.end_coordinates, varied.zip(twice))
            }
            _ => with(loads),
        }
    }

    /// Returns what the causes contribute to displacements without load and under `loads` where this `cut` is made.
    pub fn shares(&self, responses: &[Response], cut: Cut) -> Shares {
        self.uncertainty.shares(&self.surrogate(responses, cut))
    }

    /// Names of what spreads displacements without load and under `loads` most where this `cut` is made, with a share of variance worth a measurement.
    pub fn main_causes(&self, responses: &[Response], cut: Cut) -> Vec<&str> {
        let surrogate = self.surrogate(responses, cut);
        let variances = surrogate.variances(&self.uncertainty.draws, self.causes.iter().map(|(_, cause)| cause));
        let least = WORTH_MEASURING * variances.iter().sum::<f64>();
        let causes = self.causes.iter().zip(&variances).filter(|(_, variance)| **variance > least);
        causes.map(|((name, _), _)| name.as_str()).collect()
    }

    /// Whether the model leaves something out, so that displacements without cutting force are needed as well.
    pub fn has_model_error(&self) -> bool {
        !self.uncertainty.draws.model.is_empty()
    }

    /// The displacement `loaded` that the engine found in the draw `index`, with what the model leaves out of it; `free` is that without cutting force, where
    /// the model leaves something out.
    pub fn actual_displacement(&self, index: usize, free: Option<Vector3<f64>>, loaded: Vector3<f64>) -> Vector3<f64> {
        free.map_or(loaded, |free| loaded + self.uncertainty.draws.model_error(index, &(loaded - free)))
    }

    /// Returns what `on` makes of the machines of the draw `index`, which are kept if many points need them.
    pub fn on_draw<T>(&self, index: usize, on: impl FnOnce(&Machines) -> T) -> Result<T, Failure> {
        let make = || self.machines_with(self.uncertainty.values_of_draw(index));
        match &self.drawn[index] {
            Some(kept) => kept.get_or_init(make).as_ref().map(on).map_err(Failure::clone),
            None => make().as_ref().map(on).map_err(Failure::clone),
        }
    }

    /// What `solve` finds in each draw of the first scramble, or why there are no such machines. `Err` if the work is stopped.
    pub fn in_first_scramble<T: Send>(
        &self,
        solve: impl Fn(Draw<'_>) -> error::Result<Result<T, Failure>> + Sync,
    ) -> error::Result<Vec<Result<T, Failure>>> {
        let in_draw = |index: usize| {
            let factor = self.uncertainty.draws.factors(0, index);
            let found = self.on_draw(index, |machines| solve((index, machines, factor)));
            found.unwrap_or_else(|failure| Ok(Err(failure)))
        };
        (0..Draws::PER_SCRAMBLE).into_par_iter().map(in_draw).collect()
    }

    /// Returns `tasks` under the force of the draw `index`, which changes it at each of them as `at` says; everywhere alike where that is empty.
    pub fn under_draw(&self, index: usize, tasks: &[TaskPoint], at: &[DrawnForceAt]) -> Vec<TaskPoint> {
        let under = |(k, task)| {
            let at: DrawnForceAt = at.get(k).copied().unwrap_or_default();
            under_factors(task, &self.uncertainty.draws.factors(at.tool, index), &at)
        };
        tasks.iter().enumerate().map(under).collect()
    }

    /// Makes the machines with these values of parameters.
    fn machines_with(&self, values: [Values<'_>; 2]) -> Result<Machines, Failure> {
        let machines = self.machines.drawn(&self.uncertainty.machine, &values, &self.errors);
        machines.map_err(|error| Failure::no_machine(&error))
    }
}

/// A draw: its number, its machines and its factors of the cutting force.
pub(crate) type Draw<'a> = (usize, &'a Machines, ForceFactors);

/// Size of the deflection at the point with this index in a draw, mm, or why it has none. `Err` if the work is stopped.
type Solve<'a> = dyn Fn(usize, Draw<'_>) -> error::Result<Result<f64, Failure>> + 'a;

/// Deflections at points next to one another whose distributions are wanted.
pub(crate) struct WantedSpread<'a> {
    /// The draws, and machines of them.
    pub drawn: &'a DrawnMachines,
    /// Largest deflection that is within tolerance, mm.
    pub tolerance_mm: Option<f64>,
    /// Who cuts at each point.
    pub cut: &'a dyn Fn(usize) -> Cut,
    /// The engine.
    pub solve: &'a Solve<'a>,
    /// Whether it checks each point, and seeks draws in which the machine falls over; else it only takes the place of missing estimates.
    pub checks: bool,
    /// Most draws solved next to a value, where each takes long.
    pub most_next: Option<usize>,
    /// Draws chosen at random and solved at each point as well.
    pub audits: usize,
    /// A number that no other point has, from which these are chosen.
    pub seed: &'a dyn Fn(usize) -> u64,
}

impl WantedSpread<'_> {
    /// Size at `point` in the draw `index`, mm; `None` if it has none. Counted in `spread`.
    fn solve_draw(&self, point: usize, index: usize, spread: &mut DeflectionSpread) -> error::Result<Option<f64>> {
        let factor = self.drawn.uncertainty.draws.factors((self.cut)(point).tool, index);
        let found = self.drawn.on_draw(index, |machines| (self.solve)(point, (index, machines, factor)));
        let found = found.unwrap_or_else(|failure| Ok(Err(failure)))?;
        spread.solved_draws += 1;
        if let Err(failure) = &found {
            spread.failed_draws += 1;
            spread.first_failure.get_or_insert_with(|| failure.reason.clone());
        }
        Ok(found.ok())
    }

    /// Size at `point` in the draw `index`, mm, solved unless it is in `solved`; `None` if it has none.
    fn solve_once(
        &self,
        point: usize,
        index: usize,
        solved: &mut BTreeMap<usize, Option<f64>>,
        spread: &mut DeflectionSpread,
    ) -> error::Result<Option<f64>> {
        Ok(match solved.entry(index) {
            Entry::Occupied(kept) => *kept.get(),
            Entry::Vacant(place) => *place.insert(self.solve_draw(point, index, spread)?),
        })
    }

    /// Solves at `point`, where the weakest machine falls over, the draws from the weakest on until enough of them stand or too many do not. These have an
    /// infinite size in `sizes`; returns all that were solved.
    fn solve_weakest(
        &self,
        point: usize,
        sizes: &mut [f64],
        spread: &mut DeflectionSpread,
    ) -> error::Result<BTreeMap<usize, Option<f64>>> {
        let (uncertainty, mut solved) = (&self.drawn.uncertainty, BTreeMap::new());
        let make = || {
            let values = uncertainty.weakest_values();
            self.drawn.machines_with([values.iter().map(|(name, value)| (name.as_str(), *value)).collect(), Vec::new()])
        };
        if let Ok(weakest) = self.drawn.weakest.get_or_init(make)
            && (self.solve)(point, (0, weakest, ForceFactors::of_all(1.0)))?.is_ok()
        {
            return Ok(solved);
        }
        'all: for from_weakest in &uncertainty.draws.from_weakest {
            let mut standing = 0;
            for &index in from_weakest {
                if self.solve_once(point, index, &mut solved, spread)?.is_some() {
                    standing += 1;
                } else {
                    (standing, sizes[index]) = (0, f64::INFINITY);
                }
                if spread.failed_draws as f64 > LOST * Draws::COUNT as f64 {
                    break 'all;
                }
                if standing == STANDING {
                    break;
                }
            }
        }
        Ok(solved)
    }

    /// Distribution at each of `points` of the longest of the displacements without load (the first response) and under each load, and its size in the
    /// draws. Where there are no responses, or the engine does not agree with the surrogate of them, by the engine. `None` for points that are `None`.
    pub fn spreads(
        &self,
        points: &[Option<Option<&[Response]>>],
    ) -> error::Result<Vec<Option<(DeflectionSpread, Sizes)>>> {
        let estimate = |(point, responses): (usize, &Option<Option<&[Response]>>)| {
            let Some(Some(responses)) = responses else { return Ok(None) };
            let draws = &self.drawn.uncertainty.draws;
            let surrogate = self.drawn.surrogate(responses, (self.cut)(point));
            let mut sizes = surrogate.largest_displacements(draws, Draws::COUNT);
            if !self.checks {
                return Ok(Some(Estimate::unchecked(point, sizes)));
            }
            let causes = self.drawn.causes.iter().map(|(_, cause)| cause);
            let mut spread = self.spread_with_cause(&surrogate.variances(draws, causes));
            let solved = self.solve_weakest(point, &mut sizes, &mut spread)?;
            self.estimate(point, solved, Cow::Owned(sizes), spread).map(Some)
        };
        let estimates: Vec<_> = points.iter().enumerate().map(estimate).collect::<error::Result<_>>()?;
        let nearby: Vec<f64> = estimates.iter().flatten().filter_map(Estimate::first_share).collect();
        let nearby = root_mean_square(&nearby).filter(|share| nearby.len() >= FEWEST_ALIKE && *share <= CLOSE);
        let finish = |(point, (estimate, wanted)): (usize, (Option<Estimate<'_>>, _))| match (estimate, wanted) {
            (_, &None) => Ok(None),
            (None, _) => self.spread_by_engine(point, DeflectionSpread::default(), &BTreeMap::new()).map(Some),
            (Some(mut own), _) => match self.correct(&mut own, nearby)? {
                true => {
                    own.spread.audit = self.audit(&own)?;
                    Ok(Some((own.spread, Sizes { mm: own.sizes.into_owned(), is_by_engine: false })))
                }
                false => self.spread_by_engine(point, own.spread, &own.solved).map(Some),
            },
        };
        estimates.into_iter().zip(points).enumerate().map(finish).collect()
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

    /// Distribution of `sizes` at the first point in the draws (infinite without equilibrium), begun as `spread`: checked, and corrected where the
    /// engine differs. Returns also whether the engine agrees or corrected it.
    pub fn check(&self, sizes: &[f64], spread: DeflectionSpread) -> error::Result<(DeflectionSpread, bool)> {
        let mut own = self.estimate(0, BTreeMap::new(), Cow::Borrowed(sizes), spread)?;
        let agrees = self.correct(&mut own, None)?;
        Ok((own.spread, agrees))
    }

    /// The distribution of `sizes` at `point`, where the engine has `solved` some draws, begun as `spread`, with a draw next to its 95 % quantile solved by it.
    fn estimate<'s>(
        &self,
        point: usize,
        solved: BTreeMap<usize, Option<f64>>,
        sizes: Cow<'s, [f64]>,
        mut spread: DeflectionSpread,
    ) -> error::Result<Estimate<'s>> {
        let quantiles = Quantiles::of(&sizes);
        spread.fill(quantiles.median, quantiles.p95, quantiles.p95_standard_error);
        spread.within_tolerance = self.tolerance_mm.map(|tolerance| share_within(&sizes, tolerance));
        spread.failed_share = 1.0 - share_within(&sizes, f64::MAX);
        let mut own = Estimate { point, sizes, quantiles, spread, solved };
        if own.is_checked() {
            let order = own.in_order(Draws::PER_SCRAMBLE);
            let nearest = own.next_to(&order, quantiles.p95, FEWEST_NEXT);
            let first = nearest.first().map(|index| self.difference(*index, &mut own)).transpose()?.flatten();
            own.spread.check_difference = first.map(|difference| difference / quantiles.p95);
        }
        Ok(own)
    }

    /// Solves draws of `estimate` at its point with the engine, chosen at random by the seed of the point, and counts how far the estimate is off; differences
    /// not where it has been corrected. No draws where the 95 % quantile is zero or infinite. `Err` where the work is stopped.
    fn audit(&self, estimate: &Estimate<'_>) -> error::Result<Audit> {
        let Estimate { point, sizes, quantiles: Quantiles { p95, .. }, spread, .. } = estimate;
        let mut audit = Audit::default();
        let mut random = Xoshiro256PlusPlus::seed_from_u64((self.seed)(*point));
        while estimate.is_checked() && audit.draws < self.audits {
            let index = random.random_range(0..sizes.len());
            let known = estimate.solved.get(&index).copied();
            let solved = match known {
                Some(size) => size,
                None => self.solve_draw(*point, index, &mut DeflectionSpread::default())?,
            };
            let compared = solved.filter(|_| !spread.is_corrected);
            let largest = compared.map_or(0.0, |size| share_of(size - sizes[index], *p95).abs());
            let [failed, apart, compared] = [solved.is_none(), largest > APART, compared.is_some()].map(usize::from);
            let unforeseen = failed * usize::from(sizes[index].is_finite());
            audit.add(&Audit { draws: 1, failed, unforeseen, compared, apart, largest });
        }
        Ok(audit)
    }

    /// Engine less surrogate in the draw `index`, mm, solved once; `None` where the engine has no equilibrium.
    fn difference(&self, index: usize, estimate: &mut Estimate<'_>) -> error::Result<Option<f64>> {
        let solved = self.solve_once(estimate.point, index, &mut estimate.solved, &mut estimate.spread)?;
        Ok(solved.map(|size| size - estimate.sizes[index]))
    }

    /// Where the engine differs at the 95 % quantile of `estimate`, moves quantiles and probability by the differences in draws next to each; a single draw
    /// shows that it agrees where `nearby` says that it does at the points next to it ([`Self::differences_next_to`]). Returns whether the engine agrees or corrected
    /// them: not where these differences are too different, or one has no equilibrium.
    fn correct(&self, estimate: &mut Estimate<'_>, nearby: Option<f64>) -> error::Result<bool> {
        if estimate.spread.failed_share > LOST {
            return Ok(false);
        }
        if !estimate.is_checked() {
            return Ok(true);
        }
        let Quantiles { median, p95, p95_standard_error } = estimate.quantiles;
        let (few, all, count) = (estimate.in_order(Draws::PER_SCRAMBLE), OnceCell::new(), estimate.sizes.len());
        let found_at = |estimate: &mut Estimate<'_>, value: f64, nearby: Option<f64>, is_known: &IsKnown<'_>| {
            let most_next = self.most_next.unwrap_or(usize::MAX).max(FEWEST_NEXT);
            let [most, most_of_all] = MAX_NEXT.map(|most| most.min(most_next));
            let nearest = estimate.next_to(&few, value, most);
            match self.differences_next_to(&nearest, true, nearby, is_known, estimate)? {
                // What has just been seen to differ does not agree after all, and no draw that has a size turned out to have no equilibrium.
                None if estimate.solved.iter().all(|own| own.1.is_some() || estimate.sizes[*own.0].is_infinite()) => {
                    let all = all.get_or_init(|| estimate.in_order(count));
                    let nearest = estimate.next_to(all, value, most_of_all);
                    self.differences_next_to(&nearest, false, None, is_known, estimate)
                }
                found => Ok(found),
            }
        };
        // At last: solving all draws instead would leave the error by their number.
        let largest_error = [0.0, 2.0 * p95_standard_error].map(|own| own.max(LARGEST_ERROR * p95).max(CLOSE_MM));
        let is_small = |found: &[f64], is_last: bool| mean_and_error(found).1 <= largest_error[usize::from(is_last)];
        let by_p95 = match found_at(estimate, p95, nearby, &is_small)? {
            None => return Ok(false),
            Some(Found::Agrees { error_mm }) => {
                estimate.spread.fill(median, p95, libm::hypot(p95_standard_error, error_mm));
                return Ok(true);
            }
            // Next to draws that fall over, differences grow with the size.
            Some(Found::Differs(_)) if estimate.spread.failed_share > FEW_FAILED => return Ok(false),
            Some(Found::Differs(found)) => found,
        };
        let Some(by_median) = found_at(estimate, median, None, &is_small)? else { return Ok(false) };
        if let Some(tolerance) = self.tolerance_mm {
            let mut sorted = estimate.sizes.to_vec();
            sorted.sort_by(f64::total_cmp);
            let within = |by: &[f64], tolerance: f64| {
                let each = by.iter().map(|difference| sorted.partition_point(|size| size + difference <= tolerance));
                each.sum::<usize>() as f64 / (count * by.len()) as f64
            };
            // Far from all draws it changes nothing.
            let is_sure = |found: &[f64], _| {
                let (_, error_mm) = mean_and_error(found);
                let [most, least] = [1.0, -1.0].map(|sign| within(found, tolerance + sign * error_mm));
                most - least <= LARGEST_PROBABILITY_ERROR
            };
            let Some(found) = found_at(estimate, tolerance, None, &is_sure)? else { return Ok(false) };
            estimate.spread.within_tolerance = Some(within(found.differences(), tolerance));
        }
        let moved = |by: &[f64], share| {
            let sizes = estimate.sizes.iter().flat_map(|size| by.iter().map(move |difference| size + difference));
            quantile(&mut sizes.collect::<Vec<f64>>(), share)
        };
        let (median, error_mm) = (moved(by_median.differences(), 0.5), mean_and_error(&by_p95).1);
        let p95 = moved(&by_p95, P95);
        estimate.spread.fill(median, p95, libm::hypot(p95_standard_error, error_mm));
        estimate.spread.is_corrected = true;
        Ok(true)
    }

    /// What the engine says in the draws `nearest` to a value, on both sides of it. It agrees, if it `may`, where four of them are
    /// close, or one where `nearby`, the root mean square of the first differences at points next to it as shares of their quantiles, is. `None` where
    /// differences are not known well enough after so many draws, or one has no equilibrium.
    fn differences_next_to(
        &self,
        nearest: &[usize],
        may_agree: bool,
        nearby: Option<f64>,
        is_known: &IsKnown<'_>,
        estimate: &mut Estimate<'_>,
    ) -> error::Result<Option<Found>> {
        let p95 = estimate.quantiles.p95;
        let (mut differences, mut shares): (Vec<f64>, Vec<f64>) = (Vec::new(), Vec::new());
        for &index in nearest {
            let Some(difference) = self.difference(index, estimate)? else { return Ok(None) };
            differences.push(difference);
            shares.push(share_of(difference, p95));
            let is_close = may_agree && shares.iter().all(|share| share.abs() <= CLOSE);
            let error = nearby.or_else(|| root_mean_square(&shares).filter(|_| shares.len() >= FEWEST_ALIKE));
            if let Some(error) = error.filter(|_| is_close) {
                return Ok(Some(Found::Agrees { error_mm: error * p95 }));
            }
            let is_last = !may_agree && differences.len() == nearest.len();
            if differences.len() >= FEWEST_NEXT && is_known(&differences, is_last) {
                return Ok(Some(Found::Differs(differences)));
            }
        }
        Ok(None)
    }

    /// Fills `spread` at `point` by draws of the engine, scramble after scramble, until the 95 % quantile is known well enough; returns their sizes as well.
    /// Those that are `known` are not solved again.
    fn spread_by_engine(
        &self,
        point: usize,
        spread: DeflectionSpread,
        known: &BTreeMap<usize, Option<f64>>,
    ) -> error::Result<(DeflectionSpread, Sizes)> {
        let mut spread = DeflectionSpread { solved_draws: 0, failed_draws: 0, is_corrected: true, ..spread };
        let mut solved: Vec<f64> = Vec::new();
        let quantiles = loop {
            for index in solved.len()..solved.len() + Draws::PER_SCRAMBLE {
                let size = match known.get(&index) {
                    None => self.solve_draw(point, index, &mut spread)?,
                    Some(size) => {
                        spread.solved_draws += 1;
                        spread.failed_draws += usize::from(size.is_none());
                        *size
                    }
                };
                solved.push(size.unwrap_or(f64::INFINITY));
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
        // The weakest draws may be beyond those that were solved here.
        let known = known.values().filter(|size| size.is_none()).count() as f64 / Draws::COUNT as f64;
        spread.failed_share = known.max(1.0 - share_within(&solved, f64::MAX));
        Ok((spread, Sizes { mm: solved, is_by_engine: true }))
    }
}

impl DeflectionSpread {
    /// Distribution of the sizes in the draws of the first scramble, mm, all solved, or why there is none.
    pub(crate) fn of_solved(found: &[Result<f64, Failure>], tolerance_mm: Option<f64>) -> Self {
        let sizes: Vec<f64> = found.iter().map(|own| *own.as_ref().unwrap_or(&f64::INFINITY)).collect();
        let mut spread = Self {
            within_tolerance: tolerance_mm.map(|tolerance| share_within(&sizes, tolerance)),
            solved_draws: sizes.len(),
            failed_draws: found.iter().filter(|own| own.is_err()).count(),
            failed_share: 1.0 - share_within(&sizes, f64::MAX),
            first_failure: found.iter().find_map(|own| Some(own.as_ref().err()?.reason.clone())),
            ..Self::default()
        };
        let Quantiles { median, p95, .. } = Quantiles::of(&sizes);
        // Of one scramble there is no spread over scrambles.
        spread.fill(median, p95, f64::NAN);
        spread
    }

    /// Why there is no 95 % quantile; `None` where there is one.
    pub fn reason(&self) -> Option<String> {
        let Self { p95_mm: None, failed_share, first_failure, .. } = self else { return None };
        let first = first_failure.as_deref().unwrap_or_default();
        Some(format!("{:.1} % of the draws have no equilibrium; the first: {first}", 100.0 * failed_share))
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

/// Whether differences of engine and surrogate in some draws say enough, and whether there are no more.
type IsKnown<'a> = dyn Fn(&[f64], bool) -> bool + 'a;

/// What draws of the engine say of an estimate.
enum Found {
    /// It agrees; the estimate may be off by so much, mm.
    Agrees { error_mm: f64 },
    /// Engine less surrogate in each, mm.
    Differs(Vec<f64>),
}

impl Found {
    /// Differences by which the estimate is moved, mm.
    fn differences(&self) -> &[f64] {
        match self {
            Self::Agrees { .. } => &[0.0],
            Self::Differs(found) => found,
        }
    }
}

/// A distribution by the surrogate.
struct Estimate<'a> {
    point: usize,
    /// Sizes in the draws, mm.
    sizes: Cow<'a, [f64]>,
    quantiles: Quantiles,
    spread: DeflectionSpread,
    /// Sizes by the engine in draws, mm; `None` without equilibrium.
    solved: BTreeMap<usize, Option<f64>>,
}

impl Estimate<'_> {
    /// The sizes alone, of which there is nothing to check.
    fn unchecked(point: usize, sizes: Vec<f64>) -> Self {
        let quantiles = Quantiles { median: 0.0, p95: 0.0, p95_standard_error: 0.0 };
        let (spread, solved) = (DeflectionSpread::default(), BTreeMap::new());
        Self { point, sizes: Cow::Owned(sizes), quantiles, spread, solved }
    }

    /// Whether there is something to check.
    fn is_checked(&self) -> bool {
        self.quantiles.p95 > ROUNDING_MM && self.quantiles.p95.is_finite()
    }

    /// The first of `draws` draws by ascending size.
    fn in_order(&self, draws: usize) -> Vec<usize> {
        let mut order: Vec<usize> = (0..draws).filter(|index| self.sizes[*index].is_finite()).collect();
        order.sort_by(|a, b| self.sizes[*a].total_cmp(&self.sizes[*b]));
        order
    }

    /// The `most` draws of `order`, by ascending size, next to `value`: by turns above and below it, on one side alone behind the last of the other. Points
    /// begin with different ones, so that a draw that agrees by chance does not speak for all.
    fn next_to(&self, order: &[usize], value: f64, most: usize) -> Vec<usize> {
        let middle = order.partition_point(|index| self.sizes[*index] < value);
        let (mut below, mut above) = (order[..middle].iter().rev(), order[middle..].iter());
        let nearest = (0..order.len()).map_while(|turn| match turn % 2 {
            0 => above.next().or_else(|| below.next()),
            _ => below.next().or_else(|| above.next()),
        });
        let mut nearest: Vec<usize> = nearest.take(most).copied().collect();
        let few = nearest.len().min(FEWEST_NEXT);
        nearest[..few].rotate_left(self.point % few.max(1));
        nearest
    }

    /// Difference in the first draw solved as a share of the 95 % quantile, infinite where that has no equilibrium; `None` where nothing is to check.
    fn first_share(&self) -> Option<f64> {
        let p95 = self.quantiles.p95;
        let share = self.spread.check_difference.map_or(f64::INFINITY, |share| share_of(share * p95, p95));
        self.is_checked().then_some(share)
    }
}

/// `difference` as a share of `p95`: none where it is too small to matter.
fn share_of(difference: f64, p95: f64) -> f64 {
    if difference.abs() <= CLOSE_MM { 0.0 } else { difference / p95 }
}

/// The task of all sources with the cutting force times `factor`.
pub(crate) fn under(task: &TaskPoint, factor: f64) -> TaskPoint {
    under_factors(task, &ForceFactors::of_all(factor), &DrawnForceAt::default())
}

/// The task of all sources where the cutting force, which is composed as `at` says, has these factors.
pub(crate) fn under_factors(task: &TaskPoint, factors: &ForceFactors, at: &DrawnForceAt) -> TaskPoint {
    let task = Source::All.task(task);
    TaskPoint { load: factors.on(&task.load, &at.components), ..task }
}

/// Root of the mean of the squares of `values`; `None` for none.
fn root_mean_square(values: &[f64]) -> Option<f64> {
    let squares: f64 = values.iter().map(|value| value * value).sum();
    (!values.is_empty()).then(|| (squares / values.len() as f64).sqrt())
}

/// Share of `sizes` that are at most `tolerance`.
pub(crate) fn share_within(sizes: &[f64], tolerance: f64) -> f64 {
    sizes.iter().filter(|size| **size <= tolerance).count() as f64 / sizes.len() as f64
}
