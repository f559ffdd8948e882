//! Run of a workspace map: block by block, so that memory does not grow with the grid.

use kinetostat::{
    input::error::Result,
    report::exchange::{Format, StreamedTable},
    study::{
        deflected_pose,
        map::{
            MapPoint, WorkspaceMapStudy,
            report::{self as report, Pictures, Summary},
            run_in_blocks,
        },
    },
};
use serde_json::json;

use super::{Run, output::Output};
use crate::cli::Ending;

pub fn run(run: &Run<'_>, study: &WorkspaceMapStudy) -> Result<Ending> {
    let machine = &study.machine;
    let formats = run.formats();
    let columns = report::table(machine, &[]);
    let mut table = StreamedTable::new(run.out, "map", columns.columns(), &formats)?;
    let (mut summary, mut pictures) = (Summary::default(), Pictures::new(study));
    let mut image: Option<Vec<MapPoint>> = formats.contains(&Format::Vti).then(Vec::new);
    run_in_blocks(study, &run.work, |points| {
        for point in &points {
            summary.add(machine, point);
            pictures.add(machine, point);
        }
        table.add(&report::table(machine, &points))?;
        image.iter_mut().for_each(|image| image.extend_from_slice(&points));
        Ok(())
    })?;
    let settings = json!({ "grid": study.grid.counts(), "tool_angles": study.phis.len() });
    let answer = summary.text(study);
    let mut files = table.finish()?;
    if let Some(points) = image {
        files.extend(report::image(study).files(run.out, &[("map".into(), report::table(machine, &points))])?);
    }
    let output = Output {
        run,
        manifest: run.manifest(settings, summary.statuses().to_vec()),
        tables: Vec::new(),
        streamed: (files, vec![("map".into(), columns)]),
        summary: summary.json(),
        figures: if run.arguments.no_figures { Vec::new() } else { pictures.figures(study) },
        page: report::page(study).with_answer(&answer),
        bent: if run.arguments.no_figures { None } else { deflected_pose::of_map(study) },
        closing: answer,
    };
    output.with_unsolved().write()
}
