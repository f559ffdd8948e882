//! Reports on rotation about the tool axis: table of the points, table of comparison, sentences and JSON.

use serde_json::{Value, json};

use super::{DeadEnd, FoundGamma, PathCost, RotatedPath};
use crate::{
    files::{
        exchange::{Table, counts, numbers, texts},
        text_table::text_table,
        words::{capitalised, millimetres_in_table, or_dash, percent},
    },
    process::{GammaChoice, RedundancyObjective, RedundancySettings},
};

/// Names of the compared rows.
const PROGRAMMED: &str = "as programmed";
const CONSTANT: &str = "best constant γ";
const BEST: &str = "best γ at each point";

/// One row per point: whether it counts, γ and cost (distance of the loaded tool from the path) as programmed, at the best constant γ and at
/// the best γ. Cells are empty without equilibrium, or where no γ is possible all along.
#[must_use]
pub fn table(found: &FoundGamma, arc_lengths_mm: impl Iterator<Item = f64>) -> Table {
    let mut columns = counts(["point"]);
    columns.extend(numbers(["arc_length_mm", "counts"]));
    columns.extend(numbers(["programmed_cost_mm", "constant_gamma_deg", "constant_cost_mm", "gamma_deg", "cost_mm"]));
    columns.extend(texts(["branch", "status", "reason"]));
    let rows = arc_lengths_mm.enumerate().map(|(k, arc_length_mm)| {
        let rotated = |path: &Result<RotatedPath, DeadEnd>| {
            let path = path.as_ref().ok();
            [path.map(|path| path.turns_deg[k]), path.and_then(|path| path.along.cost_mm[k])]
        };
        let [constant, best] = [rotated(&found.best_constant), rotated(&found.best)];
        let (branch, status, reason) = match &found.best {
            Ok(rotated) => (rotated.branch.map(|branch| branch.label()), "ok", String::new()),
            Err(dead_end) => (None, dead_end.label(), dead_end.reason()),
        };
        vec![
            k.into(),
            arc_length_mm.into(),
            f64::from(u8::from(found.counted[k])).into(),
            found.as_programmed.cost_mm[k].into(),
            constant[0].into(),
            constant[1].into(),
            best[0].into(),
            best[1].into(),
            branch.into(),
            status.into(),
            reason.into(),
        ]
    });
    Table::new(columns, rows)
}

/// Cost and range of γ (degrees) of one compared row, or why there is none.
type Compared<'a> = Result<(&'a PathCost, [f64; 2]), &'a DeadEnd>;

/// Rows of the comparison, name and result: as programmed, best constant γ, and the best γ if it was sought.
fn compared_rows(found: &FoundGamma, redundancy: GammaChoice) -> Vec<(&'static str, Compared<'_>)> {
    let mut rows = vec![(PROGRAMMED, Ok((&found.as_programmed, [0.0; 2])))];
    rows.push((CONSTANT, found.best_constant.as_ref().map(|rotated| (&rotated.along, rotated.range_deg))));
    if redundancy == GammaChoice::Best {
        rows.push((BEST, found.best.as_ref().map(|rotated| (&rotated.along, rotated.range_deg))));
    }
    rows
}

/// Sentence and table on what γ gains, for a terminal.
#[must_use]
pub fn text(found: &FoundGamma, settings: &RedundancySettings) -> String {
    let mut text = sentence(found, settings);
    let mut table = text_table(["rotation about the tool axis", "γ", "largest", "mean", "rms", "solved"], 1);
    for (name, row) in compared_rows(found, settings.gamma) {
        match row {
            Ok((along, [low, high])) => table.add_row([
                name.to_string(),
                format!("{low:.1} to {high:.1}°"),
                or_dash(along.worst_mm, in_table),
                or_dash(along.mean_mm, in_table),
                or_dash(along.rms_mm, in_table),
                format!("{} of {}", along.solved, along.points),
            ]),
            Err(dead_end) => table.add_row([name.to_string(), format!("none: {}", dead_end.label())]),
        };
    }
    text += &format!("{}, uncompensated:\n{table}\n", capitalised(settings.cost.text()));
    for (branch, reason) in &found.refused {
        text += &format!("Branch left out: {branch}: {reason}.\n");
    }
    text
}

