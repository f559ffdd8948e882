//! Searches on few points of the paths: a largest or smallest value lies at one of them.
//!
//! A search looks at the first level of points and at those at which a value was largest so far. What it minimises is then a lower bound of the
//! objective, which is exact where the largest value is at one of them. Where it ends all points are looked at; one that is worse is looked at
//! from then on, and the search goes on.

use std::collections::BTreeSet;

use super::{
    Evaluator, FeatureJob, Metric, Metrics, PlacementStudy, Site, evaluate::Evaluation, tally::PointValues,
    turned::Setup,
};
use crate::{process::Feature, work::Work};

/// Points of each feature that a search looks at, and what evaluates places by them.
#[derive(Debug)]
struct FewPoints {
    evaluator: Evaluator,
    /// Their indices in path order, for each feature.
    points: Vec<BTreeSet<usize>>,
    /// Their indices in words, which tell pieces of work of these points from those of others.
    name: String,
}

/// Fewest points of which it is worth while to look at few.
const MANY: usize = 64;
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
        add_worst(all, &all.setup(site), corners, &mut points);
        Some(Self::of(all, points))
    }

    fn of(all: &Evaluator, points: Vec<BTreeSet<usize>>) -> Self {
        let study = all.study.at_points(&points);
        let name = format!("points {points:?}").replace(' ', "");
        Self { evaluator: Evaluator::new(&study, &study.objective.metrics()), points, name }
    }

    /// Returns these points and those that are worst at each of `setups` and at `corners` of their allowances; `None` if all of them are known, or
    /// these would be too many.
    pub fn with_worst(&self, all: &Evaluator, setups: &[Setup], corners: &[usize]) -> Option<Self> {
        let mut points = self.points.clone();
        setups.iter().for_each(|setup| add_worst(all, setup, corners, &mut points));
        let count: usize = points.iter().map(BTreeSet::len).sum();
        if points == self.points || count > MOST_POINTS { None } else { Some(Self::of(all, points)) }
    }
}

/// Points and corners that a search looks at instead of all: what they tell of a place is a lower bound.
pub(super) struct Glimpse<'a> {
    all: &'a Evaluator,
    value: &'a (dyn Fn(&Metrics) -> f64 + Sync),
    /// Whether the value is the objective of the study, which every γ has bounds of.
    pub is_objective: bool,
    /// `None`: all points.
    few: Option<FewPoints>,
    corners: Vec<usize>,
}

impl<'a> Glimpse<'a> {
    /// Takes the points and the corner at which `value` of the metrics is worst at `site`.
    pub fn new(all: &'a Evaluator, work: &Work, site: &Site, value: &'a (dyn Fn(&Metrics) -> f64 + Sync)) -> Self {
        if work.check().is_err() {
            return Self { all, value, is_objective: false, few: None, corners: Vec::new() };
        }
        let mut own = Self { all, value, is_objective: false, few: None, corners: Vec::new() };
        own.corners.extend(own.worst_corner(site));
        own.few = FewPoints::new(all, site, &own.corners);
        own
    }

    /// Returns the corner that makes `site` worst beside those that are looked at.
    fn worst_corner(&self, site: &Site) -> Option<usize> {
        let known = self.all.evaluate_among(site, &self.corners).ok()?;
        self.all.corner_beyond(site, &self.corners, &known.metrics, self.value)
    }

    /// Returns whether it is of all points and corners.
    pub fn is_whole(&self) -> bool {
        self.few.is_none() && self.corners.len() == self.all.corners().len()
    }

    /// Returns bounds of the metrics at `site`; `None` if it cannot be cut.
    pub fn metrics(&self, work: &Work, site: &Site) -> Option<Metrics> {
        let found = match &self.few {
            Some(few) => few.evaluator.evaluate_among_in_work(&work.part(&few.name), site, &self.corners),
            None => self.all.evaluate_among_in_work(work, site, &self.corners),
        };
        found.ok().map(|own| own.metrics)
    }

