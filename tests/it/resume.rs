//! Runs that are killed, stopped or run out of disk: what is left, and that going on ends as if nothing had happened.

use std::{
    fs,
    hash::{BuildHasher, RandomState},
    path::{Path, PathBuf},
    process::{Child, Command, Output, Stdio},
    time::{Duration, Instant},
};

use serde_json::Value;

use crate::support::{
    placement::short_placement,
    results::{assert_same, contents},
};

const STATE: &str = "unfinished_run.state";

/// A workspace map that is cheap per point, in several blocks.
const MAP: &str = r#"
schema = 3
question = "How far?"
machine = "orthoglide"

[workspace_map]
grid = [22, 21, 20]
slices_z_mm = [0.0]
phi_step_deg = 120.0

[process.force.path_frame]
radial_force_N = 215.0
tangential_force_N = -10.0
axial_force_N = -25.0

[[process.chain_error]]
chain = "y"
turn_about_drive_axis_deg = -1.0
"#;

fn command(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_kinetostat"));
    command.args(arguments).stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Runs to the end, which must be `code`; what it says on both outputs.
fn ended(code: i32, arguments: &[&str]) -> (String, String) {
    let Output { status, stdout, stderr } = command(arguments).output().unwrap();
    assert_eq!(status.code(), Some(code), "{arguments:?}: {}{}", text(&stdout), text(&stderr));
    (text(&stdout), text(&stderr))
}

/// All files of a folder.
fn study(folder: &Path, toml: &str) -> PathBuf {
    let study = folder.join("study");
    fs::create_dir_all(&study).unwrap();
    fs::write(study.join("study.toml"), toml).unwrap();
    study
}

fn path(path: &Path) -> &str {
    path.to_str().unwrap()
}

/// A number in [0, 1).
fn random() -> f64 {
    (RandomState::new().hash_one(0) >> 11) as f64 / (1_u64 << 53) as f64
}

/// Waits for the end of `child`, but no longer than `most`; whether it has ended.
fn wait(child: &mut Child, most: Duration) -> bool {
    let started = Instant::now();
    while child.try_wait().unwrap().is_none() {
        if started.elapsed() > most {
            return false;
        }
        std::thread::sleep(Duration::from_millis(2));
    }
    true
}

/// Runs `arguments` to the end, then again in another folder, killed at random moments and resumed, on one thread and on two
/// in turns. At least one kill hits.
fn kill_and_resume(folder: &Path, arguments: &[&str], kills: usize) {
    let (whole, cut) = (folder.join("whole"), folder.join("cut"));
    let started = Instant::now();
    ended(0, &[arguments, &["--out", path(&whole)]].concat());
    let time = started.elapsed();
    let resume = [arguments, &["--out", path(&cut), "--resume"]].concat();
    let mut moments = Vec::new();
    for kill in 0..kills {
        // The first hits for certain, whatever else the machine does.
        let moment = time.mul_f64(if kill == 0 { 0.3 * random() } else { random() });
        let threads = if kill % 2 == 0 { "1" } else { "2" };
        let mut child = command(&[&resume[..], &["--threads", threads]].concat()).spawn().unwrap();
        if wait(&mut child, moment) {
            break;
        }
        moments.push(moment);
        child.kill().unwrap();
        child.wait().unwrap();
    }
    assert!(!moments.is_empty(), "{arguments:?} took {time:?} and then ended before it was killed");
    ended(0, &resume);
    assert_same(&cut, &whole, &format!("{arguments:?} killed after {moments:?}"));
}

fn kill_maps(kills: usize) {
    let folder = tempfile::tempdir().unwrap();
    let study = study(folder.path(), MAP);
    kill_and_resume(
        folder.path(),
        &[
            "run",
            path(&study),
            "--format",
            if cfg!(all(feature = "parquet", feature = "vtk")) { "csv,parquet,vti" } else { "csv" },
        ],
        kills,
    );
}

/// Studies of each other kind, and how large they are.
type Sized = (&'static str, [&'static str; 2]);
/// Searches for places are stopped by other tests.
const SMALL: [Sized; 3] =
    [("02_groove_50mm", ["--points", "300"]), ("05_superposition", ["--grid", "2"]), ("06_paper", ["--points", "12"])];
const LARGE: [Sized; 4] = [
    ("02_groove_50mm", ["--points", "600"]),
    ("03_placement_circle", ["--grid", "3"]),
    ("05_superposition", ["--grid", "3"]),
    ("06_paper", ["--points", "24"]),
];