/// A length in mm as the table of comparison shows it.
fn in_table(length_mm: f64) -> String {
    millimetres_in_table(length_mm, 4)
}

/// One sentence on the γ found and what it gains; empty if the tool stands as programmed.
#[must_use]
pub fn sentence(found: &FoundGamma, settings: &RedundancySettings) -> String {
    let rotated = match found.result_for(settings.gamma) {
        None => return String::new(),
        Some(Err(dead_end)) => {
            return format!(
                "No rotation about the tool axis is possible all along, so the path stays as programmed; {}.\n",
                dead_end.reason()
            );
        }
        Some(Ok(rotated)) => rotated,
    };
    let branch = rotated.branch.map_or_else(String::new, |branch| format!(", branch {branch}"));
    type Statistic = fn(&PathCost) -> Option<f64>;
    let gain = |of: Statistic, than: &PathCost, name: &str| match (of(&rotated.along), of(than)) {
        (Some(own), Some(other)) if other > 0.0 && than.solved == than.points => match 1.0 - own / other {
            share if share >= 0.0 => format!("{} less than {name}", percent(share)),
            share => format!("{} more than {name}", percent(-share)),
        },
        _ => format!("{name} not every point of the path could be solved"),
    };
    let gains = |of: Statistic| {
        let constant = found.best_constant.as_ref().ok().filter(|_| settings.gamma == GammaChoice::Best);
        let constant = constant.map(|constant| gain(of, &constant.along, "at the best constant γ"));
        [Some(gain(of, &found.as_programmed, PROGRAMMED)), constant]
            .into_iter()
            .flatten()
            .collect::<Vec<_>>()
            .join(", ")
    };
    let [rms, worst]: [Statistic; 2] = [|along| along.rms_mm, |along| along.worst_mm];
    let (minimised, of, other) = match settings.objective {
        RedundancyObjective::Rms => {
            ("root mean square", rms, Some(format!("; the largest, which is not: {}", gains(worst))))
        }
        RedundancyObjective::Worst => ("largest", worst, None),
    };
    let [low, high] = rotated.range_deg;
    let by = if high - low < 0.05 { format!("{low:.1}°") } else { format!("{low:.1} to {high:.1}°") };
    let outside = if found.leaves_box {
        "No rotation about the tool axis keeps P within the workspace box all along.\n"
    } else {
        ""
    };
    format!(
        "Rotated about the tool axis by γ = {by}{branch}; minimised is the {minimised} of the {}: {}{}.\n{outside}",
        settings.cost.text(),
        gains(of),
        other.unwrap_or_default()
    )
}

/// The comparison as a JSON object: the choice of γ, the cost setting, the branch, and γ range and cost (mm) of each compared row.
#[must_use]
pub fn json(found: &FoundGamma, settings: &RedundancySettings) -> Value {
    let mut entries = serde_json::Map::new();
    let keys = ["as_programmed", "best_constant", "best"];
    for (key, (_, row)) in keys.into_iter().zip(compared_rows(found, settings.gamma)) {
        let entry = match row {
            Ok((along, range)) => json!({
                "gamma_min_deg": range[0],
                "gamma_max_deg": range[1],
                "worst_mm": along.worst_mm,
                "mean_mm": along.mean_mm,
                "rms_mm": along.rms_mm,
                "points": along.points,
                "solved": along.solved,
            }),
            Err(dead_end) => json!({ "status": dead_end.label(), "reason": dead_end.reason() }),
        };
        entries.insert(key.into(), entry);
    }
    let branch = found.result_for(settings.gamma).and_then(|turned| turned.as_ref().ok()?.branch);
    json!({
        "gamma": settings.gamma.label(),
        "cost": settings.cost.label(),
        "leaves_workspace": found.leaves_box,
        "branch": branch.map(|branch| branch.label()),
        "gammas": entries,
    })
}
