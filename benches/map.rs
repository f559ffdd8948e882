//! A workspace map of 5³ points, 36 tool angles and both sources, on one thread and on all.

use std::path::Path;

use criterion::Criterion;
use kinetostat::{
    questions::{Overrides, Study, StudyKind, map},
    work::Work,
};

fn main() {
    let mut criterion = Criterion::default().configure_from_args().sample_size(10);
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/01_workspace_map");
    let study =
        Study::open(&folder, &Overrides { grid: Some([5, 5, 5]), ..Overrides::default() }).expect("a valid study");
    let StudyKind::WorkspaceMap(map, _) = &study.kind else { panic!("a workspace map") };
    for threads in [1, std::thread::available_parallelism().map_or(1, usize::from)] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a thread pool");
        criterion.bench_function(&format!("map 5x5x5, {threads} threads"), |bencher| {
            bencher.iter(|| pool.install(|| map::run(map, &Work::default()).expect("nothing stops it")));
        });
    }
    criterion.final_summary();
}
