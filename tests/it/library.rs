//! The library as another program uses it: files in memory, ranges, runs into folders with progress and stop.

use std::sync::{
    Arc, Mutex,
    atomic::{AtomicBool, Ordering},
};

use kinetostat::{
    Error, Event, Folder, Overrides, RunOptions, Start, Study, StudyKind, Work,
    questions::{map, path, superposition},
};

const PROCESS: &str = r#"
schema = 1
placement = { origin_mm = [20.0, 30.0, 40.0] }
force.path_frame = { radial_force_N = 215.0, tangential_force_N = -10.0, axial_force_N = -25.0 }
[[chain_error]]
chain = "x"
turn_about_drive_axis_deg = 1.0
"#;

fn study(question: &str) -> Study {
    let text = format!(
        "schema = 3\nquestion = \"?\"\nmachine = \"orthoglide\"\nprocess = \"./process/../process.toml\"\n{question}"
    );
    let folder = Folder::in_memory([("process.toml".to_string(), PROCESS.as_bytes().to_vec())]);
    Study::from_toml(&text, "study.toml", folder, &Overrides::default()).unwrap_or_else(|e| panic!("{e}"))
}

const MAP: &str = "[workspace_map]\ngrid = [3, 3, 2]\nslices_z_mm = [0.0]\nphi_step_deg = 120.0\n";

#[test]
fn a_range_is_that_part_of_the_whole() {
    let StudyKind::WorkspaceMap(study, _) = study(MAP).kind else { panic!("a map") };
    let whole = map::run(&study, &Work::default()).unwrap().points;
    assert_eq!(map::run_range(&study, 5..14, &Work::default()).unwrap(), whole[5..14]);
    assert_eq!(map::run_range(&study, 17..99, &Work::default()).unwrap(), whole[17..]);
    let text = "[superposition]\ngrid = [2, 2, 1]\nslices_z_mm = [0.0]\nphi_step_deg = 120.0\ntolerance_mm = 0.01\nlocation = []\n";
    let StudyKind::Superposition(study, _) = self::study(text).kind else { panic!("superposition") };
    let whole = superposition::run(&study, &Work::default()).unwrap().points;
    assert_eq!(superposition::run_range(&study, 1..3, &Work::default()).unwrap(), whole[1..3]);
    let text = "[path]\nmethods = []\ncircle = { centre_mm = [0.0, 0.0, 0.0], diameter_mm = 20.0, points = 300 }\n";
    let StudyKind::Path(study, _) = self::study(text).kind else { panic!("a path") };
    let whole = path::run(&study, &Work::default()).unwrap().whole;
    let part = path::run_range(&study, 256..300, &Work::default()).unwrap();
    for ((_, part), (_, whole)) in part.sources.iter().zip(whole.sources.iter()) {
        assert_eq!(part[..], whole[256..]);
    }
}

#[test]
fn a_study_runs_into_a_folder_stops_and_goes_on() {
    let (folder, study) = (tempfile::tempdir().unwrap(), study(MAP));
    let options = RunOptions { figures: false, program: Some("this test".into()), ..RunOptions::default() };
    let stop = Arc::new(AtomicBool::new(false));
    let seen: Arc<Mutex<Vec<Event>>> = Arc::default();
    let watch = |stop: Arc<AtomicBool>| {
        let seen = Arc::clone(&seen);
        move |event| {
            seen.lock().unwrap().push(event);
            stop.store(true, Ordering::Relaxed);
        }
    };
    let stopped = study.run_into(folder.path(), &options, Arc::clone(&stop), watch(stop));
    assert!(matches!(stopped, Err(Error::Stopped)), "{stopped:?}");
    assert_eq!(seen.lock().unwrap()[0], Event::Resumed { pieces: 0, lost: 0 });
    let options = RunOptions { begin: Start::Resume, ..options };
    let nobody = Arc::default();
    let finished = study.run_into(folder.path(), &options, nobody, watch(Arc::default())).unwrap();
    assert!(finished.is_complete && finished.headline.unsolved.is_none(), "{finished:?}");
    assert!(finished.headline.sentence.starts_with("Tool deflection: "), "{}", finished.headline.sentence);
    assert!(finished.files.iter().all(|file| file.is_file()) && folder.path().join("report.html").is_file());
    assert!(seen.lock().unwrap().contains(&Event::Computed(1)));
    assert!(serde_json::to_string(&finished).unwrap().contains("\"is_complete\":true"));
    let none = RunOptions { formats: Vec::new(), ..options };
    let refused = study.run_into(folder.path(), &none, Arc::default(), |_| ()).unwrap_err().to_string();
    assert_eq!(refused, "settings: format: expected at least one");
}
