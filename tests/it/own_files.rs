//! What a command writes replaces only what a command before wrote, and nothing that it reads; links, devices and names that
//! are too long are told before anything is computed.

use std::{
    fs,
    path::{Path, PathBuf},
    process::{Command, Output},
};

fn command(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_kinetostat"));
    command.args(arguments);
    command
}

fn run(arguments: &[&str]) -> Output {
    command(arguments).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn succeeds(arguments: &[&str]) {
    let output = run(arguments);
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {}", text(&output.stderr));
}

/// Exit code 2, nothing computed, and `expected` on standard error.
fn refused(arguments: &[&str], expected: &str) {
    let output = run(arguments);
    let stderr = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {stderr}");
    assert!(stderr.contains(expected), "{arguments:?}: {stderr}");
}

fn path(file: &Path) -> &str {
    file.to_str().unwrap()
}

fn repository(file: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(file)
}

/// Names in a folder.
fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> =
        fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

/// Makes a folder of unfinished files, as a killed command leaves it.
fn left(folder: &Path) {
    fs::create_dir_all(folder).unwrap();
    fs::write(folder.join("map.csv"), "half").unwrap();
    fs::write(
        folder.join("kinetostat_unfinished"),
        "Files that kinetostat has not finished: they go with its next run.\n",
    )
    .unwrap();
}

/// A program whose compensation takes long, and the arguments that write it as `out`.
fn long_compensation(folder: &Path, out: &Path) -> Vec<String> {
    let moves: String = (0..4000).map(|k| format!("G1 X{} Y{} Z0\n", k % 50, (k * 7) % 50)).collect();
    let program = folder.join("long.nc");
    fs::write(&program, format!("G21 G90 G17\nG0 X0 Y0 Z-5\nG1 Z0 F500\n{moves}M30\n")).unwrap();
    let process = repository("tests/programs/process.toml");
    let words = ["compensate", path(&program), "-m", "orthoglide", "-p", path(&process), "-o", path(out), "-q"];
    words.map(String::from).into()
}

/// Waits until something in `folder` is unfinished.
fn wait_for_unfinished(folder: &Path, child: &mut std::process::Child) {
    let begun = std::time::Instant::now();
    while !names(folder).iter().any(|name| name.starts_with(".out.nc.partial-")) {
        assert!(child.try_wait().unwrap().is_none(), "it ended before anything was begun");
        assert!(begun.elapsed().as_secs() < 120, "nothing was begun");
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
}

#[test]
#[cfg(unix)]
fn an_output_is_of_one_command_and_one_that_is_stopped_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out/out.nc");
    let arguments = long_compensation(folder.path(), &out);
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let before = names(folder.path());
    for signal in ["-INT", "-TERM"] {
        let mut child = command(&arguments).stderr(std::process::Stdio::null()).spawn().unwrap();
        while !out.parent().unwrap().exists() {
            assert!(child.try_wait().unwrap().is_none(), "it ended before anything was begun");
            std::thread::sleep(std::time::Duration::from_millis(5));
        }
        wait_for_unfinished(out.parent().unwrap(), &mut child);
        // Another is refused, and the first goes on.
        refused(&arguments, "out.nc: cannot be written: is being written by another command");
        assert!(child.try_wait().unwrap().is_none());
        assert!(Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap().success());
        assert_eq!(child.wait().unwrap().code(), Some(130));
        assert_eq!(names(folder.path()), before, "{signal}");
    }
    // One that is killed leaves what the next one takes away.
    let mut child = command(&arguments).spawn().unwrap();
    while !out.parent().unwrap().exists() {
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    wait_for_unfinished(out.parent().unwrap(), &mut child);
    child.kill().unwrap();
    child.wait().unwrap();
    let short = repository("tests/programs/groove.nc");
    succeeds(&[&["compensate", path(&short)], &arguments[2..]].concat());
    assert_eq!(
        names(out.parent().unwrap()),
        ["out.nc", "out.nc.budget.csv", "out.nc.html", "out.nc.points.csv", "out.nc.report.json"]
    );
}

const MAP: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/studies/01_workspace_map");

/// A study of a path whose polyline has the name of a table that runs write.
fn path_study(folder: &Path) -> (PathBuf, PathBuf) {
    let study = folder.join("study");
    fs::create_dir(&study).unwrap();
    let polyline = study.join("points.csv");
    fs::write(&polyline, "x_mm,y_mm,z_mm\n0,0,0\n1,0,0\n").unwrap();
    fs::write(study.join("process.toml"), "schema = 1\n[placement]\norigin_mm = [0.0, 0.0, 100.0]\n").unwrap();
    let text = "schema = 3\nquestion = \"?\"\nmachine = \"orthoglide\"\nprocess = \"process.toml\"\n[path]\nfile = \"points.csv\"\nmethods = [\"direct\"]\n";
    fs::write(study.join("study.toml"), text).unwrap();
    (study, polyline)
}

#[test]
fn a_run_into_its_own_study_loses_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let (study, polyline) = path_study(folder.path());
    let before = (names(&study), fs::read(&polyline).unwrap());
    let arguments = ["run", path(&study), "--no-figures", "--out", path(&study)];
    refused(&arguments, "points.csv: cannot be written: is an input of this command");
    assert_eq!((names(&study), fs::read(&polyline).unwrap()), before);
    // Also where a run before wrote it.
    let out = folder.path().join("out");
    let into_out = ["run", path(&study), "--no-figures", "--out", path(&out)];
    succeeds(&into_out);
    succeeds(&into_out);
    let text = fs::read_to_string(study.join("study.toml")).unwrap();
    fs::write(study.join("study.toml"), text.replace("\"points.csv\"", "\"../out/points.csv\"")).unwrap();
    fs::write(out.join("points.csv"), "x_mm,y_mm,z_mm\n0,0,0\n1,0,0\n").unwrap();
    refused(&into_out, "points.csv: cannot be written: is an input of this command");
}

#[test]
fn a_run_leaves_files_of_others() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path();
    let arguments = ["run", MAP, "--grid", "1", "--no-figures", "--out", path(out)];
    for name in ["map.csv", "summary.json", "report.html", "manifest.json", "csv-metadata.json"] {
        fs::write(out.join(name), "mine").unwrap();
        refused(&arguments, &format!("{name}: cannot be written: was not written by kinetostat"));
        assert_eq!(fs::read_to_string(out.join(name)).unwrap(), "mine");
        fs::remove_file(out.join(name)).unwrap();
        let _ = fs::remove_file(out.join("unfinished_run.state"));
        assert_eq!(names(out), [""; 0]);
    }
    fs::write(out.join("notes.txt"), "mine").unwrap();
    succeeds(&arguments);
    succeeds(&arguments);
    assert_eq!(fs::read_to_string(out.join("notes.txt")).unwrap(), "mine");
}

