//! What a path says, gathered from its points one after another, and as a small JSON object.

use serde_json::{Map, Value, json};

use super::quantities::{DISPLACEMENT, LEFT, drives};
use crate::{
    answer::{OfDrives, Quantity, ShareWithin},
    files::StatusCount,
    questions::path::{AtPoint, MethodAlongPath, PathPart, PathStudy, Shown},
    simulation::{BySource, Source},
};

/// Of one source.
#[derive(Default)]
struct OfSource {
    /// The largest value of each quantity, and the point it was seen at first.
    largest: Vec<Option<(f64, usize)>>,
    failed: usize,
    statuses: Vec<StatusCount>,
}

/// What a path says, gathered point by point: memory does not grow with it.
pub struct Summary<'a> {
    pub(super) study: &'a PathStudy,
    pub(super) shown: Shown,
    pub(super) drives: OfDrives<AtPoint>,
    /// Those whose largest values are told.
    quantities: Vec<Quantity<AtPoint>>,
    sources: BySource<OfSource>,
    /// Of the points whose displacement is known, where all sources together keep the tolerance.
    pub(super) within: ShareWithin,
    /// What the single sources do, mm, at the point at which all together move the tool farthest.
    pub(super) blame: Vec<(Source, f64)>,
}

impl<'a> Summary<'a> {
    /// Of `study`, none of its points seen.
    pub fn new(study: &'a PathStudy, shown: Shown) -> Self {
        let drives = drives(&study.machine);
        let quantities: Vec<_> = [DISPLACEMENT, LEFT].into_iter().chain(drives.largest().cloned()).collect();
        let of_source = |_| OfSource { largest: vec![None; quantities.len()], ..OfSource::default() };
        let sources = BySource::of(&study.machine, of_source);
        Self { study, shown, drives, quantities, sources, within: ShareWithin::default(), blame: Vec::new() }
    }

    /// Takes the next part into account.
    pub fn add(&mut self, part: &PathPart) {
        for k in part.points() {
            self.hold_against(part, k);
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

    /// Holds point `k` against the tolerance, and notes who is to blame if it is the worst so far.
    fn hold_against(&mut self, part: &PathPart, k: usize) {
        let size = |source: Source| DISPLACEMENT.value(part.at(source, k));
        let all = size(Source::All);
        if let Some(tolerance) = self.study.tolerance_mm {
            self.within.add(1.0, all.map(|all| all <= tolerance));
        }
        let Some(all) = all else { return };
        if self.farthest().is_none_or(|(most, _)| all > most) {
            let parts = Source::parts(&self.study.machine).iter();
            self.blame = parts.filter_map(|source| Some((*source, size(*source)?))).collect();
        }
    }

    /// The largest value of `quantity` under `source`, and its point.
    pub(super) fn largest(&self, source: Source, quantity: &Quantity<AtPoint>) -> Option<(f64, usize)> {
        let place = self.quantities.iter().position(|own| own.name == quantity.name)?;
        self.sources.get(source)?.largest[place]
    }

    /// How far all sources together move the tool, and at which point.
    pub(super) fn farthest(&self) -> Option<(f64, usize)> {
        self.largest(Source::All, &DISPLACEMENT)
    }

    /// Points that could not be compensated.
    pub(super) fn failed(&self) -> usize {
        self.sources[Source::All].failed
    }

    /// Rows per status, those of all sources together first.
    pub(super) fn statuses(&self) -> Vec<StatusCount> {
        let mut all = self.sources[Source::All].statuses.clone();
        for count in self.sources.iter().filter(|(own, _)| *own != Source::All).flat_map(|(_, sums)| &sums.statuses) {
            match all.iter_mut().find(|known| known.status == count.status) {
                Some(known) => known.rows += count.rows,
                None => all.push(count.clone()),
            }
        }
        all
    }

    /// Largest values per source and the methods.
    pub(super) fn json(&self, methods: &[MethodAlongPath]) -> Value {
        let largest = |source, quantity: &Quantity<AtPoint>| {
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
        json!({ "schema": SCHEMA, "points": self.study.stations.len(), "sources": sources, "methods": methods })
    }
}

/// Version of the summary. In 1, keys of corrections and forces had no unit.
const SCHEMA: u32 = 2;
