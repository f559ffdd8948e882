//! Study 03, the sweep alone: coarse to fine against brute force, which must agree on the best place. Prints how many
//! times faster it is. Then the whole search of study 03, or of the study that is named behind `--`: how many displacements an exhaustive look at the
//! places of its grid needs, how many equilibria were sought instead, and which share that is of the rate of `Batch` along its path.

use std::{
    path::Path,
    sync::{Arc, Mutex},
    time::Instant,
};

use kinetostat::{
    Batch, Method, Session, TaskPoint,
    compensation::compensate_batch,
    questions::{
        Overrides, Study, StudyKind,
        placement::{PlaceOutcome, PlacementResults, PlacementStudy, Site, run},
    },
    simulation::Source,
    statics::sought_in_batches,
    work::{Event, Work},
};

/// Seconds for which the rate of batches is measured.
const SECONDS: f64 = 2.0;

/// Opens a placement study.
fn placement_of(folder: &Path, overrides: &Overrides) -> PlacementStudy {
    match Study::open(folder, overrides).expect("a valid study").kind {
        StudyKind::Placement(study, ()) => *study,
        _ => panic!("a placement study"),
    }
}

/// Displacements a second that one core finds in batches along the first path of `study` at `site`, rotated by `gamma`, rad.
fn rate_of_batch(study: &PlacementStudy, site: &Site, gamma: f64) -> f64 {
    let job = &study.features[0];
    let tasks = job.tasks_at_gamma(site, gamma).expect("the place can be cut so");
    let mut sessions: Vec<Session> = (0..Batch::WIDTH).map(|_| job.machines.session(Source::All)).collect();
    let mut batch = Batch::new(job.machines.actual(Source::All));
    let lane = tasks.len() / Batch::WIDTH;
    assert!(lane > 0, "the path has fewer points than a batch");
    let (started, mut solved) = (Instant::now(), 0);
    while started.elapsed().as_secs_f64() < SECONDS {
        for k in 0..lane {
            let own: Vec<TaskPoint> = (0..Batch::WIDTH).map(|l| tasks[l * lane + k]).collect();
            let found = compensate_batch(&mut sessions.iter_mut().collect::<Vec<_>>(), &own, Method::None, &mut batch);
            solved += found.iter().filter(|own| own.status.is_success()).count();
        }
    }
    assert!(solved > 0, "no point of the path is solved at {site:?}");
    solved as f64 / started.elapsed().as_secs_f64()
}

/// Prints what the search of `study` needs, prunes and solves.
fn print_effort(study: &PlacementStudy) {
    let (before, started) = (sought_in_batches(), Instant::now());
    let results = run(study, &Work::default()).expect("nothing stops it");
    let (solved, seconds) = ((sought_in_batches() - before) as f64, started.elapsed().as_secs_f64());
    let Some(best) = results.best else { return println!("  no place can be cut") };
    let corners = 1 + study.allowance.sites(&best.site).len();
    let needed: f64 = (study.features.iter())
        .map(|job| {
            let turns = job.gamma_search.as_ref().filter(|own| own.is_sought());
            let turns = turns.map_or(1.0, |own| ((own.range_deg[1] - own.range_deg[0]) / own.step_deg).ceil());
            let points = job.feature.path.points();
            let cutting = points.iter().filter(|point| point.cutting).count();
            turns * if cutting == 0 { points.len() } else { cutting } as f64
        })
        .sum::<f64>()
        * (study.grid.len() * corners) as f64;
    println!("  needed {needed:>12.0} displacements: {} places, each at {corners} of its allowance", study.grid.len());
    println!("  pruned {:>12.0} of them at least", (needed - solved).max(0.0));
    println!("  sought {solved:>12.0} equilibria, of corrections, searches and comparison, too");
    let threads = std::thread::available_parallelism().map_or(1, usize::from) as f64;
    let gamma = results.entries[best.entry].gammas[0].unwrap_or(0.0);
    let rate = rate_of_batch(study, &best.site, gamma);
    let share = 100.0 * solved / seconds / (threads * rate);
    println!(
        "  {share:.0} % of the rate of Batch along the path at the best place, {rate:.0} a second on each of {threads} cores"
    );
}

fn main() {
    // Cargo passes harness options, and `cargo test --benches` only asks that the bench runs.
    let is_test = std::env::args().any(|argument| argument == "--test");
    let points = if is_test { Some(9) } else { Some(361) };
    let overrides = Overrides { grid: is_test.then_some([2, 2, 1]), points, ..Overrides::default() };
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/03_placement_circle");
    let named = std::env::args().skip(1).find(|argument| !argument.starts_with('-'));
    if let Some(named) = named {
        println!("search of {named}");
        return print_effort(&placement_of(Path::new(&named), &Overrides::default()));
    }
    let mut study = placement_of(&folder, &overrides);
    println!("search of {} places, {} path points", study.grid.len(), study.features[0].feature.path.len());
    print_effort(&study);
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