#[cfg(unix)]
#[test]
fn nothing_is_written_through_links_or_to_devices() {
    use std::os::unix::fs::symlink;
    let folder = tempfile::tempdir().unwrap();
    let (out, elsewhere) = (folder.path().join("out"), folder.path().join("elsewhere"));
    fs::create_dir(&out).unwrap();
    let arguments = ["run", MAP, "--grid", "1", "--no-figures", "--out", path(&out)];
    for name in ["map.csv", "unfinished_run.state", "manifest.json"] {
        for content in [None, Some("")] {
            content.iter().for_each(|content| fs::write(&elsewhere, content).unwrap());
            symlink(&elsewhere, out.join(name)).unwrap();
            refused(&arguments, &format!("{name}: "));
            assert_eq!(fs::read_to_string(&elsewhere).ok().as_deref(), content);
            fs::remove_file(out.join(name)).unwrap();
            let _ = fs::remove_file(&elsewhere);
        }
    }
    let (groove, process) = (repository("tests/programs/groove.nc"), repository("tests/programs/process.toml"));
    let compensate = ["compensate", path(&groove), "--machine", "orthoglide", "--process", path(&process), "--out"];
    // A link instead of the device itself: a failing test must not cost the machine its devices.
    let pipe = folder.path().join("pipe");
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    refused(&[&compensate[..], &[path(&pipe)]].concat(), "pipe: cannot be written: is a device or a pipe");
    refused(&["report", path(&repository("results/01_workspace_map")), "--out", path(&pipe)], "is a device or a pipe");
    refused(&[&arguments[..], &["--log", path(&pipe)]].concat(), "is a device or a pipe");
}

