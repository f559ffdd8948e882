//! A validation study into its folder.

use serde_json::json;

use super::{
    differences, figures, headline::headline, page, quoted_table, summary_json, summary_table, variants_table,
};
use crate::{
    answer::{Output, Run},
    files::Manifest,
    input::{check::file_stem, error::Result},
    page::Description,
    questions::{
        path::report::{facts_text, points_table},
        validation::{self, Shown, ValidationStudy},
    },
};

/// Computes the paths and makes what is left.
///
/// # Errors
/// Of the work.
pub fn answer(study: &ValidationStudy, shown: &Shown, run: &Run<'_>) -> Result<Output> {
    let results = validation::run(study, run.work)?;
    let sources = results.paths.iter().flat_map(|path| path.whole.sources.iter());
    let answers = sources.flat_map(|(_, source)| &source.compensated);
    let compared = results.compared.iter().flat_map(|compared| &compared.ours);
    let compared = compared.map(|ours| if ours.is_ok() { "solved" } else { "not_solved" });
    let statuses = Manifest::count(answers.map(|answer| answer.status.label()).chain(compared));
    let points: Vec<usize> = results.paths.iter().map(|path| path.study.stations.len()).collect();
    let mut tables =
        vec![("summary".to_string(), quoted_table(&results)), ("variants".to_string(), variants_table(&results))];
    for (name, path) in study.cases.iter().zip(&results.paths) {
        tables.push((format!("points_{}", file_stem(name)), points_table(&path.study, &path.whole)));
    }
    let assumed = study.variants[0].paths.first().map_or_else(String::new, |path| facts_text(&path.assumed));
    let text = differences(&results);
    Ok(Output {
        settings: json!({ "points": points }),
        is_answered: None,
        statuses,
        tables,
        streamed: Default::default(),
        summary: summary_json(&results),
        figures: run.drawn(|| figures(&results, shown)),
        page: Description { headline: headline(&results, &assumed), ..page(&results, &text) },
        bent: None,
        details: format!("{}\n{text}", summary_table(&results)),
        best_place: None,
    })
}
