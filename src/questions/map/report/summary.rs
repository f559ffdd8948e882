//! What a map says, gathered from its points one after another, and as a small JSON object.

use serde_json::{Value, json};

use crate::{
    files::{
        StatusCount,
        table::{largest_force, largest_position},
        words::position,
    },
    machine::{Machine, Motion},
    questions::map::{MapPoint, SourceEffect, WorkspaceMapStudy},
    simulation::{SOLVED, Source, sources::Gathered},
};

/// A value and where it occurs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Found {
    pub value: f64,
    pub position_mm: [f64; 3],
    pub phi_deg: Option<f64>,
}

impl Found {
    pub fn place(&self) -> String {
        let [x, y, z] = self.position_mm;
        position(x, y, z)
    }

    fn json(&self) -> Value {
        json!({ "value": self.value, "position_mm": self.position_mm, "phi_deg": self.phi_deg })
    }
}

/// The smallest and the largest value seen, each where it was seen first.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Extremes(Option<[Found; 2]>);

impl Extremes {
    fn see(&mut self, found: Found) {
        self.0 = Some(match self.0 {
            None => [found; 2],
            Some([least, most]) => [
                if found.value < least.value { found } else { least },
                if found.value > most.value { found } else { most },
            ],
        });
    }

    /// The smallest and the largest.
    pub fn get(&self) -> Option<[Found; 2]> {
        self.0
    }

    fn json(&self) -> Option<Value> {
        let [least, most] = self.0?;
        Some(json!({ "smallest": least.json(), "largest": most.json() }))
    }
}

/// Extremes of one source.
#[derive(Debug, Clone, Default)]
pub(super) struct OfSource {
    /// Points whose deflection is known, and those among them without a correction.
    pub known: usize,
    pub uncorrected: usize,
    pub deflection: Extremes,
    /// By kind of drive.
    pub correction: [Extremes; 2],
    /// What corrected drives leave, mm.
    pub left: Extremes,
    /// By kind of drive.
    pub force: [Extremes; 2],
    pub departure: Extremes,
    pub departure_over_deflection: Extremes,
}

/// The best and the worst of fewer of the points are chance.
const ENOUGH: f64 = 0.05;

/// Whether so many of the points are enough to speak of the best and the worst.
pub(super) fn is_enough(known: usize, points: usize) -> bool {
    known as f64 >= ENOUGH * points as f64
}

/// What a map says, gathered point by point.
#[derive(Debug, Clone, Default)]
pub struct Summary {
    sources: Gathered<OfSource>,
    points: usize,
    /// Shares of the box in which the tolerance is kept, and of which that is known.
    share_within: Option<[f64; 2]>,
    /// Whether it is kept wherever that is known: shares add up with rounding.
    are_all_within: bool,
    statuses: Vec<StatusCount>,
}

impl Summary {
    /// Takes the next point of the map of `study`, in grid order, into account.
    pub fn add(&mut self, study: &WorkspaceMapStudy, point: &MapPoint) {
        let machine = &study.machine;
        if let (Some(tolerance), Some(effect)) = (study.tolerance_mm, point.effect(Source::All)) {
            // Each grid point stands for the cell around it.
            let volume = study.grid.cell_share(self.points);
            let is_within = effect.deflection_mm <= tolerance;
            self.are_all_within = is_within && (self.are_all_within || self.share_within.is_none());
            let [within, known] = self.share_within.get_or_insert_default();
            *known += volume;
            *within += if is_within { volume } else { 0.0 };
        }
        self.points += 1;
        for (source, effect) in point.effects.iter() {
            StatusCount::add(&mut self.statuses, point.status(source));
            let sums = self.sources.at(source);
            if let Ok(effect) = effect {
                sums.see(machine, point.position_mm, effect);
            }
        }
    }

    /// Rows per status.
    pub fn statuses(&self) -> &[StatusCount] {
        &self.statuses
    }

    /// Rows that were solved, and all rows.
    fn rows(&self) -> (usize, usize) {
        let solved = self.statuses.iter().find(|count| count.status == SOLVED);
        (solved.map_or(0, |count| count.rows), self.statuses.iter().map(|count| count.rows).sum())
    }

    /// What `source` does.
    pub(super) fn of(&self, source: Source) -> Option<&OfSource> {
        self.sources.get(source)
    }

    /// Rows whose correction is missing and whose deflection is known.
    pub(super) fn uncorrected(&self) -> usize {
        self.sources.iter().map(|(_, sums)| sums.uncorrected).sum()
    }

    /// Share of the solved part of the box in which all sources together keep the tolerance; `None` without one, or where
    /// nothing was solved.
    pub(super) fn share_within(&self) -> Option<f64> {
        let [within, known] = self.share_within?;
        (known > 0.0).then(|| if self.are_all_within { 1.0 } else { within / known })
    }

    /// Whether the effect of all sources is known at every point.
    pub(super) fn is_all_known(&self, study: &WorkspaceMapStudy) -> bool {
        self.of(Source::All).is_some_and(|all| all.known == study.grid.len())
    }

    /// Extremes per source; drive corrections and forces in keys that end with their unit.
    pub fn json(&self) -> Value {
        let (solved, rows) = self.rows();
        let mut sources = serde_json::Map::new();
        for (source, sums) in self.sources.iter() {
            let mut entries = vec![("deflection_mm".to_string(), &sums.deflection)];
            for (kind, extremes) in KINDS.into_iter().zip(&sums.correction) {
                entries.push((format!("delta_rho_largest_drive_{}", kind.position_unit()), extremes));
            }
            for (kind, extremes) in KINDS.into_iter().zip(&sums.force) {
                entries.push((format!("drive_{}_largest_drive_{}", kind.force_word(), kind.force_unit()), extremes));
            }
            entries.push(("departure_mm".into(), &sums.departure));
            let entries: serde_json::Map<String, Value> =
                entries.into_iter().filter_map(|(key, extremes)| Some((key, extremes.json()?))).collect();
            if !entries.is_empty() {
                sources.insert(source.label().into(), Value::Object(entries));
            }
        }
        json!({ "schema": SCHEMA, "rows": rows, "rows_solved": solved, "sources": sources })
    }
}

/// Version of the summary. In 1, keys of corrections and forces had no unit.
const SCHEMA: u32 = 2;

/// Kinds of drives, as `kind as usize` counts them.
const KINDS: [Motion; 2] = [Motion::Prismatic, Motion::Revolute];

impl OfSource {
    fn see(&mut self, machine: &Machine, position_mm: [f64; 3], effect: &SourceEffect) {
        let found = |value| Found { value, position_mm, phi_deg: effect.phi_deg };
        self.known += 1;
        self.deflection.see(found(effect.deflection_mm));
        if effect.delta_rho.is_err() {
            self.uncorrected += 1;
        }
        for kind in machine.drive_kinds() {
            if let Ok(delta_rho) = &effect.delta_rho {
                self.correction[kind as usize].see(found(largest_position(machine, kind, delta_rho)));
            }
            self.force[kind as usize].see(found(largest_force(machine, kind, &effect.drive_force)));
        }
        if effect.delta_rho.is_ok() {
            self.left.see(found(effect.left_mm));
        }
        if let Some(departure) = effect.departure_mm() {
            self.departure.see(found(departure));
            let share = departure / effect.deflection_mm;
            if share.is_finite() {
                self.departure_over_deflection.see(found(share));
            }
        }
    }
}
