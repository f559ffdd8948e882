//! The map's answer in sentences and as a small JSON object.

use serde_json::{Value, json};

use crate::{
    report::{
        table::{force_unit, largest_position, position_unit},
        words::{counted, millimetres, position},
    },
    study::{
        Source,
        superposition::growth::ROUNDING_MM,
        workspace_map::{MapPoint, SourceEffect, WorkspaceMap},
    },
};

/// Solved points of one source with a value each.
fn ranked<'a>(
    map: &'a WorkspaceMap,
    source: Source,
    value: impl Fn(&SourceEffect) -> Option<f64> + 'a,
) -> impl Iterator<Item = (f64, &'a MapPoint, &'a SourceEffect)> {
    map.points.iter().filter_map(move |point| {
        let effect = point.effect(source)?;
        Some((value(effect)?, point, effect))
    })
}

fn at(point: &MapPoint) -> String {
    let [x, y, z] = point.position_mm;
    position(x, y, z)
}

/// Rows that were solved, and all rows.
fn solved_rows(map: &WorkspaceMap) -> (usize, usize) {
    let rows = map.points.iter().flat_map(|point| &point.effects);
    (rows.clone().filter(|effect| effect.is_ok()).count(), rows.count())
}

/// The closing words of a run: how far the tool moves, where, and what must be commanded instead.
pub fn summary_text(map: &WorkspaceMap) -> String {
    let mut text = String::new();
    let (solved, rows) = solved_rows(map);
    let study = &map.study;
    text += &format!(
        "{}: {}, {}, {solved} of {rows} rows solved.\n",
        study.machine.title,
        counted(study.grid.len(), "grid point"),
        counted(study.phis.len(), "tool angle")
    );
    text += &deflection_sentence(map);
    text += &correction_sentence(map);
    text += &departure_sentence(map);
    text
}

fn extremes<'a>(
    values: impl Iterator<Item = (f64, &'a MapPoint, &'a SourceEffect)>,
) -> Option<[(f64, &'a MapPoint, &'a SourceEffect); 2]> {
    let mut found: Option<[(f64, &MapPoint, &SourceEffect); 2]> = None;
    for item in values {
        found = Some(match found {
            None => [item, item],
            Some([least, most]) => {
                [if item.0 < least.0 { item } else { least }, if item.0 > most.0 { item } else { most }]
            }
        });
    }
    found
}

fn deflection_sentence(map: &WorkspaceMap) -> String {
    let mut text = String::new();
    for source in Source::ALL {
        let Some([least, most]) = extremes(ranked(map, source, |e| Some(e.deflection_mm))) else { continue };
        let cause = match source {
            Source::Cutting => "The cutting force alone moves the tool",
            Source::Assembly => "Chain errors alone move it",
            Source::Both => "Both together move it",
        };
        let phi = most.2.phi_deg.map_or_else(String::new, |phi| format!(" (tool angle {phi:.0}°)"));
        text += &format!(
            "{cause} by {} at best, at {}, and by {} at worst, at {}{phi}.\n",
            millimetres(least.0, 3, ROUNDING_MM),
            at(least.1),
            millimetres(most.0, 3, ROUNDING_MM),
            at(most.1)
        );
    }
    text
}

fn correction_sentence(map: &WorkspaceMap) -> String {
    let machine = &map.study.machine;
    let correction = extremes(ranked(map, Source::Both, |e| Some(largest_position(machine, &e.delta_rho))));
    let force = extremes(ranked(map, Source::Both, |e| Some(e.largest_drive_force())));
    let (Some([least, most]), Some([_, force])) = (correction, force) else { return String::new() };
    let unit = position_unit(machine);
    format!(
        "To keep the tool on its path under both, drives must be commanded up to {:.3} {unit} away from the inverse \
         kinematics at best, at {}, and {:.3} {unit} at worst, at {}. Drive forces reach {:.0} {}, at {}.\n",
        least.0,
        at(least.1),
        most.0,
        at(most.1),
        force.0,
        force_unit(machine),
        at(force.1)
    )
}

fn departure_sentence(map: &WorkspaceMap) -> String {
    let ratio = |e: &SourceEffect| e.departure_mm().map(|d| d / e.deflection_mm).filter(|r| r.is_finite());
    let Some([_, absolute]) = extremes(ranked(map, Source::Both, SourceEffect::departure_mm)) else {
        return String::new();
    };
    let Some([_, relative]) = extremes(ranked(map, Source::Both, ratio)) else { return String::new() };
    format!(
        "Adding the two effects instead of solving them together is wrong by up to {}, at {}, and by up to {:.1} % \
         of the deflection, at {}.\n",
        millimetres(absolute.0, 4, ROUNDING_MM),
        at(absolute.1),
        100.0 * relative.0,
        at(relative.1)
    )
}

/// Extremes per source; drive corrections in mm for slides and degrees for hinges, drive forces in N and N·mm.
pub fn summary_json(map: &WorkspaceMap) -> Value {
    let (solved, rows) = solved_rows(map);
    let place = |(value, point, effect): (f64, &MapPoint, &SourceEffect)| json!({ "value": value, "position_mm": point.position_mm, "phi_deg": effect.phi_deg });
    let machine = &map.study.machine;
    let mut sources = serde_json::Map::new();
    for source in Source::ALL {
        let Some([least, most]) = extremes(ranked(map, source, |e| Some(e.deflection_mm))) else { continue };
        let mut entry = json!({ "deflection_mm": { "smallest": place(least), "largest": place(most) } });
        for (key, value) in [
            (
                "delta_rho_largest_drive",
                extremes(ranked(map, source, |e| Some(largest_position(machine, &e.delta_rho)))),
            ),
            ("drive_force_largest_drive", extremes(ranked(map, source, |e| Some(e.largest_drive_force())))),
            ("departure_mm", extremes(ranked(map, source, SourceEffect::departure_mm))),
        ] {
            if let Some([least, most]) = value {
                entry[key] = json!({ "smallest": place(least), "largest": place(most) });
            }
        }
        sources.insert(source.label().into(), entry);
    }
    json!({ "schema": 1, "rows": rows, "rows_solved": solved, "sources": sources })
}