fn kill_other_studies(studies: &[Sized], kills: usize) {
    for &(name, size) in studies {
        let folder = tempfile::tempdir().unwrap();
        let study = Path::new(env!("CARGO_MANIFEST_DIR")).join("studies").join(name);
        kill_and_resume(folder.path(), &["run", path(&study), size[0], size[1], "--no-figures"], kills);
    }
}

#[test]
fn a_killed_map_goes_on_to_the_same_bytes() {
    kill_maps(2);
}

#[test]
fn other_killed_studies_go_on_to_the_same_bytes() {
    kill_other_studies(&SMALL, 1);
}

/// A path in two parts.
fn kill_a_long_path(kills: usize) {
    let folder = tempfile::tempdir().unwrap();
    let from = Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/02_groove_50mm");
    let toml = fs::read_to_string(from.join("study.toml")).unwrap();
    let study = study(folder.path(), &toml.replace("[path]", "[path]\nmethods = [\"direct\"]"));
    fs::copy(from.join("process.toml"), study.join("process.toml")).unwrap();
    let arguments = [
        "run",
        path(&study),
        "--points",
        "6000",
        "--format",
        if cfg!(feature = "parquet") { "csv,parquet" } else { "csv" },
    ];
    kill_and_resume(folder.path(), &arguments, kills);
}

#[test]
#[ignore = "takes minutes; .ci/full runs it"]
fn runs_killed_many_times_go_on_to_the_same_bytes() {
    kill_maps(10);
    kill_other_studies(&LARGE, 5);
    kill_a_long_path(5);
}

/// A study of which a part is computed: interrupted by SIGINT once `kept` bytes of pieces are.
#[cfg(unix)]
fn interrupted(study: &Path, options: &[&str], out: &Path, kept: u64) -> Output {
    let mut child = command(&[&["run", path(study), "--out", path(out)], options].concat()).spawn().unwrap();
    let state = out.join(STATE);
    let started = Instant::now();
    while fs::metadata(&state).map_or(0, |state| state.len()) < kept {
        assert!(child.try_wait().unwrap().is_none(), "the run ended without a piece");
        assert!(started.elapsed() < Duration::from_secs(60), "no piece was kept");
        std::thread::sleep(Duration::from_millis(1));
    }
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    child.wait_with_output().unwrap()
}

/// The first block of a map is of this order; what the study file takes is far less.
#[cfg(unix)]
const A_BLOCK: u64 = 100_000;

#[cfg(unix)]
#[test]
fn ctrl_c_leaves_what_can_be_gone_on_with_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let study = study(folder.path(), MAP);
    let out = folder.path().join("out");
    let Output { status, stdout, stderr } = interrupted(&study, &["--no-figures"], &out, A_BLOCK);
    assert_eq!(status.code(), Some(130), "{}{}", text(&stdout), text(&stderr));
    assert!(text(&stdout).contains("study: stopped after ") && text(&stdout).contains("with --resume goes on."));
    assert_eq!(contents(&out).into_keys().collect::<Vec<_>>(), [STATE]);

    let run = ["run", path(&study), "--out", path(&out), "--no-figures"];
    let (_, refusal) = ended(2, &run);
    assert!(refusal.contains("--resume goes on, --restart begins anew"), "{refusal}");

    let whole = folder.path().join("whole");
    ended(0, &["run", path(&study), "--out", path(&whole), "--no-figures"]);
    let (_, lines) = ended(0, &[&run[..], &["--resume", "--progress", "json", "--quiet"]].concat());
    let first: Value = serde_json::from_str(lines.lines().nth(1).unwrap()).unwrap();
    assert_eq!((&first["event"], &first["total"]), (&"progress".into(), &9240.into()));
    assert_same(&out, &whole, "resumed after Ctrl-C");
}

/// A search stopped each time that so many bytes of pieces are kept.
#[cfg(unix)]
fn stop_a_search(at: &[u64]) {
    let folder = tempfile::tempdir().unwrap();
    let study = short_placement(folder.path());
    let options = ["--no-figures"];
    let (out, whole) = (folder.path().join("out"), folder.path().join("whole"));
    ended(0, &[&["run", path(&study), "--out", path(&whole)], &options[..]].concat());
    for &kept in at {
        let Output { status, stdout, stderr } =
            interrupted(&study, &[&options[..], &["--resume"]].concat(), &out, kept);
        assert_eq!(status.code(), Some(130), "{kept}: {}{}", text(&stdout), text(&stderr));
    }
    ended(0, &[&["run", path(&study), "--out", path(&out), "--resume"], &options[..]].concat());
    assert_same(&out, &whole, &format!("a search stopped at {at:?}"));
}

#[cfg(unix)]
#[test]
fn a_search_can_be_stopped_in_its_sweep_and_in_its_refinements() {
    stop_a_search(&[6_000, 40_000]);
}

