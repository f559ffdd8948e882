//! A workspace map into its folder: block by block, so that memory does not grow with the grid.

use serde_json::json;

use super::{Pictures, Summary, bent::bent, headline::headline, image, page, table, text};
use crate::{
    answer::{Output, Run},
    files::exchange::StreamedTable,
    input::error::Result,
    page::Description,
    questions::map::{MapPoint, Shown, WorkspaceMapStudy, run_in_blocks},
};

/// Computes the map and makes what it leaves.
///
/// # Errors
/// Of the work, and of tables that cannot be written.
pub fn answer(study: &WorkspaceMapStudy, shown: &Shown, run: &Run<'_>) -> Result<Output> {
    let machine = &study.machine;
    let columns = table(machine, &[]);
    let mut streamed = StreamedTable::new(run.out, "map", columns.columns(), run.formats)?;
    let (mut summary, mut pictures) = (Summary::default(), Pictures::new(study, shown));
    let mut image_points: Option<Vec<MapPoint>> = run.wants_image().then(Vec::new);
    run_in_blocks(study, run.work, |points| {
        for point in &points {
            summary.add(study, point);
            pictures.add(machine, point);
        }
        streamed.add(&table(machine, &points))?;
        image_points.iter_mut().for_each(|image| image.extend_from_slice(&points));
        Ok(())
    })?;
    let text = text(&summary, study);
    let mut files = streamed.finish()?;
    if let Some(points) = image_points {
        files.extend(image(study).files(run.out, &[("map".into(), table(machine, &points))])?);
    }
    Ok(Output {
        settings: json!({ "grid": study.grid.counts(), "tool_angles": study.phis.len() }),
        statuses: summary.statuses().to_vec(),
        is_answered: None,
        tables: Vec::new(),
        streamed: (files, vec![("map".into(), columns)]),
        summary: summary.json(),
        figures: run.drawn(|| pictures.figures(study, &summary)),
        page: Description { headline: headline(&summary, study, &text), ..page(study, &text) },
        bent: run.figures.then(|| bent(study)).flatten(),
        details: text.details(),
        best_place: None,
    })
}