#[test]
fn a_compensated_program_is_replaced_only_as_it_was_left() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out.nc");
    let (groove, process) = (repository("tests/programs/groove.nc"), repository("tests/programs/process.toml"));
    let arguments =
        ["compensate", path(&groove), "--machine", "orthoglide", "--process", path(&process), "--out", path(&out)];
    fs::write(&out, "mine").unwrap();
    refused(&arguments, "out.nc: cannot be written: was not written by kinetostat, or was changed since");
    assert_eq!(fs::read_to_string(&out).unwrap(), "mine");
    fs::remove_file(&out).unwrap();
    // What a killed command left of this file, and what another one is just writing.
    for name in [".out.nc.partial-abc", ".other.nc.partial-abc", ".partial-abc"] {
        left(&folder.path().join(name));
    }
    // What one that was killed as it began left: nothing yet, and half of the mark.
    left(&folder.path().join(".out.nc.partial-mark"));
    fs::write(folder.path().join(".out.nc.partial-mark/kinetostat_unfinished"), "Files that").unwrap();
    fs::remove_file(folder.path().join(".out.nc.partial-mark/map.csv")).unwrap();
    fs::create_dir(folder.path().join(".out.nc.partial-5Jubefb0a3Xy")).unwrap();
    // What only has such a name.
    fs::create_dir(folder.path().join(".out.nc.partial-backup")).unwrap();
    fs::write(folder.path().join(".out.nc.partial-backup/thesis.txt"), "mine").unwrap();
    fs::write(folder.path().join(".out.nc.partial-letter"), "mine").unwrap();
    fs::create_dir(folder.path().join(".out.nc.partial-place")).unwrap();
    succeeds(&arguments);
    let written = ["out.nc", "out.nc.budget.csv", "out.nc.html", "out.nc.points.csv", "out.nc.report.json"];
    let others = [
        ".other.nc.partial-abc",
        ".out.nc.partial-backup",
        ".out.nc.partial-letter",
        ".out.nc.partial-place",
        ".partial-abc",
    ];
    assert_eq!(names(folder.path()), [&others[..], &written].concat());
    assert_eq!(names(&folder.path().join(".out.nc.partial-backup")), ["thesis.txt"]);
    let first: Vec<_> = written.iter().map(|name| fs::read(folder.path().join(name)).unwrap()).collect();
    succeeds(&arguments);
    let second: Vec<_> = written.iter().map(|name| fs::read(folder.path().join(name)).unwrap()).collect();
    assert!(first == second, "same input, same bytes");
    for name in ["out.nc", "out.nc.budget.csv", "out.nc.html", "out.nc.points.csv"] {
        let file = folder.path().join(name);
        let own = fs::read(&file).unwrap();
        fs::write(&file, "edited by hand").unwrap();
        refused(&arguments, &format!("{name}: cannot be written: was not written by kinetostat, or was changed since"));
        assert_eq!(fs::read_to_string(&file).unwrap(), "edited by hand");
        fs::write(&file, own).unwrap();
    }
    fs::write(folder.path().join("out.nc.report.json"), "{}").unwrap();
    refused(&arguments, "out.nc.report.json: cannot be written: was not written by kinetostat");
    succeeds(&[&arguments[..], &["--force"]].concat());
    let forced: Vec<_> = written.iter().map(|name| fs::read(folder.path().join(name)).unwrap()).collect();
    assert!(first == forced, "--force replaces what is not its own");
}

#[test]
fn what_is_read_only_stays() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out.nc");
    let (groove, process) = (repository("tests/programs/groove.nc"), repository("tests/programs/process.toml"));
    let arguments =
        ["compensate", path(&groove), "--machine", "orthoglide", "--process", path(&process), "--out", path(&out)];
    succeeds(&arguments);
    let written = fs::read(&out).unwrap();
    let mut permissions = fs::metadata(&out).unwrap().permissions();
    permissions.set_readonly(true);
    fs::set_permissions(&out, permissions).unwrap();
    for force in [&[][..], &["--force"]] {
        refused(&[&arguments[..], force].concat(), "out.nc: cannot be written: is read-only and left as it is");
    }
    assert_eq!(fs::read(&out).unwrap(), written);
}

#[test]
fn no_input_of_a_compensation_is_written_over() {
    let folder = tempfile::tempdir().unwrap();
    let copy = |name: &str| {
        let file = folder.path().join(name);
        fs::copy(repository("tests/programs").join(name), &file).unwrap();
        file
    };
    let (groove, process) = (copy("groove.nc"), copy("process.toml"));
    let machine = folder.path().join("machine.toml");
    fs::copy(repository("crates/engine/src/machine/catalogue/orthoglide.toml"), &machine).unwrap();
    for input in [&groove, &process, &machine] {
        let before = fs::read(input).unwrap();
        let arguments = [
            "compensate",
            path(&groove),
            "--machine",
            path(&machine),
            "--process",
            path(&process),
            "--out",
            path(input),
        ];
        refused(&arguments, "cannot be written: is an input of this command");
        assert_eq!(fs::read(input).unwrap(), before);
    }
    // A log is no input and not one of somebody else.
    let arguments = ["compensate", path(&groove), "--machine", path(&machine), "--process", path(&process), "--out"];
    let out = folder.path().join("out.nc");
    let with_log = [&arguments[..], &[path(&out), "--log", path(&machine)]].concat();
    refused(&with_log, "machine.toml: cannot be written: was not written by kinetostat");
    let log = folder.path().join("log");
    let with_log = [&arguments[..], &[path(&out), "--log", path(&log)]].concat();
    succeeds(&with_log);
    succeeds(&with_log);
}

