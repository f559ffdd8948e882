//! The map's answer in sentences and as a small JSON object, from its points one after another.

use serde_json::{Value, json};

use crate::{
    machine::{Machine, Motion},
    report::{
        StatusCount, cautions,
        table::{kind_word, largest_force, largest_position},
        words::{counted, millimetres, position},
    },
    study::{
        ROUNDING_MM, SOLVED, Source,
        map::{MapPoint, SourceEffect, WorkspaceMapStudy},
        sources::Gathered,
    },
};

/// A value and where it occurs.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Found {
    value: f64,
    position_mm: [f64; 3],
    phi_deg: Option<f64>,
}

impl Found {
    fn place(&self) -> String {
        let [x, y, z] = self.position_mm;
        position(x, y, z)
    }

    fn json(&self) -> Value {
        json!({ "value": self.value, "position_mm": self.position_mm, "phi_deg": self.phi_deg })
    }
}

/// The smallest and the largest value seen, each where it was seen first.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
struct Extremes(Option<[Found; 2]>);

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

    fn json(&self) -> Option<Value> {
        let [least, most] = self.0?;
        Some(json!({ "smallest": least.json(), "largest": most.json() }))
    }
}

/// Extremes of one source.
#[derive(Debug, Clone, Default)]
struct OfSource {
    /// Points whose deflection is known, and those among them without a correction.
    known: usize,
    uncorrected: usize,
    deflection: Extremes,
    /// By kind of drive.
    correction: [Extremes; 2],
    /// What corrected drives leave, mm.
    left: Extremes,
    /// By kind of drive.
    force: [Extremes; 2],
    departure: Extremes,
    departure_over_deflection: Extremes,
}

/// The best and the worst of fewer of the points are chance.
const ENOUGH: f64 = 0.05;

fn is_enough(known: usize, points: usize) -> bool {
    known as f64 >= ENOUGH * points as f64
}

/// What a map says, gathered point by point.
#[derive(Debug, Clone, Default)]
pub struct Summary {
    sources: Gathered<OfSource>,
    statuses: Vec<StatusCount>,
}

impl Summary {
    /// Takes a point of `machine` into account.
    pub fn add(&mut self, machine: &Machine, point: &MapPoint) {
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

    /// The closing words of a run: how far the tool moves, where, and what must be commanded instead.
    pub fn text(&self, study: &WorkspaceMapStudy) -> String {
        let (solved, rows) = self.rows();
        let mut text = format!(
            "{}: {}, {}, {solved} of {rows} rows solved.\n",
            study.machine.title,
            counted(study.grid.len(), "grid point"),
            counted(study.phis.len(), "tool angle")
        );
        text += &self.uncorrected_sentence();
        text += &cautions::not_used(&study.not_used);
        text += &cautions::zeroed(&study.machine);
        text += &cautions::carried(&study.machine);
        text += &cautions::large_errors(&study.machine, &study.errors);
        text += &cautions::outside_workspace(
            &study.machine,
            "grid point",
            (0..study.grid.len()).map(|index| study.grid.position(index)),
        );
        text += &self.deflection_sentences(&study.machine, study.grid.len());
        text += &self.correction_sentences(&study.machine, study.grid.len());
        text += &self.departure_sentence(study.grid.len());
        text
    }

    fn uncorrected_sentence(&self) -> String {
        match self.sources.iter().map(|(_, sums)| sums.uncorrected).sum() {
            0 => String::new(),
            rows => format!("Of {rows} of them only the correction is missing; their deflection is known.\n"),
        }
    }

    fn deflection_sentences(&self, machine: &Machine, points: usize) -> String {
        let mut text = String::new();
        for (source, sums) in self.sources.iter() {
            let cause = source.moves(machine);
            let of = match source {
                Source::Cutting => "by the cutting force alone",
                Source::Weight => "by weight alone",
                Source::Errors => "by chain errors alone",
                Source::All => "by all together",
            };
            let Some([least, most]) = sums.deflection.0.filter(|_| is_enough(sums.known, points)) else {
                text += &format!(
                    "How far the tool moves {of} is known at {} of {}: too few to speak of best and worst.\n",
                    sums.known,
                    counted(points, "grid point")
                );
                continue;
            };
            let phi = most.phi_deg.map_or_else(String::new, |phi| format!(" (tool angle {phi:.0}°)"));
            let [low, high] = [least, most].map(|found| millimetres(found.value, 3, ROUNDING_MM));
            text += &match low == high {
                true => format!("{cause} by {high} everywhere.\n"),
                false => {
                    format!(
                        "{cause} by {low} at best, at {}, and by {high} at worst, at {}{phi}.\n",
                        least.place(),
                        most.place()
                    )
                }
            };
        }
        text
    }

    /// A sentence for each kind of drive.
    fn correction_sentences(&self, machine: &Machine, points: usize) -> String {
        let Some(both) = self.sources.get(Source::All) else { return String::new() };
        if !is_enough(both.known - both.uncorrected, points) {
            return String::new();
        }
        let sentence = |kind: Motion| {
            let (Some([least, most]), Some([_, force])) =
                (both.correction[kind as usize].0, both.force[kind as usize].0)
            else {
                return String::new();
            };
            let drives = kind_word(machine, kind);
            let own = if machine.has_mixed_drives() { format!(" of {drives}") } else { String::new() };
            format!(
                "To keep the tool on its path under {}, {drives} must be commanded up to {} away from the inverse \
                 kinematics at best, at {}, and {} at worst, at {}. Drive {}s{own} reach {:.0} {}, at {}.\n",
                if Source::parts(machine).len() > 2 { "all" } else { "both" },
                kind.position_words(least.value),
                least.place(),
                kind.position_words(most.value),
                most.place(),
                kind.force_word(),
                force.value,
                kind.shown_force_unit(),
                force.place()
            )
        };
        machine.drive_kinds().map(sentence).collect::<String>() + &self.left_sentence(machine)
    }

    /// What no drive can put right.
    fn left_sentence(&self, machine: &Machine) -> String {
        let Some(axes) = machine.uncontrolled_names() else { return String::new() };
        let Some([_, most]) = self.sources.get(Source::All).and_then(|all| all.left.0) else { return String::new() };
        let left = millimetres(most.value, 3, ROUNDING_MM);
        format!("No drive can put right {left} of it at worst, at {}: they do not control {axes}.\n", most.place())
    }

    fn departure_sentence(&self, points: usize) -> String {
        let Some(both) = self.sources.get(Source::All) else { return String::new() };
        if !is_enough(both.known, points) {
            return String::new();
        }
        let (Some([_, absolute]), Some([_, relative])) = (both.departure.0, both.departure_over_deflection.0) else {
            return String::new();
        };
        format!(
            "Adding the effects instead of solving them together is wrong by up to {}, at {}, and by up to \
             {:.1} % of the deflection, at {}.\n",
            millimetres(absolute.value, 4, ROUNDING_MM),
            absolute.place(),
            100.0 * relative.value,
            relative.place()
        )
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
