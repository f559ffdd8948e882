//! Study 03, the sweep alone: coarse to fine against brute force, which must agree on the best place. Prints how many
//! times faster it is.

use std::{
    path::Path,
    sync::{Arc, Mutex},
    time::Instant,
};

use kinetostat::{
    questions::{
        Overrides, Study, StudyKind,
        placement::{PlaceOutcome, PlacementResults, run},
    },
    work::{Event, Work},
};

fn main() {
    // Cargo passes harness options, and `cargo test --benches` only asks that the bench runs.
    let is_test = std::env::args().any(|argument| argument == "--test");
    let points = if is_test { Some(9) } else { Some(361) };
    let overrides = Overrides { grid: is_test.then_some([2, 2, 1]), points, ..Overrides::default() };
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/03_placement_circle");
    let study = Study::open(&folder, &overrides).expect("a valid study");
    let StudyKind::Placement(mut study, ()) = study.kind else { panic!("a placement study") };
    (study.search.starts, study.search.max_iterations) = (1, 1);
    study.candidates.clear();
    println!("sweep of {} places, {} path points", study.grid.len(), study.features[0].feature.path.len());
    for pareto in [study.objective.pareto.clone(), Vec::new()] {
        study.objective.pareto = pareto;
        println!("  {} metrics on the Pareto front", study.objective.pareto.len());
        let mut timed = |coarse_to_fine: bool| -> (PlacementResults, f64) {
            study.search.coarse_to_fine = coarse_to_fine;
            let started = Instant::now();
            let swept = Arc::new(Mutex::new(0.0));
            let note = Arc::clone(&swept);
            // The searches that follow the sweep are the same for both.
            let watch = Box::new(move |event| {
                let mut seconds = note.lock().expect("no thread panics");
                if matches!(event, Event::Stage(_)) && *seconds == 0.0 {
                    *seconds = started.elapsed().as_secs_f64();
                }
            });
            let results = run(&study, &Work::new(None, Arc::default(), watch)).expect("nothing stops it");
            let seconds = *swept.lock().expect("no thread panics");
            (results, seconds)
        };
        let ((fine, brute), (pruned, quick)) = (timed(false), timed(true));
        assert_eq!(fine.best, pruned.best, "the winner changed");
        assert_eq!(fine.front, pruned.front, "the front changed");
        let complete = pruned.cells.iter().filter(|cell| matches!(cell.verdict, PlaceOutcome::Complete(_))).count();
        println!("    brute force    {brute:>7.2} s");
        println!("    coarse to fine {quick:>7.2} s, {complete} places on all points, same winner and front");
        println!("    {:.1} times faster", brute / quick);
    }
}
