//! An online study into its folder.

use serde_json::json;

use super::{Compared, headline::headline, page::page, picture::picture, tables, text};
use crate::{
    answer::{Output, Run},
    files::StatusCount,
    input::error::Result,
    page::Description,
    questions::{
        Answered,
        online::{OnlineStudy, run},
    },
};

impl Answered for OnlineStudy {
    fn answer(&self, (): &(), asked: &Run<'_>) -> Result<Output> {
        let results = run(self, asked.work)?;
        let compared = Compared::new(self, &results);
        let mut statuses = Vec::new();
        for trial in &results.trials {
            StatusCount::add(&mut statuses, tables::status(trial));
        }
        Ok(Output {
            is_answered: Some(compared.break_even.is_some()),
            tables: vec![
                ("trials".into(), tables::trials(&results.trials)),
                ("bands".into(), tables::bands(&compared.offline, &compared.online)),
            ],
            figures: asked
                .drawn(|| picture(&compared).map(|figure| ("answer".to_string(), figure)).into_iter().collect()),
            details: text::details(&compared),
            ..Output::of(
                json!({ "points": self.path.stations.len(), "trials": results.trials.len() }),
                statuses,
                json!({
                    "schema": 1,
                    "without_correction": results.plain,
                    "break_even": compared.break_even,
                    "loop_gain": results.loop_gain,
                }),
                Description { headline: headline(&compared), ..page(&compared) },
            )
        })
    }
}
