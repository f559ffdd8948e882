//! Largest values along a path, collected point by point, and the summary as JSON.

use std::collections::BTreeMap;

use serde_json::{Map, Value, json};

use super::quantities::{DISPLACEMENT, P95_RESIDUAL, RESIDUAL_ERROR, WITHOUT_FORCE, drives, plain_spread};
use crate::{
    answer::{DriveQuantities, Quantity, ShareWithin, play::PlayCounts},
    files::StatusCount,
    questions::{
        path::{MethodAlongPath, PathPart, PathSpread, PathStudy, PointEffect, Shown},
        spread_report::{self, SpreadCounts, WithSpread},
    },
    simulation::{
        BySource, Source,
        along_path::length_of_point,
        clearance::{ClearanceState, PathClearance},
    },
};

/// Extremes and counts of one source of error along the path.
#[derive(Default)]
struct SourceExtremes {
    /// The largest value of each quantity, and the first point at which it occurs.
    largest: Vec<Option<(f64, usize)>>,
    failed: usize,
    statuses: Vec<StatusCount>,
}

/// Extremes along a path, collected point by point, so that memory does not grow with the path.
pub struct Summary<'a> {
    pub(super) study: &'a PathStudy,
    pub(super) shown: Shown,
    pub(super) drives: DriveQuantities<PointEffect>,
    /// Quantities whose largest values are collected.
    quantities: Vec<Quantity<PointEffect>>,
    sources: BySource<SourceExtremes>,
    cuts_nowhere: bool,
    /// Share of the path with a known displacement where it cuts on which that by all sources is within tolerance.
    pub(super) within: ShareWithin,
    /// Displacements by the single sources, mm, at the point at which all together move the tool farthest.
    pub(super) single_sources: Vec<(Source, f64)>,
    /// What is counted of the distributions: of what the compensation leaves, or where it was found nowhere, of what is without it.
    spread: [SpreadCounts; 2],
    /// Distribution of the largest distance from the path, where inputs are uncertain.
    pub(super) whole: Option<PathSpread>,
    /// Play of the drives.
    pub(super) play: PlayCounts,
    /// How near bodies come; `None` where the process names no cell.
    pub(super) clearance: Option<PathClearance>,
}

impl<'a> Summary<'a> {
    /// Makes an empty summary of `study`.
    pub fn new(study: &'a PathStudy, shown: Shown) -> Self {
        let drives = drives(&study.machine);
        let collected = [DISPLACEMENT, RESIDUAL_ERROR, P95_RESIDUAL, WITHOUT_FORCE];
        let quantities: Vec<_> = collected.into_iter().chain(drives.largest().cloned()).collect();
        let of_source = |_| SourceExtremes { largest: vec![None; quantities.len()], ..SourceExtremes::default() };
        let sources = BySource::of(&study.machine, of_source);
        Self {
            study,
            shown,
            drives,
            quantities,
            sources,
            cuts_nowhere: study.cuts_nowhere(),
            within: ShareWithin::default(),
            single_sources: Vec::new(),
            spread: Default::default(),
            whole: None,
            play: PlayCounts::default(),
            clearance: None,
        }
    }

    /// Adds the points of the next part of the path.
    pub fn add(&mut self, part: &PathPart) {
        for k in part.points() {
            self.note_displacement(part, k);
            let PointEffect { plain, answer, .. } = part.at(Source::All, k);
            self.play.add(k, plain.play.as_ref(), answer.play.as_ref());
            let spreads = [WithSpread::distribution, plain_spread].map(|of| of(part.at(Source::All, k)));
            for (counts, spread) in self.spread.iter_mut().zip(spreads) {
                spread.into_iter().for_each(|spread| counts.add(spread));
            }
            for (source, sums) in self.sources.iter_mut() {
                let at = part.at(source, k);
                StatusCount::add(&mut sums.statuses, at.answer.status.label());
                sums.failed += usize::from(at.compensated().is_none());
                for (quantity, largest) in self.quantities.iter().zip(&mut sums.largest) {
                    let value = quantity.value(at).filter(|value| largest.is_none_or(|(most, _)| *value > most));
                    *largest = value.map(|value| (value, k)).or(*largest);
                }
            }
        }
    }

    /// Counts whether point `k` is within tolerance, and keeps the displacements by single sources there if it is the worst so far.
    fn note_displacement(&mut self, part: &PathPart, k: usize) {
        let size = |source: Source| DISPLACEMENT.value(part.at(source, k));
        let all = size(Source::All);
        if let Some(tolerance) = self.study.tolerance_mm {
            let (stations, cuts_nowhere) = (&self.study.stations, self.cuts_nowhere);
            let counts = |k: usize| stations[k].cutting || cuts_nowhere;
            if counts(k) {
                let length = length_of_point(k, stations.len(), |k| stations[k].arc_length_mm, counts);
                self.within.add(length, all.map(|all| all <= tolerance));
            }
        }
        let Some(all) = all else { return };
        if self.largest_displacement().is_none_or(|(largest, _)| all > largest) {
            let parts = Source::parts(&self.study.machine).iter();
            self.single_sources = parts.filter_map(|source| Some((*source, size(*source)?))).collect();
        }
    }