#[cfg(unix)]
#[test]
#[ignore = "takes half a minute; .ci/full runs it"]
fn a_search_can_be_stopped_anywhere() {
    stop_a_search(&[6_000, 20_000, 40_000, 60_000]);
}

#[cfg(unix)]
#[test]
fn a_damaged_piece_is_computed_again() {
    let folder = tempfile::tempdir().unwrap();
    let study = study(folder.path(), MAP);
    let (out, whole) = (folder.path().join("out"), folder.path().join("whole"));
    ended(0, &["run", path(&study), "--out", path(&whole), "--no-figures"]);
    interrupted(&study, &["--no-figures"], &out, A_BLOCK);
    let mut state = fs::read(out.join(STATE)).unwrap();
    let middle = A_BLOCK as usize / 2;
    state[middle] ^= 0x10;
    fs::write(out.join(STATE), state).unwrap();
    ended(0, &["run", path(&study), "--out", path(&out), "--resume", "--no-figures"]);
    assert_same(&out, &whole, "after damage");
}

#[cfg(unix)]
#[test]
fn a_hang_up_that_is_ignored_stops_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let study = study(folder.path(), MAP);
    let out = folder.path().join("out");
    let mut shell = Command::new("sh");
    shell.args(["-c", "trap '' HUP; exec \"$@\"", "sh", env!("CARGO_BIN_EXE_kinetostat"), "run"]);
    let mut child = shell.args([path(&study), "--no-figures", "--quiet", "--out", path(&out)]).spawn().unwrap();
    while !out.join(STATE).is_file() {
        assert!(child.try_wait().unwrap().is_none(), "the run ended");
        std::thread::sleep(Duration::from_millis(1));
    }
    assert!(Command::new("kill").args(["-HUP", &child.id().to_string()]).status().unwrap().success());
    assert_eq!(child.wait().unwrap().code(), Some(0));
}

#[cfg(unix)]
#[test]
fn a_changed_input_is_not_gone_on_with() {
    let folder = tempfile::tempdir().unwrap();
    let study = study(folder.path(), MAP);
    let out = folder.path().join("out");
    interrupted(&study, &["--no-figures"], &out, A_BLOCK);
    let before = fs::read(out.join(STATE)).unwrap();
    let run = ["run", path(&study), "--out", path(&out), "--no-figures"];
    let (_, refusal) = ended(2, &[&run[..], &["--resume", "--grid", "22,21,19"]].concat());
    assert!(
        refusal.contains("belongs to another run: grid, line 1: was `[22, 21, 20]`, is `[22, 21, 19]`"),
        "{refusal}"
    );

    fs::write(study.join("study.toml"), MAP.replace("-25.0", "-26.0")).unwrap();
    let (_, refusal) = ended(2, &[&run[..], &["--resume"]].concat());
    let line = "study.toml, line 14: was `axial_force_N = -25.0`, is `axial_force_N = -26.0`";
    assert!(refusal.contains(line), "{refusal}");
    assert!(fs::read(out.join(STATE)).unwrap() == before, "a refusal leaves what there is");

    let (_, refusal) = ended(2, &run);
    assert!(
        refusal.contains("an unfinished run of something else has computed (study.toml, line 14: was"),
        "{refusal}"
    );
    assert!(fs::read(out.join(STATE)).unwrap() == before, "nothing is lost unless that is asked for");
    let whole = folder.path().join("whole");
    ended(0, &["run", path(&study), "--out", path(&whole), "--grid", "3", "--no-figures"]);
    ended(0, &[&run[..], &["--grid", "3", "--restart"]].concat());
    assert_same(&out, &whole, "begun anew");
}

#[cfg(unix)]
#[test]
fn a_folder_has_one_run_at_a_time() {
    let folder = tempfile::tempdir().unwrap();
    let study = study(folder.path(), &MAP.replace("[22, 21, 20]", "[40, 40, 40]"));
    let out = folder.path().join("out");
    let mut first = command(&["run", path(&study), "--out", path(&out)]).spawn().unwrap();
    let started = Instant::now();
    while !out.join(STATE).is_file() {
        assert!(first.try_wait().unwrap().is_none(), "the run ended");
        assert!(started.elapsed() < Duration::from_secs(60), "the run does not begin");
        std::thread::sleep(Duration::from_millis(1));
    }
    std::thread::sleep(Duration::from_millis(50));
    for option in ["--restart", "--resume"] {
        let (_, refusal) = ended(2, &["run", path(&study), "--out", path(&out), option]);
        assert!(refusal.contains("is in use by another run"), "{option}: {refusal}");
    }
    first.kill().unwrap();
    first.wait().unwrap();
}

