//! A path study into its folder: part by part, so that memory does not grow with the path.

use serde_json::json;

use super::{
    Pictures, Summary, headline::headline, methods_table, methods_text, page, points_columns, points_table, text,
};
use crate::{
    input::error::Result,
    report::{
        Output, Run,
        exchange::{StreamedTable, Table},
        page::{DeflectedPose, Description},
    },
    study::{
        deflected_pose::deflected_pose,
        path::{PathStudy, Shown, run_in_parts},
    },
};

/// Computes the path and makes what it leaves.
///
/// # Errors
/// Of the work, and of tables that cannot be written.
pub fn answer(study: &PathStudy, shown: &Shown, run: &Run<'_>) -> Result<Output> {
    let columns = points_columns(&study.machine);
    let mut table = StreamedTable::new(run.out, "points", &columns, run.formats)?;
    let mut summary = Summary::default();
    let mut pictures = run.figures.then(|| Pictures::new(study, *shown));
    let methods = run_in_parts(study, run.work, |part| {
        summary.add(study, &part);
        pictures.iter_mut().for_each(|pictures| pictures.add(study, &part));
        table.add(&points_table(study, &part))
    })?;
    let (text, statuses) = (text(&summary, study, shown), summary.statuses());
    let bent = summary.farthest().filter(|_| run.figures);
    Ok(Output {
        settings: json!({ "points": study.stations.len() }),
        is_answered: None,
        statuses,
        tables: vec![("methods".into(), methods_table(&methods))],
        streamed: (table.finish()?, vec![("points".into(), Table::new(columns, []))]),
        summary: summary.json(study, &methods),
        figures: pictures.map_or_else(Vec::new, |pictures| pictures.figures(study)),
        page: Description { headline: headline(&summary, study, shown, &text), ..page(study, shown, &text) },
        bent: bent.and_then(|point| bent_at(study, point)),
        details: format!("{}\n{}", text.details(), methods_text(&methods)),
        best_place: None,
    })
}

/// The machine bent at point `point`; `None` if it does not settle there.
fn bent_at(study: &PathStudy, point: usize) -> Option<DeflectedPose> {
    let place = format!("{:.1} mm along the path", study.stations[point].arc_length_mm);
    deflected_pose(&study.machine, &study.errors, &study.demands[point], place)
}
