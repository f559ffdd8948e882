//! Runs of the kinds of study that hold their results in memory, and what they leave.

use kinetostat::{
    input::error::Result,
    report::{Manifest, file_stem},
    study::{
        path::report as path_report,
        placement::{self, PlacementStudy, report as placement_report},
        validation::{self, ValidationStudy, report as validation_report},
    },
};
use serde_json::json;

use super::{Run, output::Output};
use crate::cli::Ending;

pub fn placement(run: &Run<'_>, study: &PlacementStudy) -> Result<Ending> {
    let results = placement::run(study, &run.work)?;
    let statuses = results.cells.iter().map(placement_report::cell_status);
    let search = &study.search;
    let settings = json!({
        "grid": study.grid.counts(),
        "starts": search.starts,
        "max_iterations": search.max_iterations,
        "tolerance": search.tolerance,
        "coarse_to_fine": search.coarse_to_fine,
    });
    let entries = &results.entries;
    let mut tables = vec![
        ("candidates".to_string(), placement_report::candidates_table(study, entries)),
        ("sweep".into(), placement_report::sweep_table(&results)),
        ("refinements".into(), placement_report::refinements_table(&results)),
    ];
    if !study.objective.pareto.is_empty() {
        tables.push(("pareto".into(), placement_report::front_table(&results)));
    }
    let closing =
        format!("{}\n{}", placement_report::entries_table(study, entries), placement_report::summary_text(&results));
    let output = Output {
        run,
        manifest: run.manifest(settings, Manifest::count(statuses)),
        tables,
        streamed: Default::default(),
        summary: placement_report::summary_json(&results),
        figures: if run.arguments.no_figures { Vec::new() } else { placement_report::figures(&results) },
        page: placement_report::page(&results).with_answer(&placement_report::summary_text(&results)),
        bent: None,
        closing,
    };
    output.write()?;
    // Places where the workpiece cannot be cut are an answer; that there is no other is a failure.
    Ok(if results.best.is_some() { Ending::Complete } else { Ending::SomeUnsolved })
}

pub fn validation(run: &Run<'_>, study: &ValidationStudy) -> Result<Ending> {
    let results = validation::run(study, &run.work)?;
    let answers = results.paths.iter().flat_map(|path| &path.whole.sources).flat_map(|source| &source.compensated);
    let compared = results.compared.iter().flat_map(|compared| &compared.ours);
    let compared = compared.map(|ours| if ours.is_ok() { "solved" } else { "not_solved" });
    let statuses = answers.map(|answer| answer.status.label()).chain(compared);
    let points: Vec<usize> = results.paths.iter().map(|path| path.study.stations.len()).collect();
    let mut tables = vec![
        ("summary".to_string(), validation_report::quoted_table(&results)),
        ("variants".to_string(), validation_report::variants_table(&results)),
    ];
    for (name, path) in study.cases.iter().zip(&results.paths) {
        tables.push((format!("points_{}", file_stem(name)), path_report::points_table(&path.study, &path.whole)));
    }
    let output = Output {
        run,
        manifest: run.manifest(json!({ "points": points }), Manifest::count(statuses)),
        tables,
        streamed: Default::default(),
        summary: validation_report::summary_json(&results),
        figures: if run.arguments.no_figures { Vec::new() } else { validation_report::figures(&results) },
        page: validation_report::page(&results).with_answer(&validation_report::summary_text(&results)),
        bent: None,
        closing: format!(
            "{}\n{}",
            validation_report::summary_table(&results),
            validation_report::summary_text(&results)
        ),
    };
    output.with_unsolved().write()
}