/// Files may not grow beyond `blocks` of 512 or 1024 bytes, as if the disk were full.
#[cfg(unix)]
fn with_small_files(blocks: usize, arguments: &[&str]) -> Output {
    let limit = format!("trap '' XFSZ; ulimit -f {blocks}; exec \"$@\"");
    let mut shell = Command::new("sh");
    shell.args(["-c", &limit, "sh", env!("CARGO_BIN_EXE_kinetostat")]).args(arguments).output().unwrap()
}

#[cfg(unix)]
#[test]
fn a_full_disk_is_an_error_and_the_run_goes_on_later() {
    let folder = tempfile::tempdir().unwrap();
    let study = study(folder.path(), MAP);
    let (out, whole) = (folder.path().join("out"), folder.path().join("whole"));
    ended(0, &["run", path(&study), "--out", path(&whole), "--no-figures"]);
    // Too small for some piece, then for the table.
    for blocks in [4000, 8000] {
        let run = ["run", path(&study), "--out", path(&out), "--resume", "--no-figures"];
        let Output { status, stdout, stderr } = with_small_files(blocks, &run);
        assert_eq!(status.code(), Some(2), "{blocks}: {}{}", text(&stdout), text(&stderr));
        for expected in [": cannot be written: ", "the same command with --resume goes on"] {
            assert!(text(&stderr).contains(expected), "{blocks}: {}", text(&stderr));
        }
        assert_eq!(contents(&out).into_keys().collect::<Vec<_>>(), [STATE], "{blocks}");
    }
    ended(0, &["run", path(&study), "--out", path(&out), "--resume", "--no-figures"]);
    assert_same(&out, &whole, "after a full disk");
}

#[test]
fn what_a_killed_run_left_is_swept_away() {
    let folder = tempfile::tempdir().unwrap();
    let study = study(folder.path(), MAP);
    let (out, whole) = (folder.path().join("out"), folder.path().join("whole"));
    fs::create_dir_all(&out).unwrap();
    fs::create_dir_all(out.join(".partial-def")).unwrap();
    fs::write(out.join(".partial-def/map.csv"), "half").unwrap();
    let mark = "Files that kinetostat has not finished: they go with its next run.\n";
    fs::write(out.join(".partial-def/kinetostat_unfinished"), mark).unwrap();
    fs::write(out.join(STATE), "no state").unwrap();
    let run = ["run", path(&study), "--grid", "3", "--no-figures", "--out"];
    for options in [&["--resume"][..], &[]] {
        let (_, refusal) = ended(2, &[&run[..], &[path(&out)], options].concat());
        assert!(refusal.contains("is not a file of an unfinished run"), "{refusal}");
    }
    ended(0, &[&run[..], &[path(&out), "--restart"]].concat());
    ended(0, &[&run[..], &[path(&whole), "--resume"]].concat());
    assert_same(&out, &whole, "beside what was left");
    // Killed before anything was begun.
    fs::write(out.join(STATE), "").unwrap();
    ended(0, &[&run[..], &[path(&out), "--resume"]].concat());
    assert_same(&out, &whole, "from an empty state");
}

#[test]
fn progress_log_and_silence_are_as_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let study = study(folder.path(), MAP);
    let (out, log) = (folder.path().join("out"), folder.path().join("run.log"));
    let run = ["run", path(&study), "--grid", "4", "--out", path(&out), "--log", path(&log)];
    let (said, lines) = ended(0, &[&run[..], &["--quiet"]].concat());
    assert_eq!((said.as_str(), lines.as_str()), ("", ""));
    let (said, lines) = ended(0, &[&run[..], &["--progress", "json"]].concat());
    assert!(said.contains("Computed from 64 grid points"), "{said}");
    let events: Vec<Value> = lines.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let names: Vec<&str> = events.iter().map(|event| event["event"].as_str().unwrap()).collect();
    assert_eq!(names.first(), Some(&"started"));
    assert_eq!(names[names.len() - 2..], ["progress", "finished"]);
    let last = &events[events.len() - 2];
    assert_eq!((&last["done"], &last["total"], &last["seconds_left"]), (&64.into(), &64.into(), &0.0.into()));
    let end = &events[events.len() - 1];
    assert_eq!(end["statuses"], serde_json::json!([{ "status": "solved", "rows": 192 }]));
    let log = fs::read_to_string(log).unwrap();
    assert_eq!(log.matches("study: 64 points to compute").count(), 2, "{log}");
    assert_eq!(log.matches("192 solved in ").count(), 2, "{log}");

    let (_, refusal) = ended(2, &["run", path(&study), "--grid", "4", "--log", path(folder.path())]);
    assert!(refusal.contains(": cannot be written: "), "{refusal}");
}
