//! What a path says, gathered from its points part by part, as a table of methods and as a small JSON object.

use serde_json::{Value, json};

use crate::{
    answer::ShareWithin,
    files::{
        StatusCount,
        table::{largest_force, largest_position},
        text_table::text_table,
        words::{counted, if_any, millimetres_in_table},
    },
    questions::path::{MethodAlongPath, PathPart, PathStudy},
    simulation::{Source, along_path::PathSummary, sources::Gathered},
};

/// The largest value seen and the point it was seen at first.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Largest(Option<(f64, usize)>);

impl Largest {
    fn see(&mut self, value: f64, point: usize) {
        if self.0.is_none_or(|(most, _)| value > most) {
            self.0 = Some((value, point));
        }
    }

    /// The value and its point.
    pub fn get(self) -> Option<(f64, usize)> {
        self.0
    }

    fn json(&self, study: &PathStudy) -> Option<Value> {
        let (value, k) = self.0?;
        Some(json!({ "value": value, "point": k, "phi_deg": study.stations[k].phi_deg }))
    }
}

/// Extremes of one source.
#[derive(Debug, Clone, Default)]
pub(super) struct OfSource {
    /// mm.
    pub displacement: Largest,
    /// |Δρ| by kind of drive, mm for slides, degrees for hinges.
    pub correction: [Largest; 2],
    /// What the compensated command leaves, mm.
    pub left: Largest,
    /// |τ| by kind of drive on the compensated path, N for slides, N·mm for hinges.
    pub force: [Largest; 2],
    /// Points that could not be compensated.
    pub failed: usize,
    statuses: Vec<StatusCount>,
}

/// What a path says, gathered part by part.
#[derive(Debug, Clone, Default)]
pub struct Summary {
    sources: Gathered<OfSource>,
    /// Of the points, where all sources together keep the tolerance.
    within: ShareWithin,
    blame: Vec<(Source, f64)>,
}

impl Summary {
    /// Takes the next part into account.
    pub fn add(&mut self, study: &PathStudy, part: &PathPart) {
        for k in part.points() {
            self.see_all(study, part, k);
        }
        for &source in part.sources.sources() {
            let sums = self.sources.at(source);
            for k in part.points() {
                StatusCount::add(&mut sums.statuses, part.answer(source, k).status.label());
                if let Some(displacement) = part.displacement(source, k) {
                    sums.displacement.see(displacement.norm(), k);
                }
                let Some(answer) = part.compensated(source, k) else {
                    sums.failed += 1;
                    continue;
                };
                let (machine, delta_rho) = (&study.machine, answer.delta_rho());
                sums.left.see(answer.position_error.norm(), k);
                for kind in machine.drive_kinds() {
                    sums.correction[kind as usize].see(largest_position(machine, kind, &delta_rho), k);
                    sums.force[kind as usize].see(largest_force(machine, kind, &answer.drive_forces), k);
                }
            }
        }
    }

    /// Holds point `k` against the tolerance, and who is to blame if it is the worst so far.
    fn see_all(&mut self, study: &PathStudy, part: &PathPart, k: usize) {
        let Some(size) = part.displacement(Source::All, k).map(|d| d.norm()) else { return };
        if let Some(tolerance) = study.tolerance_mm {
            self.within.add(1.0, size <= tolerance);
        }
        if self.of(Source::All).and_then(|all| all.displacement.get()).is_none_or(|(most, _)| size > most) {
            let alone = |source: &Source| Some((*source, part.displacement(*source, k)?.norm()));
            self.blame = Source::parts(&study.machine).iter().filter_map(alone).collect();
            self.sources.at(Source::All).displacement.see(size, k);
        }
    }

    /// Share of the points, of those whose displacement is known, at which the tolerance is kept; `None` without one.
    pub(super) fn share_within(&self) -> Option<f64> {
        self.within.get()
    }