#[test]
fn a_page_replaces_pages_only() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    succeeds(&["run", MAP, "--grid", "2", "--no-figures", "--out", path(&out)]);
    let table = fs::read(out.join("map.csv")).unwrap();
    refused(
        &["report", path(&out), "--out", path(&out.join("map.csv"))],
        "map.csv: cannot be written: was not written",
    );
    assert_eq!(fs::read(out.join("map.csv")).unwrap(), table);
    let page = folder.path().join("page.html");
    for _ in 0..2 {
        succeeds(&["report", path(&out)]);
        succeeds(&["report", path(&out), "--out", path(&page)]);
    }
    fs::write(&page, "<html>mine</html>").unwrap();
    refused(&["report", path(&out), "--out", path(&page)], "page.html: cannot be written: was not written");
}

#[test]
fn names_that_are_too_long_are_told_first() {
    let folder = tempfile::tempdir().unwrap();
    let long = "n".repeat(250);
    let (groove, process) = (repository("tests/programs/groove.nc"), repository("tests/programs/process.toml"));
    let out = folder.path().join("new").join(&long);
    let arguments =
        ["compensate", path(&groove), "--machine", "orthoglide", "--process", path(&process), "--out", path(&out)];
    refused(&arguments, "File name too long");
    let mut deep = folder.path().to_path_buf();
    (0..15).for_each(|_| deep.push(&long));
    deep.push("n".repeat(4060_usize.saturating_sub(path(&deep).len()).min(250)));
    refused(&["run", MAP, "--grid", "1", "--no-figures", "--out", path(&deep)], "File name too long");
    assert_eq!(run(&arguments).stdout, b"", "nothing was computed");
}

#[cfg(unix)]
#[test]
fn a_signal_before_anything_is_computed_and_a_folder_that_goes_are_told_in_words() {
    use std::{process::Stdio, time::Duration};
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let study = folder.path().join("study");
    fs::create_dir(&study).unwrap();
    // Reading this much takes a while, in which there is no work yet that could be stopped.
    fs::copy(repository("tests/programs/process.toml"), study.join("process.toml")).unwrap();
    let rows: String = (0..300_000).map(|k| format!("{}.0,0.0,0.0\n", k % 2)).collect();
    fs::write(study.join("path.csv"), format!("x_mm,y_mm,z_mm\n{rows}")).unwrap();
    let text = "schema = 3\nquestion = \"?\"\nmachine = \"orthoglide\"\nprocess = \"process.toml\"\n[path]\nfile = \"path.csv\"\nmethods = [\"direct\"]\n";
    fs::write(study.join("study.toml"), text).unwrap();
    let log = folder.path().join("log");
    let arguments = ["run", path(&study), "--no-figures", "--out", path(&out), "--log", path(&log)];
    let child = command(&arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    while !log.exists() {
        std::thread::sleep(Duration::from_millis(1));
    }
    assert!(Command::new("kill").args(["-TERM", &child.id().to_string()]).status().unwrap().success());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(130), "{}", text_of(&output));
    assert!(text_of(&output).to_lowercase().contains("stopped"), "{}", text_of(&output));

    let _ = fs::remove_dir_all(&out);
    let map = ["run", MAP, "--grid", "9", "--no-figures", "--out", path(&out)];
    let child = command(&map).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    while !out.join("unfinished_run.state").exists() {
        std::thread::sleep(Duration::from_millis(5));
    }
    std::thread::sleep(Duration::from_millis(50));
    fs::remove_dir_all(&out).unwrap();
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(2), "{}", text_of(&output));
    assert!(text_of(&output).contains("the folder was removed during the run"), "{}", text_of(&output));
}

#[cfg(unix)]
fn text_of(output: &Output) -> String {
    text(&output.stdout) + &text(&output.stderr)
}
