//! An online study into its folder.

use serde_json::json;

use super::{Compared, headline::headline, page::page, picture::picture, tables, text};
use crate::{
    answer::{Output, Run},
    files::StatusCount,
    input::error::Result,
    page::Description,
    questions::online::{OnlineStudy, run},
};

/// Computes the study and makes what it leaves.
///
/// # Errors
/// Of the work.
pub fn answer(study: &OnlineStudy, asked: &Run<'_>) -> Result<Output> {
    let results = run(study, asked.work)?;
    let compared = Compared::new(study, &results);
    let mut statuses = Vec::new();
    for trial in &results.trials {
        StatusCount::add(&mut statuses, tables::status(trial));
    }
    Ok(Output {
        settings: json!({ "points": study.path.stations.len(), "trials": results.trials.len() }),
        is_answered: Some(compared.break_even.is_some()),
        statuses,
        tables: vec![
            ("trials".into(), tables::trials(&results.trials)),
            ("bands".into(), tables::bands(&compared.offline, &compared.online)),
        ],
        streamed: Default::default(),
        summary: json!({
            "schema": 1,
            "without_correction": results.plain,
            "break_even": compared.break_even,
            "loop_gain": results.loop_gain,
        }),
        figures: asked.drawn(|| picture(&compared).map(|figure| ("answer".to_string(), figure)).into_iter().collect()),
        page: Description { headline: headline(&compared), ..page(&compared) },
        bent: None,
        details: text::details(&compared),
        best_place: None,
    })
}
