//! A path study into its folder: part by part, so that memory does not grow with the path.

use serde_json::json;

use super::{
    Pictures, Summary, headline::headline, methods_table, methods_text, page, points_columns, points_table, text,
};
use crate::{
    answer::{Output, Run, Streams, deflected_pose::deflected_pose},
    files::exchange::Table,
    input::error::Result,
    page::{DeflectedPose, Description},
    questions::{
        Answered,
        path::{PathStudy, Shown, run_in_parts},
    },
    redundancy,
};

impl Answered for PathStudy {
    fn answer(&self, shown: &Shown, run: &Run<'_>) -> Result<Output> {
        let turned = self.turned(run.work)?;
        let study = turned.as_ref();
        let columns = Table::new(points_columns(&study.machine), []);
        let mut table = Streams::new(run, None).with("points", columns, |part| points_table(study, part))?;
        let mut summary = Summary::default();
        let mut pictures = run.figures.then(|| Pictures::new(study, *shown));
        let methods = run_in_parts(study, run.work, |part| {
            summary.add(study, &part);
            pictures.iter_mut().for_each(|pictures| pictures.add(study, &part));
            table.add(&part)
        })?;
        let (text, statuses) = (text(&summary, study, shown), summary.statuses());
        let bent = summary.farthest().filter(|_| run.figures);
        let mut tables = vec![("methods".into(), methods_table(&methods))];
        let mut summary_json = summary.json(study, &methods);
        let mut turns = String::new();
        if let Some((turn, found)) = study.turn.as_ref().and_then(|turn| Some((turn, turn.found.as_deref()?))) {
            let arc_lengths_mm = study.stations.iter().map(|station| station.arc_length_mm);
            tables.push(("tool_turn".into(), redundancy::report::table(found, arc_lengths_mm)));
            summary_json["tool_turn"] = redundancy::report::json(found, turn.how());
            turns = redundancy::report::text(found, turn.how());
        }
        Ok(Output {
            tables,
            streamed: table.finish()?,
            figures: pictures.map_or_else(Vec::new, |pictures| pictures.figures(study)),
            bent: bent.and_then(|point| bent_at(study, point)),
            details: format!("{}\n{}{turns}", text.details(), methods_text(&methods)),
            ..Output::of(
                json!({ "points": study.stations.len() }),
                statuses,
                summary_json,
                Description { headline: headline(&summary, study, shown, &text), ..page(study, shown, &text) },
            )
        })
    }
}

/// The machine bent at point `point`; `None` if it does not settle there.
fn bent_at(study: &PathStudy, point: usize) -> Option<DeflectedPose> {
    let place = format!("{:.1} mm along the path", study.stations[point].arc_length_mm);
    deflected_pose(&study.machine, &study.errors, &study.demands[point], place)
}