    /// Rows per status.
    pub fn statuses(&self) -> Vec<StatusCount> {
        let mut all: Vec<StatusCount> = Vec::new();
        for count in self.sources.iter().flat_map(|(_, sums)| &sums.statuses) {
            match all.iter_mut().find(|known| known.status == count.status) {
                Some(known) => known.rows += count.rows,
                None => all.push(count.clone()),
            }
        }
        all
    }

    /// The point at which both sources move the tool farthest.
    pub fn farthest(&self) -> Option<usize> {
        self.sources.get(Source::All)?.displacement.0.map(|(_, point)| point)
    }

    /// What `source` does.
    pub(super) fn of(&self, source: Source) -> Option<&OfSource> {
        self.sources.get(source)
    }

    /// What the single sources do, mm, at the point at which all together move the tool farthest.
    pub(super) fn blame(&self) -> &[(Source, f64)] {
        &self.blame
    }

    /// Extremes per source and the methods.
    pub fn json(&self, study: &PathStudy, methods: &[MethodAlongPath]) -> Value {
        let mut sources = serde_json::Map::new();
        for (source, sums) in self.sources.iter() {
            let mut entry = json!({ "displacement_max_mm": sums.displacement.json(study) });
            for kind in study.machine.drive_kinds() {
                let [correction, force] = [&sums.correction, &sums.force].map(|sums| sums[kind as usize].json(study));
                entry[format!("delta_rho_max_{}", kind.position_unit())] = json!(correction);
                entry[format!("drive_{}_max_{}", kind.force_word(), kind.force_unit())] = json!(force);
            }
            sources.insert(source.label().into(), entry);
        }
        let methods: Vec<Value> = methods
            .iter()
            .map(|m| {
                json!({
                    "method": m.method.label(),
                    "corrections_mean": m.summary.mean_corrections,
                    "error_max_mm": m.summary.max_mm,
                    "error_rms_mm": m.summary.rms_mm,
                    "failed": m.summary.failed,
                    "first_failure": m.summary.first_failure,
                })
            })
            .collect();
        json!({ "schema": SCHEMA, "points": study.stations.len(), "sources": sources, "methods": methods })
    }
}

/// Version of the summary. In 1, keys of corrections and forces had no unit.
const SCHEMA: u32 = 2;

/// Where the workpiece stands and what is cut, in sentences.
pub fn facts_text(facts: &[(impl AsRef<str>, String)]) -> String {
    let sentence = |(label, words): &(_, String)| {
        let (first, rest) = AsRef::<str>::as_ref(label).split_at(1);
        format!("{}{rest}: {words}.\n", first.to_uppercase())
    };
    facts.iter().map(sentence).collect()
}

/// The methods side by side.
pub(crate) fn methods_text(methods: &[MethodAlongPath]) -> String {
    let mut table = text_table(["method", "steps per point", "largest error", "rms error", "failed"], 1);
    for method in methods {
        let s = &method.summary;
        table.add_row([
            method.method.label(),
            if_any(s.mean_corrections, |mean| format!("{mean:.2}")),
            if_any(s.max_mm, |max| millimetres_in_table(max, 4)),
            if_any(s.rms_mm, |rms| millimetres_in_table(rms, 4)),
            format!("{} of {}", s.failed, s.points),
        ]);
    }
    format!(
        "Methods of compensation: steps each takes per point, and how far the tool then is from the path.\n{table}\n{}",
        failures_text(methods.iter().map(|method| (method.method.label(), &method.summary)))
    )
}

/// Where commands failed: at how many points, and why at the first; nothing for those that did not.
pub fn failures_text<'a>(passes: impl Iterator<Item = (String, &'a PathSummary)>) -> String {
    let sentence = |(name, summary): (String, &PathSummary)| {
        let reason = summary.first_failure.as_ref()?;
        let points = counted(summary.points, "point");
        Some(format!("{name} fails at {} of {points}; the first: {reason}.\n", summary.failed))
    };
    passes.filter_map(sentence).collect()
}
