//! The answer in its folder.

use serde_json::json;

use super::{ReachStudy, Way, run};
use crate::{
    answer::{Output, Run, machine::described},
    files::{
        Manifest, counted,
        exchange::{Cell, Table, numbers, texts},
    },
    input::error::Result,
    page::{Description, TableNote, headline::Headline},
    questions::Answered,
};

impl Answered for ReachStudy {
    fn answer(&self, (): &(), asked: &Run<'_>) -> Result<Output> {
        let ways = run(self, asked.work)?;
        let statuses = Manifest::count(ways.iter().map(status));
        let far = ways.iter().filter(|way| way.way.as_ref().is_ok_and(|way| way.norm() > self.at_most_mm)).count();
        let sentence = format!("{far} of {} points are farther than {} mm from home.", ways.len(), self.at_most_mm);
        let page = Description {
            headline: Headline::new(&sentence, counted(ways.len(), "named point")),
            tables: vec![TableNote::new("ways.csv", "One row per named point.")],
            ..Description::new("reach", described(&self.machine))
        };
        Ok(Output {
            tables: vec![("ways".into(), table(&ways))],
            details: sentence,
            ..Output::of(json!({ "at_most_mm": self.at_most_mm }), statuses, json!({ "far": far }), page)
        })
    }
}

fn status(way: &Way) -> &'static str {
    if way.way.is_ok() { "solved" } else { "unreachable" }
}

fn table(ways: &[Way]) -> Table {
    let columns = [texts(["point", "status", "reason"]), numbers(["way_mm"])].concat();
    let row = |way: &Way| {
        let (reason, length) = match &way.way {
            Ok(way) => (Cell::Missing, way.norm().into()),
            Err(unreachable) => (unreachable.to_string().as_str().into(), Cell::Missing),
        };
        vec![way.name.as_str().into(), status(way).into(), reason, length]
    };
    Table::new(columns, ways.iter().map(row))
}
