//! Run of a path study: part by part, so that memory does not grow with the path.

use kinetostat::{
    input::error::Result,
    report::exchange::{StreamedTable, Table},
    study::{
        deflected_pose,
        path::{
            PathStudy,
            report::{self as report, Pictures, Summary},
            run_in_parts,
        },
    },
};
use serde_json::json;

use super::{Run, output::Output};
use crate::cli::Ending;

pub fn run(run: &Run<'_>, study: &PathStudy) -> Result<Ending> {
    let columns = report::points_columns(&study.machine);
    let mut table = StreamedTable::new(run.out, "points", &columns, &run.formats())?;
    let mut summary = Summary::default();
    let mut pictures = (!run.arguments.no_figures).then(|| Pictures::new(study));
    let methods = run_in_parts(study, &run.work, |part| {
        summary.add(study, &part);
        pictures.iter_mut().for_each(|pictures| pictures.add(study, &part));
        table.add(&report::points_table(study, &part))
    })?;
    let settings = json!({ "points": study.stations.len() });
    let answer = summary.text(study);
    let bent = summary.farthest().filter(|_| pictures.is_some());
    let output = Output {
        run,
        manifest: run.manifest(settings, summary.statuses()),
        tables: vec![("methods".into(), report::methods_table(&methods))],
        streamed: (table.finish()?, vec![("points".into(), Table::new(columns, []))]),
        summary: summary.json(study, &methods),
        figures: pictures.map_or_else(Vec::new, |pictures| pictures.figures(study)),
        page: report::page(study).with_answer(&answer),
        bent: bent.and_then(|point| deflected_pose::of_path(study, point)),
        closing: format!("{answer}\n{}", report::methods_text(&methods)),
    };
    output.with_unsolved().write()
}
