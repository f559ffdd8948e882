//! Run of a superposition study: the map part by part, so that memory does not grow with the grid.

use kinetostat::{
    input::error::Result,
    report::{
        StatusCount,
        exchange::{Format, StreamedTable},
    },
    study::{
        status_of,
        superposition::{
            LocationResult, MapPoint, SuperpositionStudy,
            report::{self as report, Pictures, Summary},
            run_locations, run_map,
        },
    },
};
use serde_json::json;

use super::{Run, output::Output};
use crate::cli::Ending;

pub fn run(run: &Run<'_>, study: &SuperpositionStudy) -> Result<Ending> {
    let formats = run.formats();
    let described =
        vec![("map".to_string(), report::map_table(&[])), ("safe_load".into(), report::safe_load_table(study, &[]))];
    let mut tables = Vec::new();
    for (stem, table) in &described {
        tables.push(StreamedTable::new(run.out, stem, table.columns(), &formats)?);
    }
    let (mut summary, mut pictures) = (Summary::default(), Pictures::new(study));
    let mut image: Option<Vec<MapPoint>> = formats.contains(&Format::Vti).then(Vec::new);
    run_map(study, &run.work, |points| {
        for point in &points {
            summary.add(study, point);
            pictures.add(point);
        }
        let parts = [report::map_table(&points), report::safe_load_table(study, &points)];
        tables.iter_mut().zip(&parts).try_for_each(|(table, part)| table.add(part))?;
        image.iter_mut().for_each(|image| image.extend_from_slice(&points));
        Ok(())
    })?;
    let locations = run_locations(study, &run.work)?;
    let mut statuses = summary.statuses().to_vec();
    locations.iter().flat_map(location_statuses).for_each(|status| StatusCount::add(&mut statuses, status));
    let settings = json!({
        "grid": study.grid.counts(),
        "tool_angles": study.phis.len(),
        "tolerance_mm": study.tolerance,
        "scales": study.scales,
        "largest_factor": study.largest_factor,
    });
    let mut files = Vec::new();
    for table in tables {
        files.extend(table.finish()?);
    }
    if let Some(points) = image {
        let tables = [
            ("map".to_string(), report::map_table(&points)),
            ("safe_load".into(), report::safe_load_table(study, &points)),
        ];
        files.extend(report::image(study).files(run.out, &tables)?);
    }
    let answer = report::summary_text(study, &summary, &locations);
    let output = Output {
        run,
        manifest: run.manifest(settings, statuses),
        tables: vec![
            ("locations".into(), report::locations_table(&locations)),
            ("largest_factors".into(), report::largest_factors_table(&locations)),
            ("scaling".into(), report::scaling_table(&locations)),
            ("slopes".into(), report::slopes_table(&locations)),
            ("ablation".into(), report::ablation_table(&locations)),
        ],
        streamed: (files, described),
        summary: report::summary_json(study, &summary, &locations),
        figures: if run.arguments.no_figures { Vec::new() } else { pictures.figures(study, &locations) },
        page: report::page(study).with_answer(&answer),
        bent: None,
        closing: answer,
    };
    output.with_unsolved().write()
}

fn location_statuses(found: &LocationResult) -> [&str; 2] {
    [status_of(&found.departures), status_of(&found.ablation)]
}
