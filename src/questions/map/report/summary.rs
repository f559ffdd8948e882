//! What a map says, gathered from its points one after another, and as a small JSON object.

use serde::Serialize;
use serde_json::{Map, Value, json};

use super::quantities::{DEFLECTION, LEFT, SUPERPOSITION_ERROR, SUPERPOSITION_ERROR_SHARE, drives};
use crate::{
    answer::{Found, OfDrives, OfQuantities, Quantity, ShareWithin},
    files::StatusCount,
    questions::map::{MapPoint, SourceEffect, WorkspaceMapStudy},
    simulation::{BySource, SOLVED, Source},
};

/// The tool angle at which a value was found.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(super) struct AtAngle {
    pub phi_deg: Option<f64>,
}

/// Extremes of one source.
pub(super) struct OfSource {
    /// Points whose deflection is known, and those among them without a correction.
    pub known: usize,
    pub uncorrected: usize,
    /// What is told to programs, and what is said besides.
    told: OfQuantities<SourceEffect, AtAngle>,
    said: OfQuantities<SourceEffect, AtAngle>,
}

impl OfSource {
    /// The smallest and the largest value of `quantity`.
    pub fn of(&self, quantity: &Quantity<SourceEffect>) -> Option<&[Found<AtAngle>; 2]> {
        self.told.of(quantity).or_else(|| self.said.of(quantity))
    }
}

/// The best and the worst of fewer of the points are chance.
const ENOUGH: f64 = 0.05;

/// What a map says, gathered point by point.
pub struct Summary<'a> {
    pub(super) study: &'a WorkspaceMapStudy,
    pub(super) drives: OfDrives<SourceEffect>,
    sources: BySource<OfSource>,
    points: usize,
    /// Of the part of the box that was solved, where all sources together keep the tolerance.
    pub(super) within: ShareWithin,
    /// Rows per status.
    pub(super) statuses: Vec<StatusCount>,
}

impl<'a> Summary<'a> {
    /// Of a map of `study`, none of its points seen.
    pub fn new(study: &'a WorkspaceMapStudy) -> Self {
        let machine = &study.scene.machine;
        let drives = drives(machine);
        let of_source = |_| OfSource {
            known: 0,
            uncorrected: 0,
            told: OfQuantities::new([DEFLECTION, SUPERPOSITION_ERROR].into_iter().chain(drives.largest().cloned())),
            said: OfQuantities::new([LEFT, SUPERPOSITION_ERROR_SHARE]),
        };
        let sources = BySource::of(machine, of_source);
        Self { study, drives, sources, points: 0, within: ShareWithin::default(), statuses: Vec::new() }
    }

    /// Takes the next point, in grid order, into account.
    pub fn add(&mut self, point: &MapPoint) {
        if let Some(tolerance) = self.study.scene.tolerance_mm {
            // Each grid point stands for the cell around it.
            let is_within = point.effect(Source::All).map(|effect| effect.deflection_mm <= tolerance);
            self.within.add(self.study.grid.cell_share(self.points), is_within);
        }
        self.points += 1;
        for (source, sums) in self.sources.iter_mut() {
            StatusCount::add(&mut self.statuses, point.status(source));
            let Some(effect) = point.effect(source) else { continue };
            let at = AtAngle { phi_deg: effect.phi_deg };
            sums.known += 1;
            sums.uncorrected += usize::from(effect.delta_rho.is_err());
            sums.told.see(effect, point.position_mm, &at);
            sums.said.see(effect, point.position_mm, &at);
        }
    }

    /// What `source` does.
    pub(super) fn of(&self, source: Source) -> &OfSource {
        &self.sources[source]
    }

    /// Whether so many of the points are enough to speak of the best and the worst.
    pub(super) fn is_enough(&self, known: usize) -> bool {
        known as f64 >= ENOUGH * self.study.grid.len() as f64
    }

    /// Rows whose correction is missing and whose deflection is known.
    pub(super) fn uncorrected(&self) -> usize {
        self.sources.iter().map(|(_, sums)| sums.uncorrected).sum()
    }

    /// Extremes per source; drive corrections and forces in keys that end with their unit.
    pub fn json(&self) -> Value {
        let rows = |counts: &mut dyn Iterator<Item = &StatusCount>| counts.map(|count| count.rows).sum::<usize>();
        let solved = rows(&mut self.statuses.iter().filter(|count| count.status == SOLVED));
        let entries = self.sources.iter().map(|(source, sums)| (source.label().to_string(), sums.told.json()));
        let sources: Map<String, Value> =
            entries.filter(|(_, entry)| !entry.is_empty()).map(|(label, entry)| (label, entry.into())).collect();
        json!({ "schema": SCHEMA, "rows": rows(&mut self.statuses.iter()), "rows_solved": solved, "sources": sources })
    }
}

/// Version of the summary. In 1, keys of corrections and forces had no unit.
const SCHEMA: u32 = 2;
