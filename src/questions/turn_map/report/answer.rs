//! A map of turns into its folder.

use serde_json::json;

use super::{headline::headline, page::page, pictures::figures, summary::Report, table, text};
use crate::{
    answer::{Output, Run},
    files::StatusCount,
    input::error::Result,
    page::Description,
    questions::turn_map::{TurnMapStudy, resolve::Shown, run},
};

/// Computes the map and makes what it leaves.
///
/// # Errors
/// Of the work, and a machine that cannot turn its tool freely.
pub fn answer(study: &TurnMapStudy, shown: &Shown, asked: &Run<'_>) -> Result<Output> {
    let map = run(study, asked.work)?;
    let report = Report { study, map: &map };
    let mut statuses = Vec::new();
    map.points.iter().for_each(|point| StatusCount::add(&mut statuses, point.status()));
    Ok(Output {
        settings: json!({
            "grid": study.grid.counts(),
            "directions": study.axes.len(),
            "turns": study.turns(),
            "tool_angles": study.phis.len(),
        }),
        statuses,
        is_answered: None,
        tables: vec![("turns".into(), table::table(&report))],
        streamed: Default::default(),
        summary: report.json(),
        figures: asked.drawn(|| figures(&report, shown)),
        page: Description { headline: headline(&report), ..page(&report) },
        bent: None,
        details: text::details(&report),
        best_place: None,
    })
}
