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
        Answered,
        path::report::{facts_text, points_table},
        validation::{self, Shown, ValidationStudy},
    },
};

impl Answered for ValidationStudy {
    fn answer(&self, shown: &Shown, run: &Run<'_>) -> Result<Output> {
        let results = validation::run(self, run.work)?;
        let sources = results.paths.iter().flat_map(|path| path.whole.sources.iter());
        let answers = sources.flat_map(|(_, along)| along).map(|at| &at.answer);
        let compared = results.compared.iter().flat_map(|compared| &compared.ours);
        let compared = compared.map(|ours| if ours.is_ok() { "solved" } else { "not_solved" });
        let statuses = Manifest::count(answers.map(|answer| answer.status.label()).chain(compared));
        let points: Vec<usize> = results.paths.iter().map(|path| path.study.stations.len()).collect();
        let mut tables =
            vec![("summary".to_string(), quoted_table(&results)), ("variants".to_string(), variants_table(&results))];
        for (name, path) in self.cases.iter().zip(&results.paths) {
            tables.push((format!("points_{}", file_stem(name)), points_table(&path.study, &path.whole)));
        }
        let assumed = self.variants[0].paths.first().map_or_else(String::new, |path| facts_text(&path.assumed));
        let text = differences(&results);
        Ok(Output {
            tables,
            figures: run.drawn(|| figures(&results, shown)),
            details: format!("{}\n{text}", summary_table(&results)),
            ..Output::of(
                json!({ "points": points }),
                statuses,
                summary_json(&results),
                Description { headline: headline(&results, &assumed), ..page(&results, &text) },
            )
        })
    }
}
