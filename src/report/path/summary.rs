//! A path study's answer in sentences, as a table of methods and as a small JSON object.

use comfy_table::{Table, presets::UTF8_HORIZONTAL_ONLY};
use serde_json::{Value, json};

use crate::{
    machine::Machine,
    report::{
        table::{force_unit, largest_position, position_unit},
        words::{counted, millimetres},
    },
    study::{
        Source,
        path_study::{PathResults, SourceAlongPath},
        superposition::growth::ROUNDING_MM,
    },
};

/// Largest value over the path and the point it occurs at.
fn largest(points: usize, value: impl Fn(usize) -> Option<f64>) -> Option<(f64, usize)> {
    let values = (0..points).filter_map(|k| Some((value(k)?, k)));
    values.max_by(|a, b| a.0.total_cmp(&b.0))
}

/// Largest |Δρ| of any drive over the path, mm for slides, degrees for hinges.
fn largest_correction(machine: &Machine, along: &SourceAlongPath) -> Option<(f64, usize)> {
    largest(along.compensated.len(), |k| {
        let answer = &along.compensated[k];
        answer.compensation.status.is_success().then(|| largest_position(machine, &answer.delta_rho()))
    })
}

/// Largest |τ| of any drive over the compensated path, N for slides, N·mm for hinges.
fn largest_force(along: &SourceAlongPath) -> Option<(f64, usize)> {
    largest(along.compensated.len(), |k| {
        let compensation = &along.compensated[k].compensation;
        let forces = compensation.drive_forces.iter();
        compensation.status.is_success().then(|| forces.fold(0.0f64, |most, f| most.max(f.abs())))
    })
}

fn place(results: &PathResults, k: usize) -> String {
    let station = &results.study.stations[k];
    match station.phi_deg.filter(|_| results.study.is_circle) {
        Some(phi) => format!("at tool angle {phi:.0}°"),
        None => format!("{:.1} mm along the path", station.arc_length_mm),
    }
}

/// The closing words of a run.
pub fn summary_text(results: &PathResults) -> String {
    let study = &results.study;
    let points = study.stations.len();
    let last = study.stations.last().map_or(0.0, |s| s.arc_length_mm);
    let mut text = format!("{}: a path of {last:.1} mm, {}.\n", study.machine.title, counted(points, "point"));
    for source in Source::ALL {
        let Some((size, k)) = largest(points, |k| results.displacement(source, k).map(|d| d.norm())) else { continue };
        let cause = match source {
            Source::Cutting => "The cutting force alone moves the tool",
            Source::Assembly => "Chain errors alone move it",
            Source::Both => "Both together move it",
        };
        text += &format!("{cause} by up to {}, {}.\n", millimetres(size, 3, ROUNDING_MM), place(results, k));
    }
    let both = &results.sources[Source::Both as usize];
    if let (Some((correction, k)), Some((force, kf))) = (largest_correction(&study.machine, both), largest_force(both))
    {
        text += &format!(
            "To keep it on its path, drives must be commanded up to {correction:.3} {} away from the inverse \
             kinematics, {}; drive forces then reach {force:.0} {}, {}.\n",
            position_unit(&study.machine),
            place(results, k),
            force_unit(&study.machine),
            place(results, kf)
        );
    }
    let unsolved = both.compensated.iter().filter(|a| !a.compensation.status.is_success()).count();
    if unsolved > 0 {
        text += &format!("{unsolved} of {points} points could not be compensated; the table says why.\n");
    }
    text
}

/// The methods side by side, with the time each takes on this machine.
pub fn methods_text(results: &PathResults) -> String {
    let mut table = Table::new();
    table.load_style(UTF8_HORIZONTAL_ONLY);
    table.set_header(["method", "corrections", "max error", "rms error", "failed", "time per point"]);
    for method in &results.methods {
        let s = &method.summary;
        table.add_row([
            method.method.label(),
            shown(s.solved, format!("{:.2}", s.mean_corrections)),
            shown(s.solved, format!("{:.2e} mm", s.max_mm)),
            shown(s.solved, format!("{:.2e} mm", s.rms_mm)),
            format!("{} of {}", method.failed, s.points),
            format!("{:.0} µs", 1e6 * method.seconds_per_point),
        ]);
    }
    format!("{table}\n")
}

/// A number, if it comes from any point.
fn shown(solved: usize, number: String) -> String {
    if solved > 0 { number } else { "–".into() }
}

/// Extremes per source and the methods.
pub fn summary_json(results: &PathResults) -> Value {
    let points = results.study.stations.len();
    let mut sources = serde_json::Map::new();
    for source in Source::ALL {
        let along = &results.sources[source as usize];
        let item = |found: Option<(f64, usize)>| {
            found.map(|(value, k)| json!({ "value": value, "point": k, "phi_deg": results.study.stations[k].phi_deg }))
        };
        let entry = json!({
            "displacement_max_mm": item(largest(points, |k| results.displacement(source, k).map(|d| d.norm()))),
            "delta_rho_max": item(largest_correction(&results.study.machine, along)),
            "drive_force_max": item(largest_force(along)),
        });
        sources.insert(source.label().into(), entry);
    }
    let methods: Vec<Value> = results
        .methods
        .iter()
        .map(|m| {
            json!({
                "method": m.method.label(),
                "corrections_mean": m.summary.mean_corrections,
                "error_max_mm": m.summary.max_mm,
                "error_rms_mm": m.summary.rms_mm,
                "failed": m.failed,
            })
        })
        .collect();
    json!({ "schema": 1, "points": points, "sources": sources, "methods": methods })
}
