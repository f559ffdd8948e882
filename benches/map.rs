//! A workspace map of 5³ points, 36 tool angles and both sources, on one thread and on all; and what uncertain inputs cost: maps and paths of an arm
//! and of a hexapod with exact inputs, with six uncertain parameters and with thirty.

use std::path::Path;

use criterion::Criterion;
use kinetostat::{
    Folder,
    questions::{
        Overrides, Study, StudyKind,
        map::{self, WorkspaceMapStudy},
        path::{self, PathStudy},
    },
    work::Work,
};

/// The study of `machine` with the tables `uncertainty` and `question`.
fn study_of(machine: &str, uncertainty: &str, question: &str) -> StudyKind {
    let exact = if uncertainty.is_empty() { "" } else { "[uncertainty]\nmachine = \"exact\"\n" };
    let text = format!(
        "schema = 3\nquestion = \"?\"\nmachine = \"{machine}\"\n{exact}{uncertainty}\n[process.force.path_frame]\nradial_force_N = 800.0\n\
         tangential_force_N = 300.0\naxial_force_N = -200.0\n{question}\n"
    );
    Study::from_toml(&text, "study.toml", Folder::in_memory([]), &Overrides::default()).expect("a valid study").kind
}

/// A map of 4³ points of `machine` with its slice at `z` mm, and the table `uncertainty`.
fn map_of(machine: &str, z: f64, uncertainty: &str) -> WorkspaceMapStudy {
    match study_of(machine, uncertainty, &format!("[workspace_map]\ngrid = [4, 4, 4]\nslices_z_mm = [{z:?}]")) {
        StudyKind::WorkspaceMap(map, _) => *map,
        _ => panic!("a workspace map"),
    }
}

/// A circle of 512 points of `machine` around `centre` (mm), and the table `uncertainty`.
fn path_of(machine: &str, centre: [f64; 3], uncertainty: &str) -> PathStudy {
    let circle = format!("[path]\ncircle = {{ centre_mm = {centre:?}, diameter_mm = 100.0, points = 512 }}");
    match study_of(machine, uncertainty, &circle) {
        StudyKind::Path(path, _) => *path,
        _ => panic!("a path"),
    }
}

/// Six stiffnesses, and 24 errors of chains or lengths beside them.
const ARM: [&str; 2] = [
    "[[uncertainty.parameter]]\nname = \"arm.*.stiffness\"\nrelative_std = 0.2\n",
    "[[uncertainty.chain_error]]\nchain = \"*\"\nbase_translation_mm = { std = 0.1 }\nbase_rotation_deg = { std = 0.01 }\n\
     end_translation_mm = { std = 0.1 }\nend_rotation_deg = { std = 0.01 }\ndrive_offsets_mm_or_deg = { std = 0.01 }\n\
     [[uncertainty.parameter]]\nname = \"arm.fixed_2.translation.*\"\nstd = 0.1\n[[uncertainty.parameter]]\nname = \"arm.fixed_3.translation.*\"\nstd = 0.1\n",
];
const HEXAPOD: [&str; 2] = [
    "[[uncertainty.parameter]]\nname = \"leg.screw.stiffness\"\nrelative_std = 0.2\n",
    "[[uncertainty.chain_error]]\nchain = \"*\"\nbase_translation_mm = { std = 0.05 }\ndrive_offsets_mm_or_deg = { std = 0.02 }\n",
];

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
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread pool");
    for (machine, centre, [six, more]) in
        [("kr270", [1800.0, 0.0, 850.0], ARM), ("hexapod", [0.0, 0.0, 800.0], HEXAPOD)]
    {
        let force = "[uncertainty.process]\nforce_relative_std = 0.15";
        for uncertainty in [String::new(), format!("{six}{force}"), format!("{six}{more}{force}")] {
            let map = map_of(machine, centre[2], &uncertainty);
            let count = map.uncertainty.as_ref().map_or(0, |own| own.parameters.len());
            criterion.bench_function(&format!("map of {machine}, {count} uncertain parameters"), |bencher| {
                bencher.iter(|| one.install(|| map::run(&map, &Work::default()).expect("nothing stops it")));
            });
            let path = path_of(machine, centre, &uncertainty);
            criterion.bench_function(&format!("path of {machine}, {count} uncertain parameters"), |bencher| {
                bencher.iter(|| one.install(|| path::run(&path, &Work::default()).expect("nothing stops it")));
            });
        }
    }
    criterion.final_summary();
}
