//! The turn about the tool's axis at a place: where the process of a feature seeks it, every place is judged at the constant turn that is
//! best there.
//!
//! The turn is that of a lattice at which the loaded tool stays nearest to some points of the path, evenly chosen among those at which it
//! cuts; all points are then evaluated at it. It is a function of the place alone, so bounds on part of the points stay bounds.

use std::{
    collections::HashMap,
    sync::{Mutex, PoisonError},
};

use super::{Evaluator, FeatureJob, Site};
use crate::{
    compensation::Demand,
    input::error::Error,
    process::{Placement, ToolTurn},
    study::{
        Failure,
        demands::demands_under,
        free_turn::{TurnAsked, best_held, turned_by},
    },
    toolpath::{PathPoint, Toolpath},
    work::Work,
};

/// Points at which turns are tried.
const TRIED: usize = 24;

/// A place of a feature: its name and the coordinates.
type Key = (String, [u64; 6]);

/// Turns found so far, rad.
#[derive(Debug, Default)]
pub(super) struct TurnsFound(Mutex<HashMap<Key, Result<f64, Failure>>>);

impl FeatureJob {
    /// Whether the machine can turn its tool freely, if a turn is sought.
    ///
    /// # Errors
    /// Why it cannot.
    pub(super) fn check_turn(&self) -> Result<(), Error> {
        let Some(turn) = &self.turn else { return Ok(()) };
        let placement = Placement { reference: self.feature.reference, ..Placement::default() };
        turned_by(self.asked(turn, &placement), 0.0).map(drop)
    }

    fn asked<'a>(&'a self, turn: &'a ToolTurn, placement: &'a Placement) -> TurnAsked<'a> {
        TurnAsked {
            machine: self.machine(),
            errors: &self.errors,
            placement,
            target: self.target,
            path: &self.feature.path,
            loads: &self.feature.loads,
            turn,
        }
    }

    /// The turn of this feature at `site`, rad: the constant one that is best there; `None` if none is sought.
    ///
    /// # Errors
    /// Why no turn is possible there.
    pub fn turn_at(&self, site: &Site) -> Option<Result<f64, Failure>> {
        let turn = self.turn.as_ref()?;
        let feature = &self.feature;
        let points = feature.path.points();
        let cuts = |point: &PathPoint| point.cutting;
        let counted: Vec<usize> = match points.iter().any(cuts) {
            true => (0..points.len()).filter(|k| cuts(&points[*k])).collect(),
            false => (0..points.len()).collect(),
        };
        let tried = TRIED.min(counted.len());
        let chosen: Vec<usize> =
            (0..tried).map(|k| counted[k * (counted.len() - 1) / tried.saturating_sub(1).max(1)]).collect();
        let path = Toolpath::assemble(chosen.iter().map(|k| points[*k]).collect());
        let loads: Vec<_> = chosen.iter().map(|k| feature.loads[*k]).collect();
        let placement = site.placement(feature.reference);
        let asked = TurnAsked { path: &path, loads: &loads, ..self.asked(turn, &placement) };
        let no_turn = |reason: String| Failure { status: "no_turn".into(), reason };
        Some(match best_held(asked, &Work::default()) {
            Ok(Ok(turn)) => Ok(turn),
            Ok(Err(dead_end)) => {
                let hindrance = dead_end.hindrance.map_or("the turns before it lead to none there", |h| h.words());
                let [x, y, z]: [f64; 3] = path.points()[dead_end.point].position_mm.into();
                let place = format!("feature {}, at ({x:.2}, {y:.2}, {z:.2}) mm of W", feature.name);
                Err(no_turn(format!("{place}: no turn about the tool's axis goes on: {hindrance}")))
            }
            Err(error) => Err(no_turn(error.to_string())),
        })
    }

    /// What is wanted at each point of the feature at `site`, turned as is best there.
    pub(super) fn demands_at(&self, site: &Site) -> Vec<Demand> {
        let turned = self.turn_at(site).and_then(|turn| self.demands_turned(site, turn.ok()?));
        turned.unwrap_or_else(|| {
            let (feature, placement) = (&self.feature, site.placement(self.feature.reference));
            demands_under(self.machine(), &placement, self.target, &feature.path, &feature.loads)
        })
    }

    /// What is wanted at each point of the feature at `site`, the platform turned by `turn`, rad.
    fn demands_turned(&self, site: &Site, turn: f64) -> Option<Vec<Demand>> {
        let feature = &self.feature;
        let placement = site.placement(feature.reference);
        let path = turned_by(self.asked(self.turn.as_ref()?, &placement), turn).ok()?;
        Some(demands_under(self.machine(), &placement, self.target, &path, &feature.loads))
    }
}

impl Evaluator {
    /// What is wanted at each point of a feature at `site`, turned as is best there; `None` if no turn is sought or possible.
    pub(super) fn demands_at_best_turn(&self, site: &Site, job: &FeatureJob) -> Option<Vec<Demand>> {
        let turn = self.turn_at(site, job)?.ok()?;
        job.demands_turned(site, turn)
    }

    /// As [`FeatureJob::turn_at`], found once.
    pub(super) fn turn_at(&self, site: &Site, job: &FeatureJob) -> Option<Result<f64, Failure>> {
        job.turn.as_ref()?;
        let key = (job.feature.name.clone(), site.0.map(f64::to_bits));
        let known = self.turns.0.lock().unwrap_or_else(PoisonError::into_inner).get(&key).cloned();
        if known.is_some() {
            return known;
        }
        let found = job.turn_at(site)?;
        self.turns.0.lock().unwrap_or_else(PoisonError::into_inner).insert(key, found.clone());
        Some(found)
    }
}
