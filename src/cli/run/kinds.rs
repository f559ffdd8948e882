//! Runs of each kind of study but maps, and what they leave.

use kinetostat::{
    error::Result,
    report::{
        Manifest, file_stem, path as path_report, placement as placement_report, superposition as superposition_report,
        validation as validation_report,
    },
    study::{
        deflected_pose,
        path_study::{self, PathStudy},
        placement::{self, PlacementStudy},
        status_of,
        superposition::{self, LocationResult, SuperpositionStudy},
        validation::{self, ValidationStudy},
    },
};
use serde_json::json;

use super::{Run, output::Output};
use crate::cli::Ending;

pub fn path(run: &Run<'_>, study: &PathStudy) -> Result<Ending> {
    let results = path_study::run(study, &run.work)?;
    let compensated = results.sources.iter().flat_map(|source| &source.compensated);
    let statuses = compensated.map(|answer| answer.compensation.status.label());
    let times: serde_json::Map<String, serde_json::Value> =
        results.methods.iter().map(|m| (m.method.label(), json!(m.seconds_per_point * 1e6))).collect();
    let output = Output {
        run,
        manifest: run.manifest(
            json!({ "points": study.stations.len(), "microseconds_per_point": times }),
            Manifest::count(statuses),
        ),
        tables: vec![
            ("points".into(), path_report::points_table(&results)),
            ("methods".into(), path_report::methods_table(&results)),
        ],
        streamed: Default::default(),
        map: None,
        summary: path_report::summary_json(&results),
        figures: if run.arguments.no_figures { Vec::new() } else { path_report::figures(&results) },
        page: path_report::page(&results).with_answer(&path_report::summary_text(&results)),
        bent: if run.arguments.no_figures { None } else { deflected_pose::of_path(&results) },
        closing: format!("{}\n{}", path_report::summary_text(&results), path_report::methods_text(&results)),
    };
    output.with_unsolved().write()
}

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
        map: None,
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

pub fn superposition(run: &Run<'_>, study: &SuperpositionStudy) -> Result<Ending> {
    let results = superposition::run(study, &run.work)?;
    let map = results.points.iter().map(|point| status_of(&point.departures));
    let statuses = map.chain(results.locations.iter().flat_map(location_statuses));
    let settings = json!({
        "grid": study.grid.counts(),
        "tool_angles": study.phis.len(),
        "tolerance_mm": study.tolerance,
        "scales": study.scales,
        "largest_factor": study.largest_factor,
    });
    let output = Output {
        run,
        manifest: run.manifest(settings, Manifest::count(statuses)),
        tables: vec![
            ("map".into(), superposition_report::map_table(&results)),
            ("safe_load".into(), superposition_report::safe_load_table(&results)),
            ("locations".into(), superposition_report::locations_table(&results)),
            ("largest_factors".into(), superposition_report::largest_factors_table(&results)),
            ("scaling".into(), superposition_report::scaling_table(&results)),
            ("slopes".into(), superposition_report::slopes_table(&results)),
            ("ablation".into(), superposition_report::ablation_table(&results)),
        ],
        streamed: Default::default(),
        map: Some(superposition_report::image(&results)),
        summary: superposition_report::summary_json(&results),
        figures: if run.arguments.no_figures { Vec::new() } else { superposition_report::figures(&results) },
        page: superposition_report::page(&results).with_answer(&superposition_report::summary_text(&results)),
        bent: None,
        closing: superposition_report::summary_text(&results),
    };
    output.with_unsolved().write()
}

fn location_statuses(found: &LocationResult) -> [&str; 2] {
    [status_of(&found.departures), status_of(&found.ablation)]
}

pub fn validation(run: &Run<'_>, study: &ValidationStudy) -> Result<Ending> {
    let results = validation::run(study, &run.work)?;
    let answers = results.paths.iter().flat_map(|path| &path.sources).flat_map(|source| &source.compensated);
    let compared = results.compared.iter().flat_map(|compared| &compared.ours);
    let compared = compared.map(|ours| if ours.is_ok() { "solved" } else { "not_solved" });
    let statuses = answers.map(|answer| answer.compensation.status.label()).chain(compared);
    let points: Vec<usize> = results.paths.iter().map(|path| path.study.stations.len()).collect();
    let mut tables = vec![
        ("summary".to_string(), validation_report::quoted_table(&results)),
        ("variants".to_string(), validation_report::variants_table(&results)),
    ];
    for (name, path) in study.cases.iter().zip(&results.paths) {
        tables.push((format!("points_{}", file_stem(name)), path_report::points_table(path)));
    }
    let output = Output {
        run,
        manifest: run.manifest(json!({ "points": points }), Manifest::count(statuses)),
        tables,
        streamed: Default::default(),
        map: None,
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
