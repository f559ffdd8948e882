//! A placement study into its folder.

use serde_json::{Value, json};

use super::{
    candidates_table, cell_status, entries_table, figures, front_table, headline::headline, page, refinements_table,
    summary_json, summary_text, sweep_table,
};
use crate::{
    answer::{Output, Run},
    files::Manifest,
    input::error::Result,
    page::Description,
    questions::{
        Answered,
        placement::{self, Best, PlacementResults, PlacementStudy},
    },
};

impl Answered for PlacementStudy {
    fn answer(&self, (): &(), run: &Run<'_>) -> Result<Output> {
        let results = placement::run(self, run.work)?;
        let (search, entries) = (&self.search, &results.entries);
        let mut tables = vec![
            ("candidates".to_string(), candidates_table(self, entries)),
            ("sweep".into(), sweep_table(&results)),
            ("refinements".into(), refinements_table(&results)),
        ];
        if !self.objective.pareto.is_empty() {
            tables.push(("pareto".into(), front_table(&results)));
        }
        Ok(Output {
            // Places where the workpiece cannot be cut are an answer; that there is no other is a failure.
            is_answered: Some(results.best.is_some()),
            tables,
            figures: run.drawn(|| figures(&results)),
            details: format!("{}\n{}", entries_table(self, entries), summary_text(&results)),
            best_place: results.best.as_ref().map(|best| best_place(&results, best)),
            ..Output::of(
                json!({
                    "grid": self.grid.counts(),
                    "starts": search.starts,
                    "max_iterations": search.max_iterations,
                    "tolerance": search.tolerance,
                    "coarse_to_fine": search.coarse_to_fine,
                }),
                Manifest::count(results.cells.iter().map(cell_status)),
                summary_json(&results),
                Description { headline: headline(&results), ..page(&results) },
            )
        })
    }
}

fn best_place(results: &PlacementResults, best: &Best) -> Value {
    json!({ "name": results.entries[best.entry].name, "place": best.site.shown(), "objective": best.value })
}
