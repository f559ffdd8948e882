//! Where a workpiece should stand: places asked about one by one, then the search of a study, run into a folder.
//!
//! ```sh
//! cargo run --release --example place -- studies/03_placement_circle /tmp/placed
//! ```

use std::{path::PathBuf, sync::Arc};

use kinetostat::{Evaluator, Event, Metric, Overrides, RunOptions, Site, Study, StudyKind, nalgebra::Vector3};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let folder = arguments.next().map_or_else(|| PathBuf::from("studies/03_placement_circle"), PathBuf::from);
    let out = arguments.next().map_or_else(|| std::env::temp_dir().join("kinetostat_placed"), PathBuf::from);

    // A study as it is written in a file; a coarse sweep, to be quick.
    let overrides = Overrides { grid: Some([3, 3, 2]), points: Some(37), ..Overrides::default() };
    let study = Study::open(&folder, &overrides)?;
    let StudyKind::Placement(placement, ()) = &study.kind else { return Err("expected a placement study".into()) };

    // Single places: the origin of the workpiece in O, mm, and its yaw, rad.
    let evaluator = Evaluator::new(placement, &Metric::ALL);
    for height_mm in [0.0, 60.0, 120.0, 400.0] {
        match evaluator.evaluate(&Site::new(Vector3::new(0.0, 0.0, height_mm), 0.0)) {
            Ok(found) => {
                let shown = [Metric::WorstDeflection, Metric::WorstCorrection].map(|metric| {
                    let value = found.metrics.get(metric).map(|value| metric.value_text(&placement.machine, value));
                    format!("{} {}", metric.text(&placement.machine), value.unwrap_or_else(|| "unknown".into()))
                });
                println!("z = {height_mm} mm: {}", shown.join(", "));
            }
            Err(failure) => println!("z = {height_mm} mm: {}, {}", failure.status, failure.reason),
        }
    }

    // The whole study: tables, figures and a page, as the command line writes them.
    let options = RunOptions { figures: false, ..RunOptions::default() };
    let stop = Arc::default();
    let finished = study.run_into(&out, &options, stop, |event| {
        if let Event::Stage(stage) = event {
            println!("{} {} to go", stage.items, stage.of);
        }
    })?;
    println!("{}", finished.headline.sentence);
    println!("{} files in {}", finished.files.len(), out.display());
    Ok(())
}
