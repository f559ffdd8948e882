//! A map of turns into its folder.

use serde_json::json;

use super::{headline::headline, page::page, pictures::figures, summary::Report, table, text};
use crate::{
    answer::{Output, Run, Shown},
    files::StatusCount,
    input::error::Result,
    page::Description,
    questions::{
        Answered,
        turn_map::{TurnMapStudy, run},
    },
};

impl Answered for TurnMapStudy {
    fn answer(&self, shown: &Shown, asked: &Run<'_>) -> Result<Output> {
        let study = self;
        let map = run(study, asked.work)?;
        let report = Report { study, map: &map };
        let mut statuses = Vec::new();
        map.points.iter().for_each(|point| StatusCount::add(&mut statuses, point.status()));
        Ok(Output {
            tables: vec![("turns".into(), table::table(&report))],
            figures: asked.drawn(|| figures(&report, shown)),
            details: text::details(&report),
            ..Output::of(
                json!({
                    "grid": study.grid.counts(),
                    "directions": study.axes.len(),
                    "turns": study.turns(),
                    "tool_angles": study.scene.phis.len(),
                }),
                statuses,
                report.json(),
                Description { headline: headline(&report), ..page(&report) },
            )
        })
    }
}
