//! A path study's answer in sentences, as a table of methods and as a small JSON object, from its points part by part.

use comfy_table::{Table, presets::UTF8_HORIZONTAL_ONLY};
use serde_json::{Value, json};

use crate::{
    report::{
        StatusCount, cautions,
        table::{kind_word, largest_force, largest_position},
        words::{counted, if_any, millimetres},
    },
    study::{
        ROUNDING_MM, Source,
        along_path::PathSummary,
        path::{MethodAlongPath, PathPart, PathStudy, Shown},
        sources::Gathered,
    },
};

/// The largest value seen and the point it was seen at first.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
struct Largest(Option<(f64, usize)>);

impl Largest {
    fn see(&mut self, value: f64, point: usize) {
        if self.0.is_none_or(|(most, _)| value > most) {
            self.0 = Some((value, point));
        }
    }

    fn json(&self, study: &PathStudy) -> Option<Value> {
        let (value, k) = self.0?;
        Some(json!({ "value": value, "point": k, "phi_deg": study.stations[k].phi_deg }))
    }
}

/// Extremes of one source.
#[derive(Debug, Clone, Default)]
struct OfSource {
    /// mm.
    displacement: Largest,
    /// |Δρ| by kind of drive, mm for slides, degrees for hinges.
    correction: [Largest; 2],
    /// What the compensated command leaves, mm.
    left: Largest,
    /// |τ| by kind of drive on the compensated path, N for slides, N·mm for hinges.
    force: [Largest; 2],
    /// Points that could not be compensated.
    failed: usize,
    statuses: Vec<StatusCount>,
}

/// What a path says, gathered part by part.
#[derive(Debug, Clone, Default)]
pub struct Summary {
    sources: Gathered<OfSource>,
}

impl Summary {
    /// Takes the next part into account.
    pub fn add(&mut self, study: &PathStudy, part: &PathPart) {
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

    /// The closing words of a run.
    pub fn text(&self, study: &PathStudy, shown: &Shown) -> String {
        let place = |k| place(study, shown, k);
        let points = study.stations.len();
        let last = study.stations.last().map_or(0.0, |s| s.arc_length_mm);
        let mut text = format!("{}: a path of {last:.1} mm, {}.\n", study.machine.title, counted(points, "point"));
        text += &facts_text(&study.facts);
        text += &cautions::zeroed(&study.machine);
        text += &cautions::carried(&study.machine);
        text += &cautions::large_errors(&study.machine, &study.errors);
        text += &cautions::outside_workspace(
            &study.machine,
            "path point",
            study.demands.iter().map(|demand| demand.pose.translation),
        );
        for (source, sums) in self.sources.iter() {
            let Some((size, k)) = sums.displacement.0 else { continue };
            let cause = source.moves(&study.machine);
            text += &format!("{cause} by up to {}, {}.\n", millimetres(size, 3, ROUNDING_MM), place(k));
        }
        let Some(both) = self.sources.get(Source::All) else { return text };
        for kind in study.machine.drive_kinds() {
            let found = (both.correction[kind as usize].0, both.force[kind as usize].0);
            let (Some((correction, k)), Some((force, kf))) = found else { continue };
            let drives = kind_word(&study.machine, kind);
            let own = if study.machine.has_mixed_drives() { format!(" of {drives}") } else { String::new() };
            text += &format!(
                "To keep it on its path, {drives} must be commanded up to {} away from the inverse kinematics, {}; drive \
                 {}s{own} then reach {force:.0} {}, {}.\n",
                kind.position_words(correction),
                place(k),
                kind.force_word(),
                kind.shown_force_unit(),
                place(kf)
            );
        }
        if let (Some(axes), Some((left, k))) = (study.machine.uncontrolled_names(), both.left.0) {
            let left = millimetres(left, 3, ROUNDING_MM);
            text += &format!("No drive can put right {left} of it, {}: they do not control {axes}.\n", place(k));
        }
        if both.failed > 0 {
            text += &format!("{} of {points} points could not be compensated; the table says why.\n", both.failed);
        }
        text
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

fn place(study: &PathStudy, shown: &Shown, k: usize) -> String {
    let station = &study.stations[k];
    match station.phi_deg.filter(|_| shown.is_circle) {
        Some(phi) => format!("at tool angle {phi:.0}°"),
        None => format!("{:.1} mm along the path", station.arc_length_mm),
    }
}

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
    let mut table = Table::new();
    table.load_style(UTF8_HORIZONTAL_ONLY);
    table.set_header(["method", "corrections", "max error", "rms error", "failed"]);
    for method in methods {
        let s = &method.summary;
        table.add_row([
            method.method.label(),
            if_any(s.mean_corrections, |mean| format!("{mean:.2}")),
            if_any(s.max_mm, |max| format!("{max:.2e} mm")),
            if_any(s.rms_mm, |rms| format!("{rms:.2e} mm")),
            format!("{} of {}", s.failed, s.points),
        ]);
    }
    format!("{table}\n{}", failures_text(methods.iter().map(|method| (method.method.label(), &method.summary))))
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
