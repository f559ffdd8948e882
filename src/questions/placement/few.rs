//! Searches on few points of the paths: a largest or smallest value lies at one of them.
//!
//! A search looks at the first level of points and at those at which a value was largest so far. What it minimises is then a lower bound of the
//! objective, which is exact where the largest value is at one of them. Where it ends all points are looked at; one that is worse is looked at
//! from then on, and the search goes on.

use std::{
    collections::{BTreeSet, HashMap},
    sync::{Mutex, PoisonError},
};

use super::{
    Evaluator, FeatureJob, Metric, Metrics, PlacementStudy, Site,
    evaluate::{Evaluation, track_feature},
    polish::{Steps, pattern_search},
    tally::PointValues,
    turned::Setup,
    walk::ExactMode,
};
use crate::{compensation::TaskPoint, process::Feature, simulation::Failure, work::Work};

/// Points of each feature that a search looks at, and what evaluates places by them.
#[derive(Debug)]
struct FewPoints {
    evaluator: Evaluator,
    /// Their indices in path order, for each feature.
    points: Vec<BTreeSet<usize>>,
    /// Whether they must have a correction, also where no metric needs one.
    corrects: bool,
    /// All that in words, which tell pieces of work of these points from those of others.
    name: String,
}

/// Fewest points of which it is worth while to look at few.
const MANY: usize = 64;
/// Largest number of pattern searches that polish an end, each of which looks at more points.
const POLISH_ROUNDS: usize = 8;
/// Most points of which few are looked at.
const MOST_POINTS: usize = 64;

impl FewPoints {
    /// Takes the first level of points of `all`, and those that are worst at `site` and at these `corners` of its allowance; `None` where the objective
    /// is of no largest or smallest values, points are few, or they may take a γ for a front at which a metric is no bound.
    pub fn new(all: &Evaluator, site: &Site, corners: &[usize]) -> Option<Self> {
        let objective = &all.study.objective;
        let is_extreme = objective.metrics().iter().all(|metric| of_point(*metric).is_some());
        let count: usize = all.features.iter().map(|feature| feature.counted.len()).sum();
        let is_bound = objective.pareto.is_empty() || !all.study.seeks_gamma();
        if !is_extreme || !is_bound || count < MANY {
            return None;
        }
        let first = |feature: &super::evaluate::PreparedFeature| feature.levels[0].iter().copied().collect();
        let mut points: Vec<BTreeSet<usize>> = all.features.iter().map(first).collect();
        add_worst(all, &all.setup(site), corners, false, &mut points);
        Some(Self::of(all, points, false))
    }

    fn of(all: &Evaluator, points: Vec<BTreeSet<usize>>, corrects: bool) -> Self {
        let features = all.study.features.iter().zip(&points).zip(&all.features);
        let features = features.map(|((job, points), prepared)| job.at_points(points, &prepared.levels[0]));
        // Of no ways between these points.
        let study = PlacementStudy { features: features.collect(), ..all.study.clone() };
        let mut evaluator = Evaluator::new(&study, &study.objective.metrics());
        if !corrects && !evaluator.needs.correction {
            evaluator.exact = ExactMode::NotAsked;
        }
        let name = format!("points {points:?}, corrects {corrects}").replace(' ', "");
        Self { evaluator, points, corrects, name }
    }

    /// Returns these points and those that are worst at each of `setups` and at `corners` of their allowances, or that refuse one that `is_refused`;
    /// `None` if all of them are known, or these would be too many.
    pub fn with_worst(&self, all: &Evaluator, setups: &[Setup], corners: &[usize], is_refused: bool) -> Option<Self> {
        let mut points = self.points.clone();
        setups.iter().for_each(|setup| add_worst(all, setup, corners, is_refused, &mut points));
        let count: usize = points.iter().map(BTreeSet::len).sum();
        let corrects = self.corrects || is_refused && !all.needs.correction;
        let is_new = points != self.points || corrects != self.corrects;
        if is_new && count <= MOST_POINTS { Some(Self::of(all, points, corrects)) } else { None }
    }
}

/// Place and corner of its allowance, `None` exactly there.
type Clamped = ([u64; 6], Option<usize>);

/// Points and corners that a search looks at instead of all: what they tell of a place is a lower bound.
pub(super) struct Glimpse<'a> {
    all: &'a Evaluator,
    value: &'a (dyn Fn(&Metrics) -> f64 + Sync),
    /// `None`: all points.
    few: Option<FewPoints>,
    corners: Vec<usize>,
    /// What all points tell of where the workpiece may be clamped.
    known: Mutex<HashMap<Clamped, Result<Evaluation, Failure>>>,
}

impl<'a> Glimpse<'a> {
    /// Takes the points and the corner at which `value` of the metrics is worst at `site`.
    pub fn new(all: &'a Evaluator, work: &Work, site: &Site, value: &'a (dyn Fn(&Metrics) -> f64 + Sync)) -> Self {
        let mut own = Self { all, value, few: None, corners: Vec::new(), known: Mutex::default() };
        if work.check().is_ok() {
            own.corners.extend(own.worst_corner(site));
            own.few = FewPoints::new(all, site, &own.corners);
        }
        own
    }

