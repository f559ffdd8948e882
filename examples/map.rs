//! Deflection and corrections over a workspace, from a study made in the program: a few points first, then all of them
//! with progress.
//!
//! ```sh
//! cargo run --release --example map
//! ```

use std::sync::Arc;

use kinetostat::{Event, Grid, LoadCase, Machine, MillingForce, Source, Target, Work, WorkspaceMapStudy, map};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let machine = Machine::named("orthoglide")?;
    let grid = Grid::new(machine.workspace.min, machine.workspace.max, [9, 9, 9]);
    let load_case = LoadCase {
        // Each chain turned by so many degrees about the axis of its drive.
        errors: machine.assembly_errors(&[1.0, -1.0, 1.0]),
        force: MillingForce::KLIMCHIK_GROOVE,
        force_of_turn: String::new(),
        // Tool angles, rad: the worst of them counts.
        phis: (0..36).map(|i| f64::from(10 * i).to_radians()).collect(),
        target: Target::ToolTip,
        tolerance_mm: None,
        machine,
    };
    let study = WorkspaceMapStudy { load_case, grid, uncertainty: None };

    // Any range of points, such as the share of one machine of several.
    for point in map::run_range(&study, 0..2, &Work::default())? {
        println!("{}", serde_json::to_string(&point)?);
    }

    // Setting `stop` from another thread ends the run with an error that says so.
    let stop = Arc::default();
    let work = Work::new(
        None,
        stop,
        Box::new(|event| {
            if let Event::Computed(points) = event {
                log(points);
            }
        }),
    );
    let map = map::run(&study, &work)?;

    let deflection = |point: &&map::MapPoint| point.effect(Source::All).map_or(0.0, |effect| effect.deflection_mm);
    let worst = map.points.iter().max_by(|a, b| deflection(a).total_cmp(&deflection(b)));
    if let Some(worst) = worst {
        println!("the tool moves by up to {:.3} mm, with P at {:?} mm", deflection(&worst), worst.position_mm);
    }
    let unsolved = map.points.iter().filter(|point| point.effect(Source::All).is_none()).count();
    println!("{} points, {unsolved} of them not solved", map.points.len());
    Ok(())
}

/// A real program would draw a bar.
fn log(points: usize) {
    use std::sync::atomic::{AtomicUsize, Ordering};
    static DONE: AtomicUsize = AtomicUsize::new(0);
    let done = DONE.fetch_add(points, Ordering::Relaxed) + points;
    if done.is_multiple_of(243) {
        println!("{done} points computed");
    }
}
