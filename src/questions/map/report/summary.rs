//! Extremes over a map, collected point by point, and the summary as JSON.

use nalgebra::Vector3;
use serde::Serialize;
use serde_json::{Map, Value, json};

use super::quantities::{
    DEFLECTION, P95_DEFLECTION, RESIDUAL_ERROR, SUPERPOSITION_ERROR, SUPERPOSITION_ERROR_SHARE, drives,
};
use crate::{
    answer::{DriveQuantities, Quantity, QuantityExtremes, ShareWithin, ValueAt},
    files::{StatusCount, words::position},
    questions::{
        map::{MapPoint, SourceEffect, WorkspaceMapStudy},
        spread_report::{self, SpreadCounts, WithSpread},
    },
    simulation::{
        BySource, SOLVED, Source,
        spread::{DeflectionSpread, IfMeasured},
    },
};

/// Where and at which tool angle φ a value was found.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(super) struct AtAngle {
    /// Position of the tool tip of the unloaded machine, O, mm, where P is at the grid point.
    pub tool_tip_mm: [f64; 3],
    /// φ in degrees; `None` without cutting force.
    pub phi_deg: Option<f64>,
}

impl ValueAt<AtAngle> {
    /// Returns the position of the tool tip at which the value was found as text.
    pub(super) fn tip(&self) -> String {
        let [x, y, z] = self.at.tool_tip_mm;
        format!("tool tip at {}", position(x, y, z))
    }
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
    /// Returns the smallest and the largest value of `quantity`, with position and φ; `None` if it has none.
    pub fn of(&self, quantity: &Quantity<SourceEffect>) -> Option<&[ValueAt<AtAngle>; 2]> {
        self.in_json.of(quantity).or_else(|| self.in_sentences.of(quantity))
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
    /// What becomes of the largest 95 % quantile if that is measured which is worth most.
    pub(super) advice: Option<IfMeasured>,
    /// Rows per status.
    pub(super) statuses: Vec<StatusCount>,
}

impl<'a> Summary<'a> {
    /// Makes an empty summary of a map of `study`.
    pub fn new(study: &'a WorkspaceMapStudy) -> Self {
        let machine = &study.load_case.machine;
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
            advice: None,
            statuses: Vec::new(),
        }
    }

    /// Adds the next point, in grid order.
    pub fn add(&mut self, point: &MapPoint) {
        if let Some(tolerance) = self.study.load_case.tolerance_mm {
            // Each grid point stands for the cell around it.
            let is_within = point.effect(Source::All).map(|effect| effect.deflection_mm <= tolerance);
            self.within.add(self.study.grid.cell_share(self.points), is_within);
            if self.study.uncertainty.is_some() {
                let is_met = |spread: &DeflectionSpread| spread.p95_mm.is_some_and(|p95| p95 <= tolerance);
                let is_within = point.effect(Source::All).and_then(WithSpread::distribution).map(is_met);
                self.within_p95.add(self.study.grid.cell_share(self.points), is_within);
            }
        }
        if let Some(spread) = point.effect(Source::All).and_then(WithSpread::distribution) {
            self.spread.add(spread);
        }
        self.points += 1;
        let machine = &self.study.load_case.machine;
        let tip = Vector3::from(point.position_mm) + machine.home.pose.rotation * machine.tool_tip;
        // The way through a rotation must not show.
        let tool_tip_mm = tip.map(|own| (own * 1e9).round() / 1e9).into();
        for (source, sums) in self.sources.iter_mut() {
            StatusCount::add(&mut self.statuses, point.status(source));
            let Some(effect) = point.effect(source) else { continue };
            let at = AtAngle { tool_tip_mm, phi_deg: effect.phi_deg };
            sums.known += 1;
            sums.uncorrected += usize::from(effect.delta_rho.is_err());
            sums.in_json.add(effect, point.position_mm, &at);
            sums.in_sentences.add(effect, point.position_mm, &at);
        }
    }

    /// Returns extremes and counts of `source` over the points added so far.
    pub(super) fn of(&self, source: Source) -> &SourceExtremes {
        &self.sources[source]
    }

    /// Returns whether values known at `known` grid points suffice to speak of best and worst.
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
            summary["uncertainty"] = spread_report::json(uncertainty, &self.spread);
            summary["uncertainty"]["if_measured"] = json!(self.advice);
            summary["uncertainty"]["share_within_tolerance_p95"] = json!(self.within_p95.get());
        }
        summary
    }
}

/// Version of the summary.
const SCHEMA: u32 = 2;