    /// Evaluates all points of `setup` exactly there, or at this `corner` of its allowance.
    fn clamped(&self, setup: &Setup, corner: Option<usize>) -> Result<Evaluation, Failure> {
        let known = || self.known.lock().unwrap_or_else(PoisonError::into_inner);
        let key = (setup.site.0.map(f64::to_bits), corner);
        let found = known().get(&key).cloned();
        found.unwrap_or_else(|| {
            let found = self.all.evaluate_clamped(setup, corner);
            known().insert(key, found.clone());
            found
        })
    }

    /// Returns how `site` is cut, and the worst metrics of it and the corners that are looked at; `None` if it cannot be cut there.
    fn among(&self, site: &Site) -> Option<(Setup, Metrics)> {
        let setup = self.all.begin_evaluation(site).ok()?.setup;
        let corners = self.corners.iter().map(|&corner| Some(corner));
        let mut all = std::iter::once(None).chain(corners).map(|corner| self.clamped(&setup, corner));
        let first = all.next()?.ok()?.metrics;
        let worst = all.try_fold(first, |worst, own| Some(worst.worse_of(&own.ok()?.metrics)))?;
        Some((setup, worst))
    }

    /// Returns the corner that makes `site` worst beside those that are looked at, the first of equal ones or at which it cannot be cut.
    fn worst_corner(&self, site: &Site) -> Option<usize> {
        let (setup, known) = self.among(site)?;
        let mut worst: Option<(f64, usize)> = None;
        for corner in self.all.corners().filter(|corner| !self.corners.contains(corner)) {
            let Ok(own) = self.clamped(&setup, Some(corner)) else { return Some(corner) };
            let value = (self.value)(&known.worse_of(&own.metrics));
            if worst.is_none_or(|(most, _)| value > most) {
                worst = Some((value, corner));
            }
        }
        worst.map(|(_, corner)| corner)
    }

    /// Returns whether it is of all points and corners.
    pub fn is_whole(&self) -> bool {
        self.few.is_none() && self.corners.len() == self.all.corners().len()
    }

    /// Evaluates `site` at all points within its whole allowance. `Err` says why it cannot be cut.
    pub fn evaluate(&self, work: &Work, site: &Site) -> Result<Evaluation, Failure> {
        let corners: Vec<usize> = self.all.corners().collect();
        self.all.evaluate_among_in_work(work, site, &corners, |setup, corner| self.clamped(setup, corner))
    }

    /// Returns bounds of the metrics at `site`; `None` if it cannot be cut.
    pub fn metrics(&self, work: &Work, site: &Site) -> Option<Metrics> {
        let (all, work) = match &self.few {
            Some(few) => (&few.evaluator, &work.part(&few.name)),
            None => (self.all, work),
        };
        let evaluate = |setup: &Setup, corner| all.evaluate_clamped(setup, corner);
        all.evaluate_among_in_work(work, site, &self.corners, evaluate).ok().map(|own| own.metrics)
    }

    /// Returns a bound of the value at `site`, infinite where it cannot be cut, or anything that is not less than `below`.
    fn bound_below(&self, work: &Work, site: &Site, below: f64) -> f64 {
        let metrics = match self.few {
            Some(_) => self.metrics(work, site),
            None => {
                let found = self.all.evaluate_below_in_work(work, (site, &self.corners), self.value, below);
                found.map(|own| own.metrics)
            }
        };
        metrics.as_ref().map_or(f64::INFINITY, self.value)
    }

    /// Improves `start`, a place and its value, by pattern searches until all points and corners say what these do of its end, up to `tolerance`; calls
    /// `found` with each better place, its value and metrics.
    pub fn polish(
        &mut self,
        (study, work): (&PlacementStudy, &Work),
        start: (Site, f64),
        (steps, tolerance): (Steps, f64),
        mut found: impl FnMut(Site, f64, Metrics),
    ) {
        let mut best = start;
        for _ in 0..POLISH_ROUNDS {
            let bound = |site: &Site, below| self.bound_below(work, site, below);
            let (end, told) = pattern_search(study, best, steps, f64::NEG_INFINITY, bound);
            if end == best.0 {
                break;
            }
            let metrics = self.evaluate(work, &end).ok().map(|own| own.metrics);
            let value = metrics.as_ref().map_or(f64::INFINITY, self.value);
            if let Some(metrics) = metrics.filter(|_| value < best.1) {
                best = (end, value);
                found(end, value, metrics);
            }
            if self.settle(work, &end, told, value, tolerance) {
                break;
            }
        }
    }