    /// Evaluates `site`; `None` where the value is not less than `below`, as these points and corners tell, or what they then learn of it.
    pub fn evaluate_below(&mut self, work: &Work, site: &Site, below: f64) -> Option<Evaluation> {
        let may_be = |own: Metrics| (self.value)(&own) < below;
        if self.few.is_some() && !self.metrics(work, site).is_some_and(may_be) {
            return None;
        }
        let at_no_gamma = self.is_objective && !self.all.may_be_below(site, below);
        let evaluate = || self.all.evaluate_below_in_work(work, site, self.value, below);
        let found = if at_no_gamma { None } else { evaluate() };
        if let (None, Some(few), true) = (&found, &self.few, work.check().is_ok()) {
            // What tells it of the next place, too.
            match few.with_worst(self.all, &[few.evaluator.setup(site)], &self.corners) {
                Some(next) => self.few = Some(next),
                None => self.corners.extend(self.worst_corner(site)),
            }
        }
        found
    }

    /// Takes what makes `site` worse than these points and corners `told`, of value `whole`; returns whether nothing does by more than `tolerance`.
    pub fn settle(&mut self, work: &Work, site: &Site, told: f64, whole: f64, tolerance: f64) -> bool {
        if whole <= told + tolerance || work.check().is_err() {
            return true;
        }
        let known = self.all.evaluate_among(site, &self.corners).ok();
        let among = known.as_ref().map_or(f64::INFINITY, |own| (self.value)(&own.metrics));
        let mut is_exact = true;
        if let Some(few) = self.few.as_ref().filter(|_| among > told + tolerance) {
            // That it cannot be cut may be due to what no point tells: bodies, ways between points.
            self.few = few.with_worst(self.all, &[few.evaluator.setup(site), self.all.setup(site)], &self.corners);
            is_exact = false;
        }
        if whole > among + tolerance
            && let Some(known) = &known
            && let Some(corner) = self.all.corner_beyond(site, &self.corners, &known.metrics, self.value)
        {
            self.corners.push(corner);
            is_exact = false;
        }
        is_exact
    }
}

/// Adds the points that are worst at `setup` and at `corners` of its allowance to `points`.
fn add_worst(all: &Evaluator, setup: &Setup, corners: &[usize], points: &mut [BTreeSet<usize>]) {
    let setups = all.clamped_setups(setup);
    for setup in std::iter::once(0).chain(corners.iter().map(|corner| 1 + corner)).map(|clamped| &setups[clamped]) {
        for (f, points) in points.iter_mut().enumerate() {
            points.extend(worst_points(all, setup, f));
        }
    }
}

/// Returns the point of feature `f` at which each metric of the objective is worst at `setup`, or the first at which the workpiece cannot be cut.
fn worst_points(all: &Evaluator, setup: &Setup, f: usize) -> Vec<usize> {
    let counted = &all.features[f].counted;
    let values = match all.solve_plain_points_of((&setup.site, f), &all.tasks(setup, f), counted) {
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

impl PlacementStudy {
    /// Returns the study of these points of each feature (indices in path order) alone: of no ways between them.
    fn at_points(&self, points: &[BTreeSet<usize>]) -> Self {
        let features = self.features.iter().zip(points).map(|(job, points)| job.at_points(points));
        Self { features: features.collect(), ..self.clone() }
    }
}

impl FeatureJob {
    /// Returns the feature with these points of its path alone.
    fn at_points(&self, points: &BTreeSet<usize>) -> Self {
        let indices: Vec<usize> = points.iter().copied().collect();
        let of = |loads: &Vec<_>| indices.iter().map(|&k| loads[k]).collect();
        let own = &self.feature;
        let feature = Feature { path: own.path.at_points(&indices), loads: of(&own.loads), ..own.clone() };
        Self {
            feature,
            components: None,
            #[cfg(not(target_family = "wasm"))]
            bodies: None,
            ..self.clone()
        }
    }
}
