//! A superposition study into its folder: the map part by part, so that memory does not grow with the grid.

use serde_json::json;

use super::{
    Pictures, Summary, ablation_table, headline::headline, image, largest_factors_table, locations_table, map_table,
    page, safe_load_table, scaling_table, slopes_table, summary_json, summary_text,
};
use crate::{
    answer::{Output, Run, Shown},
    files::{StatusCount, exchange::StreamedTable},
    input::error::Result,
    page::Description,
    questions::{
        Answered,
        superposition::{DeparturePoint, LocationResult, SuperpositionStudy, run_locations, run_map},
    },
    simulation::status_of,
};

impl Answered for SuperpositionStudy {
    fn answer(&self, shown: &Shown, run: &Run<'_>) -> Result<Output> {
        let study = self;
        let described = vec![("map".to_string(), map_table(&[])), ("safe_load".into(), safe_load_table(study, &[]))];
        let mut tables = Vec::new();
        for (stem, table) in &described {
            tables.push(StreamedTable::new(run.out, stem, table.columns(), run.formats)?);
        }
        let (mut summary, mut pictures) = (Summary::default(), Pictures::new(study, shown));
        let mut image_points: Option<Vec<DeparturePoint>> = run.wants_image().then(Vec::new);
        run_map(study, run.work, |points| {
            for point in &points {
                summary.add(study, point);
                pictures.add(point);
            }
            let parts = [map_table(&points), safe_load_table(study, &points)];
            tables.iter_mut().zip(&parts).try_for_each(|(table, part)| table.add(part))?;
            image_points.iter_mut().for_each(|image| image.extend_from_slice(&points));
            Ok(())
        })?;
        let locations = run_locations(study, run.work)?;
        let mut statuses = summary.statuses().to_vec();
        locations.iter().flat_map(location_statuses).for_each(|status| StatusCount::add(&mut statuses, status));
        let mut files = Vec::new();
        for table in tables {
            files.extend(table.finish()?);
        }
        if let Some(points) = image_points {
            let tables =
                [("map".to_string(), map_table(&points)), ("safe_load".into(), safe_load_table(study, &points))];
            files.extend(image(study).files(run.out, &tables)?);
        }
        Ok(Output {
            tables: vec![
                ("locations".into(), locations_table(&locations)),
                ("largest_factors".into(), largest_factors_table(&locations)),
                ("scaling".into(), scaling_table(&locations)),
                ("slopes".into(), slopes_table(&locations)),
                ("ablation".into(), ablation_table(&locations)),
            ],
            streamed: (files, described),
            figures: run.drawn(|| pictures.figures(study, &locations)),
            details: summary_text(study, &summary, &locations),
            ..Output::of(
                json!({
                    "grid": study.grid.counts(),
                    "tool_angles": study.scene.phis.len(),
                    "tolerance_mm": study.tolerance,
                    "scales": study.scales,
                    "largest_factor": study.largest_factor,
                }),
                statuses,
                summary_json(study, &summary, &locations),
                Description { headline: headline(study, &summary), ..page(study, &summary, &locations) },
            )
        })
    }
}

fn location_statuses(found: &LocationResult) -> [&str; 2] {
    [status_of(&found.departures), status_of(&found.ablation)]
}