    /// Takes what makes `site` worse than these points and corners `told`, of value `whole`; returns whether nothing does by more than `tolerance`.
    pub fn settle(&mut self, work: &Work, site: &Site, told: f64, whole: f64, tolerance: f64) -> bool {
        if whole <= told + tolerance || work.check().is_err() {
            return true;
        }
        let known = self.among(site);
        let among = known.as_ref().map_or(f64::INFINITY, |(_, metrics)| (self.value)(metrics));
        let mut is_exact = true;
        if let Some(few) = self.few.as_ref().filter(|_| among > told + tolerance) {
            // That it cannot be cut may be due to what no point tells: bodies, ways between points.
            let setups = [few.evaluator.setup(site), self.all.setup(site)];
            self.few = few.with_worst(self.all, &setups, &self.corners, known.is_none());
            is_exact = false;
        }
        if whole > among + tolerance
            && let Some(corner) = self.worst_corner(site)
        {
            self.corners.push(corner);
            is_exact = false;
        }
        is_exact
    }
}

/// Adds the points that are worst at `setup` and at `corners` of its allowance to `points`, or those that refuse it if it `is_refused`.
fn add_worst(all: &Evaluator, setup: &Setup, corners: &[usize], is_refused: bool, points: &mut [BTreeSet<usize>]) {
    let setups = all.clamped_setups(setup);
    for setup in std::iter::once(0).chain(corners.iter().map(|corner| 1 + corner)).map(|clamped| &setups[clamped]) {
        for (f, points) in points.iter_mut().enumerate() {
            let tasks = all.tasks(setup, f);
            let refused = if is_refused { refused_point(all, (&setup.site, f), &tasks) } else { None };
            match refused {
                Some(point) => points.extend([point]),
                None => points.extend(worst_points(all, (&setup.site, f), &tasks)),
            }
        }
    }
}

/// Returns the first point of `tasks`, the path of a feature at a place, that alone tells that it cannot be cut there.
fn refused_point(all: &Evaluator, place: (&Site, usize), tasks: &[TaskPoint]) -> Option<usize> {
    let (prepared, job) = (&all.features[place.1], &all.study.features[place.1]);
    let is_outside = |task: &TaskPoint| all.study.machine.outside_workspace(task.pose.translation).is_some();
    let out_of_reach = || {
        let mut left = (0..tasks.len()).filter(|&k| !prepared.is_counted[k]);
        let passed = |_, _: &_| {
            left.next();
            Ok(())
        };
        let tracked = track_feature(job, tasks, |k| !prepared.is_counted[k], passed);
        tracked.err().and(left.next())
    };
    let refused = || all.solve_points_of(place, tasks, &prepared.counted, &mut None).err().map(|(k, _)| k);
    tasks.iter().position(is_outside).or_else(out_of_reach).or_else(refused)
}

/// Returns the point of `tasks`, the path of a feature at a place, at which each metric of the objective is worst, or the first that cannot be cut.
fn worst_points(all: &Evaluator, place: (&Site, usize), tasks: &[TaskPoint]) -> Vec<usize> {
    let counted = &all.features[place.1].counted;
    let values = match all.solve_plain_points_of(place, tasks, counted) {
        Ok(values) => values,
        Err((refused, _)) => return vec![refused],
    };
    let worst = |metric: Metric| {
        let value = of_point(metric)?;
        let largest = values.iter().zip(counted).max_by(|a, b| value(a.0).total_cmp(&value(b.0)));
        largest.map(|(_, &k)| k)
    };
    all.study.objective.metrics().into_iter().filter_map(worst).collect()
}

/// Returns what of a point a metric is the largest of, negative where it is the smallest; `None` where it is no such value of single points.
fn of_point(metric: Metric) -> Option<fn(&PointValues) -> f64> {
    match metric {
        Metric::WorstDeflection => Some(|own| own.deflection),
        Metric::WorstAcrossPath => Some(|own| own.across[0]),
        Metric::WorstAcrossSurface => Some(|own| own.across[1]),
        Metric::WorstCorrection => Some(|own| own.correction),
        Metric::WorstDriveForce => Some(|own| own.force),
        Metric::WorstRotaryCorrection => Some(|own| own.revolute.map_or(0.0, |own| own[0])),
        Metric::WorstRotaryTorque => Some(|own| own.revolute.map_or(0.0, |own| own[1])),
        Metric::SuperpositionError => Some(|own| own.superposition_error),
        Metric::ForceMargin => Some(|own| -own.margin.unwrap_or(f64::INFINITY)),
        Metric::StabilityMargin => Some(|own| -own.stability.unwrap_or(f64::INFINITY)),
        _ => None,
    }
}

impl FeatureJob {
    /// Returns the feature with these points of its path (indices in path order) alone, of which others than `first` were the worst somewhere.
    fn at_points(&self, points: &BTreeSet<usize>, first: &[usize]) -> Self {
        let worst = points.iter().enumerate().filter(|(_, point)| !first.contains(point));
        let worst = Some(worst.map(|(own, _)| own).collect());
        let indices: Vec<usize> = points.iter().copied().collect();
        let of = |loads: &Vec<_>| indices.iter().map(|&k| loads[k]).collect();
        let own = &self.feature;
        let feature = Feature { path: own.path.at_points(&indices), loads: of(&own.loads), ..own.clone() };
        Self {
            feature,
            components: None,
            worst,
            #[cfg(not(target_family = "wasm"))]
            bodies: None,
            ..self.clone()
        }
    }
}
