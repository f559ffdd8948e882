//! Extremes over a map, collected point by point, and the summary as JSON.

use std::collections::BTreeMap;

use serde::Serialize;
use serde_json::{Map, Value, json};

use super::quantities::{
    DEFLECTION, P95_DEFLECTION, RESIDUAL_ERROR, SUPERPOSITION_ERROR, SUPERPOSITION_ERROR_SHARE, drives, spread,
};
use crate::{
    answer::{DriveQuantities, Quantity, QuantityExtremes, ShareWithin, ValueAt},
    files::StatusCount,
    process::uncertainty::{Draws, UncertainParameter},
    questions::map::{DeflectionSpread, MapPoint, SourceEffect, WorkspaceMapStudy},
    simulation::{BySource, SOLVED, Source},
};

/// The tool angle φ at which a value was found.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(super) struct AtAngle {
    /// φ in degrees; `None` without cutting force.
    pub phi_deg: Option<f64>,
}

/// Extremes and counts of one source of error over the map.
pub(super) struct SourceExtremes {
    /// Number of points whose deflection is known.
    pub known: usize,
    /// Number of those points without a correction.
    pub uncorrected: usize,
    /// Extremes that the JSON summary holds.
    in_json: QuantityExtremes<SourceEffect, AtAngle>,
    /// Extremes that only sentences use.
    in_sentences: QuantityExtremes<SourceEffect, AtAngle>,
}

impl SourceExtremes {
    /// Returns the smallest and the largest value of `quantity`.
    pub fn of(&self, quantity: &Quantity<SourceEffect>) -> Option<&[ValueAt<AtAngle>; 2]> {
        self.in_json.of(quantity).or_else(|| self.in_sentences.of(quantity))
    }
}

/// What is counted of the distributions over a map.
#[derive(Debug, Default)]
pub(super) struct SpreadCounts {
    /// Number of points with a distribution.
    pub known: usize,
    /// Number of those without a 95 % quantile, as too many draws have no equilibrium.
    pub unknown: usize,
    /// Number of points at which the engine differed from the surrogate, so that more draws were solved.
    pub corrected: usize,
    /// Draws solved by the engine at all points that have no equilibrium.
    pub failed_draws: usize,
    /// Draws solved by the engine at all points.
    pub solved_draws: usize,
    /// Number of points of which each is the main cause, by name.
    pub causes: BTreeMap<String, usize>,
}

impl SpreadCounts {
    /// Adds the distribution of an effect, if it has one.
    fn add(&mut self, effect: &SourceEffect) {
        if let Some(spread) = spread(effect) {
            self.known += 1;
            self.corrected += usize::from(spread.solved_draws > 1);
            self.solved_draws += spread.solved_draws;
            self.unknown += usize::from(spread.p95_mm.is_none());
            self.failed_draws += spread.failed_draws;
            if let Some(cause) = &spread.main_cause {
                *self.causes.entry(cause.clone()).or_default() += 1;
            }
        }
    }

    /// Returns what is the main cause at most points, the first by name of equal ones, with the share of the points.
    pub fn main_cause(&self) -> Option<(&str, f64)> {
        let most = self.causes.iter().max_by(|a, b| a.1.cmp(b.1).then(b.0.cmp(a.0)));
        most.map(|(name, count)| (name.as_str(), *count as f64 / self.known as f64))
    }
}

/// Smallest share of the grid points from which best and worst are meaningful.
const MIN_SHARE: f64 = 0.05;

/// Extremes over a map, collected point by point.
pub struct Summary<'a> {
    pub(super) study: &'a WorkspaceMapStudy,
    pub(super) drives: DriveQuantities<SourceEffect>,
    sources: BySource<SourceExtremes>,
    points: usize,
    /// Share of the solved part of the box in which the deflection by all sources is within tolerance.
    pub(super) within: ShareWithin,
    /// The same of its 95 % quantile, where inputs are uncertain.
    pub(super) within_p95: ShareWithin,
    pub(super) spread: SpreadCounts,
    /// Rows per status.
    pub(super) statuses: Vec<StatusCount>,
}