    /// Sets the distribution of the largest distance from the path.
    pub fn add_whole(&mut self, spread: &Option<PathSpread>) {
        self.whole.clone_from(spread);
    }

    /// Returns whether bodies hit along the path.
    pub fn hits(&self) -> bool {
        self.clearance.as_ref().is_some_and(|own| own.state == ClearanceState::Hit)
    }

    /// Sets how near bodies come.
    pub fn add_clearance(&mut self, clearance: Option<PathClearance>) {
        let moved_mm = self.largest_displacement().map_or(0.0, |(largest, _)| largest);
        self.clearance = clearance.map(|own| own.moved_by(moved_mm));
    }

    /// Returns the counts of the distributions of the residual error, or without any, of the distance at the nominal command.
    pub(super) fn spread_counts(&self) -> &SpreadCounts {
        let [compensated, plain] = &self.spread;
        if compensated.known > 0 { compensated } else { plain }
    }

    /// Returns the largest value of `quantity` under `source`, and the index of its point; `None` if it is not collected or has no value.
    pub(super) fn largest(&self, source: Source, quantity: &Quantity<PointEffect>) -> Option<(f64, usize)> {
        let index = self.quantities.iter().position(|collected| collected.name == quantity.name)?;
        self.sources.get(source)?.largest[index]
    }

    /// Returns the largest displacement by all sources together, mm, and the index of its point; `None` where no point has one.
    pub(super) fn largest_displacement(&self) -> Option<(f64, usize)> {
        self.largest(Source::All, &DISPLACEMENT)
    }

    /// Returns the number of points that could not be compensated for all sources.
    pub(super) fn failed_count(&self) -> usize {
        self.sources[Source::All].failed
    }

    /// Returns the rows per status, those of all sources together first.
    pub(super) fn statuses(&self) -> Vec<StatusCount> {
        let mut counts = self.sources[Source::All].statuses.clone();
        for count in self.sources.iter().filter(|(s, _)| *s != Source::All).flat_map(|(_, sums)| &sums.statuses) {
            match counts.iter_mut().find(|same| same.status == count.status) {
                Some(same) => same.rows += count.rows,
                None => counts.push(count.clone()),
            }
        }
        counts
    }

    /// Returns the summary as JSON: largest values per source, and residual errors of the methods.
    pub(super) fn json(&self, methods: &[MethodAlongPath]) -> Value {
        let largest = |source, quantity: &Quantity<PointEffect>| {
            let (value, k) = self.largest(source, quantity)?;
            Some(json!({ "value": value, "point": k, "phi_deg": self.study.stations[k].phi_deg }))
        };
        let of_source = |source: Source| {
            let mut entry = json!({ "displacement_max_mm": largest(source, &DISPLACEMENT) });
            for (kind, own) in &self.drives.corrections {
                entry[format!("delta_rho_max_{}", kind.position_unit())] = json!(largest(source, own));
            }
            for (kind, own) in &self.drives.forces {
                entry[format!("drive_{}_max_{}", kind.force_word(), kind.force_unit())] = json!(largest(source, own));
            }
            (source.label().to_string(), entry)
        };
        let of_method = |method: &MethodAlongPath| {
            let summary = &method.summary;
            json!({
                "method": method.method.label(),
                "corrections_mean": summary.mean_corrections,
                "error_max_mm": summary.max_mm,
                "error_rms_mm": summary.rms_mm,
                "failed": summary.failed,
                "first_failure": summary.first_failure,
            })
        };
        let sources: Map<String, Value> = self.sources.sources().iter().copied().map(of_source).collect();
        let methods: Vec<Value> = methods.iter().map(of_method).collect();
        let points = self.study.stations.len();
        let outside = super::outside_positions(self.study).outside();
        let mut summary = json!({
            "schema": SCHEMA,
            "points": points,
            "points_outside_workspace": outside,
            "sources": sources,
            "methods": methods,
        });
        let resting: BTreeMap<_, _> = self.study.machine.resting_drives().collect();
        if !resting.is_empty() {
            summary["drives_left_at_home"] = json!(resting);
        }
        if let Some(uncertainty) = &self.study.uncertainty {
            summary["uncertainty"] = spread_report::json(uncertainty, self.spread_counts());
            summary["uncertainty"]["largest"] = json!(self.whole);
            for quantity in [P95_RESIDUAL, WITHOUT_FORCE] {
                summary["uncertainty"][format!("{}_max", quantity.name)] = json!(largest(Source::All, &quantity));
            }
        }
        if let Some(clearance) = &self.clearance {
            summary["clearance"] = json!(clearance);
        }
        if let Some(play) = self.play.json() {
            summary["play"] = play;
        }
        summary
    }
}

/// Version of the summary.
const SCHEMA: u32 = 2;