impl<'a> Summary<'a> {
    /// Makes an empty summary of a map of `study`.
    pub fn new(study: &'a WorkspaceMapStudy) -> Self {
        let machine = &study.scene.machine;
        let drives = drives(machine);
        let of_source = |_| SourceExtremes {
            known: 0,
            uncorrected: 0,
            in_json: QuantityExtremes::new(
                [DEFLECTION, P95_DEFLECTION, SUPERPOSITION_ERROR].into_iter().chain(drives.largest().cloned()),
            ),
            in_sentences: QuantityExtremes::new([RESIDUAL_ERROR, SUPERPOSITION_ERROR_SHARE]),
        };
        let sources = BySource::of(machine, of_source);
        Self {
            study,
            drives,
            sources,
            points: 0,
            within: ShareWithin::default(),
            within_p95: ShareWithin::default(),
            spread: SpreadCounts::default(),
            statuses: Vec::new(),
        }
    }

    /// Adds the next point, in grid order.
    pub fn add(&mut self, point: &MapPoint) {
        if let Some(tolerance) = self.study.scene.tolerance_mm {
            // Each grid point stands for the cell around it.
            let is_within = point.effect(Source::All).map(|effect| effect.deflection_mm <= tolerance);
            self.within.add(self.study.grid.cell_share(self.points), is_within);
            if self.study.uncertainty.is_some() {
                let is_met = |spread: &DeflectionSpread| spread.p95_mm.is_some_and(|p95| p95 <= tolerance);
                let is_within = point.effect(Source::All).and_then(spread).map(is_met);
                self.within_p95.add(self.study.grid.cell_share(self.points), is_within);
            }
        }
        if let Some(effect) = point.effect(Source::All) {
            self.spread.add(effect);
        }
        self.points += 1;
        for (source, sums) in self.sources.iter_mut() {
            StatusCount::add(&mut self.statuses, point.status(source));
            let Some(effect) = point.effect(source) else { continue };
            let at = AtAngle { phi_deg: effect.phi_deg };
            sums.known += 1;
            sums.uncorrected += usize::from(effect.delta_rho.is_err());
            sums.in_json.add(effect, point.position_mm, &at);
            sums.in_sentences.add(effect, point.position_mm, &at);
        }
    }

    /// Returns the extremes of `source`.
    pub(super) fn of(&self, source: Source) -> &SourceExtremes {
        &self.sources[source]
    }

    /// Returns whether `known` points suffice to speak of best and worst.
    pub(super) fn is_enough(&self, known: usize) -> bool {
        known as f64 >= MIN_SHARE * self.study.grid.len() as f64
    }

    /// Returns the number of rows with a known deflection but no correction.
    pub(super) fn uncorrected_rows(&self) -> usize {
        self.sources.iter().map(|(_, sums)| sums.uncorrected).sum()
    }

    /// Returns the summary as JSON: extremes per source; keys of corrections and forces end with their unit.
    pub fn json(&self) -> Value {
        let rows = |counts: &mut dyn Iterator<Item = &StatusCount>| counts.map(|count| count.rows).sum::<usize>();
        let solved = rows(&mut self.statuses.iter().filter(|count| count.status == SOLVED));
        let entries = self.sources.iter().map(|(source, sums)| (source.label().to_string(), sums.in_json.json()));
        let sources: Map<String, Value> =
            entries.filter(|(_, entry)| !entry.is_empty()).map(|(label, entry)| (label, entry.into())).collect();
        let mut summary = json!({ "schema": SCHEMA, "rows": rows(&mut self.statuses.iter()), "rows_solved": solved, "sources": sources });
        if let Some(uncertainty) = &self.study.uncertainty {
            let parameter = |own: &UncertainParameter| {
                let names: Vec<&str> = own.values.iter().map(|(name, _)| name.as_str()).collect();
                let (unit, [low, high]) = (own.unit.in_files(), own.interval_95());
                let (distribution, source) = (own.spread.words(), own.source.label());
                json!({ "names": names, "unit": unit, "low_95": low, "high_95": high, "distribution": distribution, "source": source })
            };
            summary["uncertainty"] = json!({
                "parameters": uncertainty.parameters.iter().map(parameter).collect::<Vec<Value>>(),
                "force_factor_95": uncertainty.force_factor_95(),
                "draws": Draws::COUNT,
                "points_corrected": self.spread.corrected,
                "points_without_p95": self.spread.unknown,
                "failed_draws": self.spread.failed_draws,
                "main_causes": self.spread.causes,
                "share_within_tolerance_p95": self.within_p95.get(),
            });
        }
        summary
    }
}

/// Version of the summary. In 1, keys of corrections and forces had no unit.
const SCHEMA: u32 = 2;
