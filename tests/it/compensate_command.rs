//! `kinetostat compensate` end to end: the written program, read again and simulated, follows the wanted path.

use std::{
    path::{Path, PathBuf},
    process::{Command, Output},
};

use kinetostat::{
    files::{Foreign, OutputFile, exchange::MAX_ROWS, staging_beside, write_all},
    products::program::files::ProgramFiles,
};
use serde_json::{Value, json};

use crate::support::machines::machine_path;

/// What was printed, wherever its lines end.
fn unwrapped(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/programs")
}

fn run(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_kinetostat")).args(arguments).output().unwrap()
}

/// Compensates `program` by `process` into a temporary folder; the process's output and the folder.
fn compensate(program: &Path, process: &Path, more: &[&str]) -> (Output, tempfile::TempDir) {
    let out = tempfile::tempdir().unwrap();
    let target = out.path().join("out.nc");
    let mut arguments = vec!["compensate", program.to_str().unwrap(), "--machine", "orthoglide", "--process"];
    arguments.extend([process.to_str().unwrap(), "--out", target.to_str().unwrap()]);
    arguments.extend(more);
    (run(&arguments), out)
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn report(out: &tempfile::TempDir) -> Value {
    serde_json::from_slice(&std::fs::read(out.path().join("out.nc.report.json")).unwrap()).unwrap()
}

fn error_max(pass: &Value) -> f64 {
    pass["error_max_mm"].as_f64().unwrap()
}

fn write(folder: &tempfile::TempDir, name: &str, text: &str) -> PathBuf {
    let file = folder.path().join(name);
    std::fs::write(&file, text).unwrap();
    file
}

#[test]
fn written_program_keeps_the_tool_on_its_path() {
    let (output, out) = compensate(&folder().join("groove.nc"), &folder().join("process.toml"), &[]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let report = report(&out);
    let passes = report["passes"].as_array().unwrap();
    assert_eq!(passes[0]["commands"], "none");
    assert!(error_max(&passes[0]) > 1.0);
    let (exact, written) = (&passes[passes.len() - 2], &passes[passes.len() - 1]);
    assert_eq!(exact["commands"], "direct");
    assert!(error_max(exact) < 1e-8);
    assert_eq!(written["commands"], "direct, as written");
    // The write tolerance, times what the machine makes of it.
    assert!(error_max(written) < 6e-3, "{written}");
    let stdout = text(&output.stdout);
    assert!(stdout.contains("direct, as written"), "{stdout}");
    assert!(text(&output.stderr).is_empty(), "no progress in a pipe");
}

/// A program that its machine cannot run as it is placed is not said to be ready.
#[test]
fn a_program_outside_the_workspace_box_is_not_to_be_loaded() {
    let groove = Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/02_groove_50mm");
    for (process, can_run) in [("process_middle.toml", true), ("process_program.toml", false)] {
        let (output, out) = compensate(&groove.join("groove.nc"), &groove.join(process), &[]);
        let page = std::fs::read_to_string(out.path().join("out.nc.html")).unwrap();
        let shown = unwrapped(&text(&output.stdout));
        let verdict = if can_run {
            "✓ Within 0.5 mm by force, geometry and rounding [nominal inputs] [simulated] [as asked] ● force ◐ geometry ● rounding Compensated, the tool is up to 0.0049 mm off; without, 0.681 mm."
        } else {
            "✗ 270 of 359 points outside the workspace [nominal inputs] [simulated] ● force ◐ geometry ● rounding As placed, this path cannot be run;"
        };
        assert!(shown.starts_with(verdict), "{shown}");
        for said in [&shown, &page] {
            assert_eq!(said.contains("Load the program in place of groove.nc"), can_run, "{process}");
            assert_eq!(
                said.contains("Do not load the program: orthoglide cannot run it as placed."),
                !can_run,
                "{process}"
            );
        }
    }
}

#[test]
fn only_motion_words_change() {
    let (_, out) = compensate(&folder().join("groove.nc"), &folder().join("process.toml"), &[]);
    let written = std::fs::read_to_string(out.path().join("out.nc")).unwrap();
    for kept in [
        "%\nO0002 (50 mm groove; the tool points to +Z, so retract is -Z)\n",
        "N10 G21 G90 G17 G54 ; metric, absolute\n",
        "\n\nN30 S3000 M3\n",
        "N70 M30\n%\n",
    ] {
        assert!(written.contains(kept), "{kept:?} is missing in\n{written}");
    }
    assert_eq!(written.matches("F600").count(), 1, "the feed is said where it was said");
    assert_eq!(written.matches("(full circle)").count(), 1);
}

#[test]
fn nothing_to_correct_leaves_the_same_bytes() {
    let inputs = tempfile::tempdir().unwrap();
    let process = write(&inputs, "nothing.toml", "schema = 1\n");
    let programs = Path::new(env!("CARGO_MANIFEST_DIR")).join("crates/programs/tests/gcode");
    let mut compared = 0;
    for entry in std::fs::read_dir(programs).unwrap() {
        let program = entry.unwrap().path();
        let (output, out) = compensate(&program, &process, &[]);
        // Programs that leave this machine's workspace, or need a work offset, are refused; see the tests of G-code.
        if output.status.code() == Some(0) {
            let written = std::fs::read(out.path().join("out.nc")).unwrap();
            assert_eq!(written, std::fs::read(&program).unwrap(), "{}", program.display());
            compared += 1;
        }
    }
    assert!(compared >= 10, "only {compared} programs were within reach");
}

#[test]
fn a_program_keeps_the_dialect_that_it_shows_or_that_is_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let heidenhain = "0 BEGIN PGM A MM\n1 TOOL CALL 1 Z S1000 F200\n2 L X+0 Y+0 Z+0 FMAX\n3 L X+20\n4 END PGM A MM\n";
    let plain = "G0 X0 Y0 Z0\nG2 X20 Y0 I10 J0 F200\nG54 G1 X5 D1\n";
    let process = "schema = 1\n[force.path_frame]\nradial_force_N = 100.0\ntangential_force_N = -10.0\naxial_force_N = -25.0\n[gcode]\n";
    let process = |dialect: &str| write(&folder, "process.toml", &format!("{process}{dialect}\n"));
    let said = |sentence: &str, output: &Output| unwrapped(&text(&output.stdout)).contains(sentence);
    let program = write(&folder, "a.h", heidenhain);
    let (output, out) = compensate(&program, &process(""), &[]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(said("Read as a Heidenhain program, and written as one.", &output), "{}", text(&output.stdout));
    assert_eq!(report(&out)["dialect"], "heidenhain");
    let written = std::fs::read_to_string(out.path().join("out.nc")).unwrap();
    assert!(written.starts_with("0 BEGIN PGM A MM\n1 TOOL CALL 1 Z S1000 F200\n2 L X"), "{written}");
    let page = std::fs::read_to_string(out.path().join("out.nc.html")).unwrap();
    assert!(page.contains("Read as a Heidenhain program, and written as one."));

    let program = write(&folder, "plain.nc", plain);
    for (key, words) in [("", "G20 or G21"), ("dialect = \"sinumerik\"", "G700 or G710")] {
        let (output, out) = compensate(&program, &process(key), &[]);
        let expected = format!("plain.nc: names no unit before line 1: expected {words} there, or unit = ");
        assert!(output.status.code() == Some(2) && unwrapped(&text(&output.stderr)).contains(&expected), "{output:?}");
        assert!(!out.path().join("out.nc").exists());
    }
    for (key, arguments, read_as) in [
        ("", &[][..], "iso"),
        ("dialect = \"sinumerik\"", &[], "sinumerik"),
        ("dialect = \"sinumerik\"", &["--dialect", "auto"], "iso"),
        ("dialect = \"heidenhain\"", &["--dialect", "sinumerik"], "sinumerik"),
    ] {
        let (output, out) = compensate(&program, &process(&format!("{key}\nunit = \"mm\"")), arguments);
        assert!(output.status.success(), "{}", text(&output.stderr));
        assert_eq!(report(&out)["dialect"], read_as, "{key} {arguments:?}");
        assert_eq!(said("Read as a Sinumerik program", &output), read_as == "sinumerik");
    }
    let (output, _) = compensate(&program, &process(""), &["--dialect", "heidenhain"]);
    let message = unwrapped(&text(&output.stderr));
    assert!(message.contains("plain.nc:1:1: `G0 X0 Y0 Z0`: not a statement that is read"), "{message}");
    assert!(message.ends_with("(read as Heidenhain)"), "{message}");
}

#[test]
fn every_method_is_named_and_proved() {
    let more = ["--all-methods", "--method", "newton"];
    let (output, out) = compensate(&folder().join("groove.nc"), &folder().join("process.toml"), &more);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let report = report(&out);
    let names: Vec<&str> =
        report["passes"].as_array().unwrap().iter().map(|pass| pass["commands"].as_str().unwrap()).collect();
    for name in ["none", "linear", "mirror", "mirror_3", "matrix_free", "fixed_matrix", "procedure", "direct"] {
        assert!(names.contains(&name), "{name} in {names:?}");
    }
    assert_eq!(&names[names.len() - 2..], ["newton", "newton, as written"]);
}

#[test]
fn polylines_are_compensated_and_bring_their_own_load() {
    let inputs = tempfile::tempdir().unwrap();
    let header = "x_mm,y_mm,z_mm,force_x_N,force_y_N,force_z_N";
    let rows: Vec<String> = (0..=20).map(|k| format!("{}.0,10.0,0.0,150.0,-80.0,-25.0", 2 * k)).collect();
    let path = write(&inputs, "path.csv", &format!("{header}\n{}\n", rows.join("\n")));
    let process =
        write(&inputs, "p.toml", "schema = 1\n[placement]\norigin_mm = [0.0, 0.0, 100.0]\n[force]\nfrom_path = true\n");
    let (output, out) = compensate(&path, &process, &[]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let report = report(&out);
    let passes = report["passes"].as_array().unwrap();
    assert!(error_max(&passes[0]) > 0.1);
    assert!(error_max(&passes[passes.len() - 1]) < 1.5e-3);
    let written = std::fs::read_to_string(out.path().join("out.nc")).unwrap();
    assert!(written.starts_with(header) && written.lines().count() == 22, "{written}");
}

#[test]
fn a_measured_pass_is_mirrored() {
    let inputs = tempfile::tempdir().unwrap();
    let point = |k: u32, shift: f64| format!("{},10.0,0.0", f64::from(2 * k) + shift);
    let csv = |shift: f64| {
        let rows: Vec<String> = (0..=5).map(|k| point(k, shift)).collect();
        format!("x_mm,y_mm,z_mm\n{}\n", rows.join("\n"))
    };
    let path = write(&inputs, "path.csv", &csv(0.0));
    let measured = write(&inputs, "measured.csv", &csv(0.25));
    let process = write(&inputs, "p.toml", "schema = 1\n[placement]\norigin_mm = [0.0, 0.0, 100.0]\n");
    let (output, out) = compensate(&path, &process, &["--measured", measured.to_str().unwrap()]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let written = std::fs::read_to_string(out.path().join("out.nc")).unwrap();
    for (k, line) in (0..=5).zip(written.lines().skip(1)) {
        let x: f64 = line.split(',').next().unwrap().parse().unwrap();
        assert!((x - (f64::from(2 * k) - 0.25)).abs() < 1e-9, "{line}");
    }
    let short = write(&inputs, "short.csv", "x_mm,y_mm,z_mm\n0.0,0.0,0.0\n");
    let (output, _) = compensate(&path, &process, &["--measured", short.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).contains("has 1 positions, but the path has 6 rows"), "{}", text(&output.stderr));
}

#[test]
fn a_cut_beyond_reach_writes_nothing_and_says_where() {
    let inputs = tempfile::tempdir().unwrap();
    let process = write(&inputs, "p.toml", "schema = 1\n[placement]\norigin_mm = [0.0, 0.0, 100.0]\n");
    for far in ["X400", "X100000", "Y-100000"] {
        let program = write(&inputs, "far.nc", &format!("G21 G90\nG0 X0 Y0 Z0\nG1 {far} F500\n"));
        let (output, out) = compensate(&program, &process, &[]);
        assert_eq!(output.status.code(), Some(1));
        let stdout = text(&output.stdout);
        assert!(
            stdout.contains("cannot reach or track every point; nothing was written")
                && stdout.contains("line 3, point"),
            "{stdout}"
        );
        assert_eq!(std::fs::read_dir(out.path()).unwrap().count(), 0);
    }
}

#[test]
fn mistakes_are_named() {
    let (program, process) = (folder().join("groove.nc"), folder().join("process.toml"));
    for (more, expected) in [
        (
            vec!["--method", "magic"],
            "error: --method: no method \"magic\"; there are: none, linear, mirror, mirror_3, matrix_free, fixed_matrix, procedure, newton, direct, bounded\n",
        ),
        (vec!["--alpha", "0.5"], "error: --alpha: method direct has no step length\n"),
        (vec!["--method", "matrix_free", "--alpha", "1.5"], "error: --alpha: must be above 0 and at most 1, got 1.5\n"),
    ] {
        let (output, out) = compensate(&program, &process, &more);
        assert_eq!(output.status.code(), Some(2));
        assert_eq!(text(&output.stderr), expected);
        assert_eq!(std::fs::read_dir(out.path()).unwrap().count(), 0);
    }
    let (output, _) = compensate(Path::new("missing.nc"), &process, &[]);
    assert!(text(&output.stderr).starts_with("error: missing.nc: cannot be read"), "{}", text(&output.stderr));
}

#[test]
fn limits_bind_where_they_must_and_are_kept() {
    let inputs = tempfile::tempdir().unwrap();
    let limited = |limits: &str| {
        let process = std::fs::read_to_string(folder().join("process.toml")).unwrap();
        write(&inputs, "limited.toml", &format!("{process}\n[limits]\n{limits}\n"))
    };
    let bounded = ["--method", "bounded"];
    let (output, out) = compensate(&folder().join("groove.nc"), &limited("max_correction_mm = 1.5"), &bounded);
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(text(&output.stdout).contains("correction of drive x at"), "{}", text(&output.stdout));
    let binding = report(&out)["bounded"]["limits_binding"].clone();
    assert_eq!(binding.as_array().unwrap().len(), 1, "{binding}");
    let mut table = csv::Reader::from_path(out.path().join("out.nc.points.csv")).unwrap();
    let column = table.headers().unwrap().iter().position(|name| name == "delta_rho_x_mm").unwrap();
    let largest = table.records().map(|row| row.unwrap()[column].parse::<f64>().unwrap().abs()).fold(0.0, f64::max);
    // Within 0.005 mm when it was written.
    assert!((1.49..1.51).contains(&largest), "{largest}");

    let (output, out) = compensate(&folder().join("groove.nc"), &limited("max_correction_mm = 5.0"), &bounded);
    assert!(text(&output.stdout).contains("No limit binds"), "{}", text(&output.stdout));
    let passes = report(&out)["passes"].clone();
    assert!(error_max(&passes.as_array().unwrap()[3]) < 1e-6);

    let (output, out) = compensate(&folder().join("groove.nc"), &limited("force_limit_N = 50.0"), &bounded);
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).contains("its force cannot be brought below"), "{}", text(&output.stderr));
    assert_eq!(std::fs::read_dir(out.path()).unwrap().count(), 0);
}

#[test]
fn the_table_of_a_very_long_program_is_bounded_and_says_so() {
    let inputs = tempfile::tempdir().unwrap();
    let process = std::fs::read_to_string(folder().join("process.toml")).unwrap();
    let process = write(&inputs, "fine.toml", &format!("{process}\n[sampling]\nmax_segment_mm = 0.003\n"));
    let program = folder().join("groove.nc");
    let rows = |out: &tempfile::TempDir| -> Vec<String> {
        let table = std::fs::read_to_string(out.path().join("out.nc.points.csv")).unwrap();
        table.lines().skip(1).map(String::from).collect()
    };
    let (output, out) = compensate(&program, &process, &[]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let (some, found) = (rows(&out), report(&out));
    let total = found["points"].as_u64().unwrap() as usize;
    assert!(total > MAX_ROWS && some.len() <= MAX_ROWS && some.len() > MAX_ROWS / 8, "{total} {}", some.len());
    let note = format!("out.nc.points.csv has {} of {total} rows: every ", some.len());
    let page = std::fs::read_to_string(out.path().join("out.nc.html")).unwrap();
    for said in [unwrapped(&text(&output.stdout)), page, found.to_string()] {
        assert!(said.contains(&note), "{note}\n{said}");
    }
    let (output, out) = compensate(&program, &process, &["--points", "all"]);
    assert!(!text(&output.stdout).contains("rows: every"), "{}", text(&output.stdout));
    let all = rows(&out);
    assert_eq!(all.len(), total);
    assert_eq!(report(&out)["passes"], found["passes"]);
    let mut rest = all.iter();
    assert!(some.iter().all(|row| rest.any(|other| other == row)));
    let header = std::fs::read_to_string(out.path().join("out.nc.points.csv")).unwrap();
    let columns: Vec<&str> = header.lines().next().unwrap().split(',').collect();
    let largest = |rows: &[String], column: usize| {
        let values = rows.iter().filter_map(|row| row.split(',').nth(column)?.parse::<f64>().ok());
        values.fold(0.0, |most, value| f64::max(most, value.abs()))
    };
    for (column, name) in columns.iter().enumerate().filter(|(_, name)| name.ends_with("_mm") || name.ends_with("_N")) {
        assert_eq!(largest(&some, column), largest(&all, column), "{name}");
    }
    let (output, _) = compensate(&program, &process, &["--points", "100"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).contains("expected all"), "{}", text(&output.stderr));
}

#[test]
fn an_input_is_not_written_over() {
    let inputs = tempfile::tempdir().unwrap();
    let groove = std::fs::read_to_string(folder().join("groove.nc")).unwrap();
    let program = write(&inputs, "groove.nc", &groove);
    let (name, process) = (program.to_str().unwrap(), folder().join("process.toml"));
    let output =
        run(&["compensate", name, "--machine", "orthoglide", "--process", process.to_str().unwrap(), "--out", name]);
    assert_eq!(output.status.code(), Some(2));
    let message = format!("{name}: cannot be written: is an input of this command; expected another place");
    assert!(text(&output.stderr).contains(&message), "{}", text(&output.stderr));
    assert_eq!(std::fs::read_to_string(&program).unwrap(), groove);
}

/// Compensates `program` for `machine` under `process`, both as text; the output and the folder with `out.nc`.
fn compensate_on(machine: &str, program: (&str, &str), process: &str, more: &[&str]) -> (Output, tempfile::TempDir) {
    let out = tempfile::tempdir().unwrap();
    let (program, process) = (write(&out, program.0, program.1), write(&out, "process.toml", process));
    let target = out.path().join("out.nc");
    let mut arguments = vec!["compensate", program.to_str().unwrap(), "--machine", machine, "--process"];
    arguments.extend([process.to_str().unwrap(), "--out", target.to_str().unwrap()]);
    arguments.extend(more);
    (run(&arguments), out)
}

const FORCE: &str = "[force.path_frame]\nradial_force_N = 215.0\ntangential_force_N = -10.0\naxial_force_N = -25.0\n\
                     law = \"rotated\"\n";

const NOT_CONTROLLED: &str = "Not controlled by this machine: z of the base, taken where the machine stands; words of a \
                              program for z stay.";

/// The table that `compare` prints of `table` as a path at the places `at`, after success.
fn compared(machine: &str, table: &str, process: &str, at: &[&str]) -> (String, Vec<Vec<String>>) {
    let folder = tempfile::tempdir().unwrap();
    let (path, process) = (write(&folder, "path.csv", table), write(&folder, "process.toml", process));
    let names = [&process, &path].map(|path| path.to_str().unwrap());
    let mut arguments = vec!["compare", "--machine", machine, "--process", names[0], "--path", names[1]];
    at.iter().for_each(|place| arguments.extend(["--at", place]));
    let (screen, table) = (run(&arguments), run(&[&arguments[..], &["--csv"]].concat()));
    assert!(screen.status.success() && table.status.success(), "{}{}", text(&screen.stdout), text(&screen.stderr));
    let mut reader = csv::ReaderBuilder::new().has_headers(false).from_reader(table.stdout.as_slice());
    let rows = reader.records().map(|row| row.unwrap().iter().map(String::from).collect()).collect();
    (text(&screen.stdout), rows)
}

#[test]
fn places_of_a_path_at_another_height_cost_what_the_machine_does_at_its_own() {
    let process = format!("schema = 1\n{FORCE}");
    let (said, rows) = compared(
        &machine_path("rrr3"),
        "x_mm,y_mm,z_mm\n10,5,80\n10,5,-1.5\n-20,5,-1.5\n",
        &process,
        &["0,0,0", "0,0,25"],
    );
    assert!(unwrapped(&said).contains(NOT_CONTROLLED.trim()), "{said}");
    let z = rows[0].iter().position(|name| name == "z_mm").unwrap();
    let metrics = |row: &[String]| row[z + 1..].to_vec();
    assert_eq!(metrics(&rows[1]), metrics(&rows[2]));
    assert_ne!(rows[1][z], rows[2][z]);
}

#[test]
fn a_closed_polyline_costs_the_same_at_a_place_from_every_corner() {
    let corners = ["0,0,0", "30,0,0", "30,20,0", "0,20,0"];
    let process = format!("schema = 1\n[placement]\norigin_mm = [50.0, 40.0, 150.0]\n{FORCE}");
    let tables: Vec<Vec<Vec<String>>> = (0..4)
        .map(|first| {
            let rows: Vec<&str> = (0..=4).map(|k| corners[(first + k) % 4]).collect();
            compared("orthoglide", &format!("x_mm,y_mm,z_mm\n{}\n", rows.join("\n")), &process, &[]).1
        })
        .collect();
    let mut numbers = 0;
    for other in &tables[1..] {
        for (a, b) in other[1].iter().zip(&tables[0][1]) {
            match (a.parse::<f64>(), b.parse::<f64>()) {
                (Ok(a), Ok(b)) => {
                    assert!((a - b).abs() <= 1e-8 * b.abs().max(1.0), "{tables:#?}");
                    numbers += 1;
                }
                _ => assert_eq!(a, b),
            }
        }
    }
    assert!(numbers > 3 * 8, "{tables:#?}");
}

#[test]
fn words_of_axes_that_a_planar_machine_does_not_control_stay() {
    let machines = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/machines");
    for (machine, [x, y]) in [("rrr3.toml", [10, 5]), ("fivebar.toml", [10, 455])] {
        let program =
            format!("G21 G90 G17\nG0 X{x} Y{y} Z80\nG1 Z-1.5 F200\nG1 X-20 F400\nG1 X-30 Y{y} Z-2.25\nG0 Z80.0\nM30\n");
        let process = format!("schema = 1\n[placement]\norigin_mm = [0.0, 0.0, 0.0]\n{FORCE}");
        let machine = machines.join(machine);
        let (output, out) = compensate_on(machine.to_str().unwrap(), ("part.nc", &program), &process, &[]);
        assert!(output.status.success(), "{}{}", text(&output.stdout), text(&output.stderr));
        let said = text(&output.stdout);
        assert!(unwrapped(&said).contains(NOT_CONTROLLED.trim()), "{said}");
        let written = std::fs::read_to_string(out.path().join("out.nc")).unwrap();
        // A plunge that is split passes heights between; the words of the program are there byte for byte, in their order.
        let heights = |text: &str| -> Vec<String> {
            text.split_whitespace().filter(|word| word.starts_with('Z')).map(String::from).collect()
        };
        let mut reached = heights(&written).into_iter();
        assert!(heights(&program).iter().all(|wanted| reached.any(|word| word == *wanted)), "{written}");
        // On the way between them they only fall, and where the height stays no word is needed.
        let cut: Vec<&str> = written.lines().skip_while(|line| !line.contains("Z-1.5")).skip(1).collect();
        let flat = cut.iter().take_while(|line| !line.contains('Z')).count();
        assert!(flat > 1 && cut[flat].contains("Z-"), "{written}");
        assert!(written.lines().any(|line| line.starts_with("G0 ") && line.ends_with("Z80.0")), "{written}");
        assert_eq!(report(&out)["axes_left_as_written"], serde_json::json!(["z"]));
        let passes = report(&out)["passes"].clone();
        let passes = passes.as_array().unwrap();
        // The residual is the bending out of the plane, which no drive can compensate.
        assert!(unwrapped(&said).contains("the drives do not control z."), "{said}");
        let (exact, written) = (error_max(&passes[passes.len() - 2]), error_max(&passes[passes.len() - 1]));
        assert!((written - exact).abs() < 2e-3 && exact < 0.5 * error_max(&passes[0]), "{passes:?}");
    }
}

#[test]
fn a_polyline_is_split_proven_and_written_like_the_same_program() {
    let process = format!("schema = 1\n[placement]\norigin_mm = [0.0, 0.0, 200.0]\n{FORCE}");
    let table = "x_mm,y_mm,z_mm,feed_mm_per_min\n-20,-10,0,300\n60,50,0,300\n110,110,0,250\n";
    let program = "G21 G90\nG0 X-20 Y-10 Z0\nG1 X60 Y50 F300\nG1 X110 Y110 F250\n";
    let (by_table, out_table) = compensate_on("orthoglide", ("path.csv", table), &process, &[]);
    let (by_program, out_program) = compensate_on("orthoglide", ("path.nc", program), &process, &[]);
    assert!(by_table.status.success() && by_program.status.success(), "{}", text(&by_table.stderr));
    let (table_report, program_report) = (report(&out_table), report(&out_program));
    assert_eq!(table_report["points"], program_report["points"]);
    for report in [&table_report, &program_report] {
        let passes = report["passes"].as_array().unwrap();
        assert!(error_max(&passes[passes.len() - 1]) < 6e-3, "{report:#}");
        assert!(error_max(&passes[0]) > 0.1);
    }
    // Rows of the file keep their other cells; rows between them have those of the row they lead to.
    let written = std::fs::read_to_string(out_table.path().join("out.nc")).unwrap();
    let rows: Vec<&str> = written.lines().collect();
    assert!(rows.len() > 4 && rows[0] == "x_mm,y_mm,z_mm,feed_mm_per_min", "{written}");
    assert!(rows[1].ends_with(",300") && rows[rows.len() - 1].ends_with(",250"), "{written}");
    assert!(rows[1..].iter().all(|row| row.ends_with(",300") || row.ends_with(",250")), "{written}");
}

#[test]
fn a_closed_polyline_costs_the_same_from_every_corner() {
    let corners = ["0,0,0", "30,0,0", "30,20,0", "0,20,0"];
    let process = format!("schema = 1\n[placement]\norigin_mm = [50.0, 40.0, 150.0]\n{FORCE}");
    let errors: Vec<[f64; 2]> = (0..4)
        .map(|first| {
            let rows: Vec<&str> = (0..=4).map(|k| corners[(first + k) % 4]).collect();
            let table = format!("x_mm,y_mm,z_mm\n{}\n", rows.join("\n"));
            let (output, out) = compensate_on("orthoglide", ("loop.csv", &table), &process, &[]);
            assert!(output.status.success(), "{}", text(&output.stderr));
            let pass = &report(&out)["passes"][0];
            ["error_max_mm", "error_rms_mm"].map(|key| pass[key].as_f64().unwrap())
        })
        .collect();
    for other in &errors[1..] {
        for (a, b) in other.iter().zip(&errors[0]) {
            assert!((a - b).abs() < 1e-8 * b, "{errors:?}");
        }
    }
}

#[test]
fn what_cuts_and_where_the_workpiece_stands_are_said() {
    let program = "G21 G90\nG0 X0 Y0 Z20\nG1 Z0 F900\nG1 X20 F300\nG1 Z20 F900\nM30\n";
    let cutting = |more: &str| {
        let process = format!("schema = 1\n{more}\n{FORCE}");
        let (output, out) = compensate_on("orthoglide", ("part.nc", program), &process, &["--verbose"]);
        assert!(output.status.success(), "{}", text(&output.stderr));
        (unwrapped(&text(&output.stdout)), report(&out))
    };
    let (said, all) = cutting("");
    assert!(said.contains("Workpiece: origin at (0, 0, 0) mm of the base, assumed: the process gives no"), "{said}");
    assert!(said.contains("Counts as cutting: every move but rapid ones, also through air."), "{said}");
    let (said, low) = cutting("[placement]\norigin_mm = [0.0, 0.0, 100.0]\n[cutting]\nbelow_z_mm = 0.5");
    assert!(said.contains("Workpiece: origin at (0, 0, 100) mm of the base; path of the tool tip."), "{said}");
    assert!(said.contains("with z of the workpiece up to 0.5 mm."), "{said}");
    let points = |report: &Value| report["passes"][0]["points"].as_u64().unwrap();
    assert_eq!((points(&all), points(&low)), (60, 21));
    let process = format!("schema = 1\n[cutting]\nbelow_z_mm = -5.0\n{FORCE}");
    let (output, _) = compensate_on("orthoglide", ("part.nc", program), &process, &[]);
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).contains("is cut: what cuts is every move"), "{}", text(&output.stderr));
}

#[test]
fn one_process_file_serves_compensate_and_compare() {
    let folder = tempfile::tempdir().unwrap();
    let process = format!("schema = 1\n[placement]\norigin_mm = [20.0, 0.0, 150.0]\nyaw_deg = 30.0\n{FORCE}");
    let process = write(&folder, "process.toml", &process);
    let bare = write(&folder, "bare.toml", &format!("schema = 1\n{FORCE}"));
    let path = write(&folder, "path.csv", "x_mm,y_mm,z_mm\n0,0,0\n20,0,0\n");
    let compare = |process: &Path, more: &[&str]| {
        let names = [process, &path].map(|path| path.to_str().unwrap());
        let arguments = ["compare", "--machine", "orthoglide", "--process", names[0], "--path", names[1]];
        run(&[&arguments[..], more].concat())
    };
    let both = compare(&process, &["--at", "20,0,150,30"]);
    assert!(both.status.success(), "{}", text(&both.stderr));
    let said = text(&both.stdout);
    assert!(said.contains("as in the process file") && said.contains("Counts as cutting"), "{said}");
    let alone = compare(&process, &["--csv"]);
    assert!(alone.status.success(), "{}", text(&alone.stderr));
    assert_eq!(text(&alone.stdout).lines().count(), 2);
    let nowhere = compare(&bare, &[]);
    assert_eq!(nowhere.status.code(), Some(2));
    assert!(text(&nowhere.stderr).contains("gives no placement.origin_mm"), "{}", text(&nowhere.stderr));
}

#[test]
fn a_limit_exceeded_by_rounding_is_said_with_its_size() {
    let process = std::fs::read_to_string(folder().join("process.toml")).unwrap();
    let process = format!("{process}\n[limits]\nmax_correction_mm = 1.5\n[gcode]\ndecimals_mm = 2\n");
    let groove = std::fs::read_to_string(folder().join("groove.nc")).unwrap();
    let (output, out) = compensate_on("orthoglide", ("groove.nc", &groove), &process, &["--method", "bounded"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let said = unwrapped(&text(&output.stdout));
    assert!(said.contains("the correction of drive x is 1.5") && said.contains("beyond its limit of 1.5 mm"), "{said}");
    let exceeded = report(&out)["limits_exceeded_as_written"].clone();
    let excess = exceeded[0]["excess"].as_f64().unwrap();
    assert!(excess > 0.0 && excess < 0.02, "{exceeded}");
    assert_eq!((exceeded[0]["limit"].as_str(), exceeded[0]["drive"].as_str()), (Some("correction"), Some("x")));
    let (output, out) = compensate_on("orthoglide", ("groove.nc", &groove), &process, &[]);
    assert!(text(&output.stdout).contains("The limits of the process were not assessed: --method bounded keeps them."));
    assert!(report(&out)["limits_exceeded_as_written"].is_null());
}

#[test]
fn a_law_that_is_not_named_turns_with_the_path() {
    let groove = std::fs::read_to_string(folder().join("groove.nc")).unwrap();
    let errors = |force: &str| {
        let process = format!("schema = 1\n[placement]\norigin_mm = [0.0, 0.0, 100.0]\n{force}");
        let (output, out) = compensate_on("orthoglide", ("groove.nc", &groove), &process, &[]);
        assert!(output.status.success(), "{}", text(&output.stderr));
        report(&out)["passes"][0].clone()
    };
    assert_eq!(errors(FORCE), errors(&FORCE.replace("law = \"rotated\"\n", "")));
    assert_ne!(errors(FORCE), errors(&FORCE.replace("rotated", "paper_eq17")));
}

#[test]
fn a_largest_feed_is_not_asked_of_a_path_without_feeds() {
    let process = format!("schema = 1\n[cutting]\nmax_feed_mm_per_min = 500.0\n{FORCE}");
    let (output, _) = compensate_on("orthoglide", ("path.csv", "x_mm,y_mm,z_mm\n0,0,0\n20,0,0\n"), &process, &[]);
    assert_eq!(output.status.code(), Some(2));
    let said = text(&output.stderr);
    assert!(said.contains("cutting.max_feed_mm_per_min") && said.contains("path.csv has no feeds"), "{said}");
}

#[test]
fn a_method_that_solves_nothing_has_no_numbers_and_a_reason() {
    // Methods that hold the platform ask for its stiffness, which a machine with rigid legs does not have.
    let process = format!("schema = 1\n[placement]\norigin_mm = [0.0, 0.0, -1150.0]\n{FORCE}");
    let program = "G21 G90\nG0 X-5 Y0 Z0\nG1 X5 F300\nM30\n";
    let machine = machine_path("tricept");
    let (output, out) = compensate_on(&machine, ("part.nc", program), &process, &["--all-methods"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let passes = report(&out)["passes"].clone();
    let newton = passes.as_array().unwrap().iter().find(|pass| pass["commands"] == "newton").unwrap();
    assert_eq!((&newton["points_solved"], &newton["error_max_mm"]), (&0.into(), &Value::Null), "{newton}");
    let reason = newton["first_failure"].as_str().unwrap();
    let said = text(&output.stdout);
    assert!(
        !reason.is_empty() && said.contains(&format!("newton fails at 10 of 10 points; the first: {reason}.")),
        "{said}"
    );
}

#[test]
fn a_machine_that_snaps_through_is_said_to_at_every_point() {
    let process = "schema = 1\n[placement]\norigin_mm = [0.0, 0.0, -1150.0]\n[force.path_frame]\nradial_force_N = 4e7\n\
                   tangential_force_N = 0.0\naxial_force_N = 0.0\n";
    let program = "G21 G90\nG0 X-5 Y0 Z0\nG1 X5 F300\nM30\n";
    let (output, _) = compensate_on(&machine_path("tricept"), ("part.nc", program), process, &[]);
    assert_eq!(output.status.code(), Some(1));
    let said = text(&output.stdout);
    let reasons: Vec<&str> = said.lines().filter(|line| line.starts_with("  line 3, point")).collect();
    assert!(reasons.len() > 3 && reasons.iter().all(|reason| reason.contains("snaps through")), "{said}");
}

/// A program that calls a file beside it, in a folder with its process: with a force, or without.
fn calling(force: &str) -> (tempfile::TempDir, PathBuf, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let program =
        write(&folder, "main.nc", "%\nO1\nG21 G90\nG0 X0 Y0 Z0\nM98 P70 L2\nG0 X40\nM98 P70 (again)\nM30\n%\n");
    write(&folder, "O0070.nc", "O70\nG90 G1 X5 F300 (groove)\nG91 Y20\nG90 Y0\nM99\n");
    let force = format!(
        "schema = 1\n[force.path_frame]\nradial_force_N = {force}\ntangential_force_N = 0.0\naxial_force_N = 0.0\n"
    );
    let process = write(&folder, "process.toml", &force);
    (folder, program, process)
}

#[test]
fn calls_stay_where_their_corrections_are_the_same() {
    let (folder, program, process) = calling("0.0");
    let (output, out) = compensate(&program, &process, &[]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let said = unwrapped(&text(&output.stdout));
    assert!(
        said.contains(
            "What the program calls and computes stays: no line needs other corrections each time that it runs. The \
             program calls O0070.nc beside the file."
        ),
        "{said}"
    );
    for (name, source) in [("out.nc", "main.nc"), ("O0070.nc", "O0070.nc")] {
        let [written, read] =
            [out.path().join(name), folder.path().join(source)].map(|file| std::fs::read(file).unwrap());
        assert_eq!(text(&written), text(&read));
    }
    assert_eq!(report(&out)["written_out"], Value::Null);
    assert!(report(&out)["files"].to_string().contains("O0070.nc"));
    // Ours, and replaced by the next one; beside the program, it is there already.
    let target = out.path().join("out.nc");
    let in_place = folder.path().join("out.nc");
    for target in [&target, &in_place] {
        let again = ["compensate", program.to_str().unwrap(), "--machine", "orthoglide", "--process"];
        let again = run(&[&again[..], &[process.to_str().unwrap(), "--out", target.to_str().unwrap()]].concat());
        assert!(again.status.success(), "{}", text(&again.stderr));
        assert_eq!(std::fs::read(target).unwrap(), std::fs::read(&program).unwrap());
    }
}

#[test]
fn a_called_file_that_may_not_be_replaced_writes_the_program_out() {
    let (folder, program, process) = calling("0.0");
    let out = tempfile::tempdir().unwrap();
    write(&out, "O0070.nc", "O70\nM99\n");
    let target = out.path().join("out.nc");
    let arguments = ["compensate", program.to_str().unwrap(), "--machine", "orthoglide", "--process"];
    let arguments = [&arguments[..], &[process.to_str().unwrap(), "--out", target.to_str().unwrap()]].concat();
    let said = unwrapped(&text(&run(&arguments).stdout));
    let expected = "Written out: 17 lines for the 9 of the program; what it calls cannot be written beside it:";
    assert!(said.contains(expected) && said.contains("was not written by kinetostat"), "{said}");
    assert!(report(&out)["written_out"]["because"].as_str().unwrap().contains("O0070.nc"));
    assert!(std::fs::read_to_string(&target).unwrap().contains("(written out by kinetostat: 17 lines for 9)"));
    assert_eq!(std::fs::read_to_string(out.path().join("O0070.nc")).unwrap(), "O70\nM99\n");
    assert!(folder.path().exists());
}

#[test]
fn calls_with_other_corrections_are_written_out_and_that_is_said() {
    let (folder, program, process) = calling("215.0");
    let (output, out) = compensate(&program, &process, &[]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let said = unwrapped(&text(&output.stdout));
    assert!(
        said.contains("Written out: 17 lines for the 9 of the program; O0070.nc line 2 runs several times, each with other corrections."),
        "{said}"
    );
    assert!(!out.path().join("O0070.nc").exists() && folder.path().exists());
    assert!(said.contains("worst in O0070.nc line 4, ") || said.contains("worst in line "), "{said}");
    let points = std::fs::read_to_string(out.path().join("out.nc.points.csv")).unwrap();
    let places: Vec<[&str; 2]> =
        points.lines().map(|row| row.split(',').collect::<Vec<_>>()).map(|cells| [cells[1], cells[2]]).collect();
    assert_eq!(places[..3], [["line", "called_file"], ["4", ""], ["2", "O0070.nc"]]);
}

/// Files of a program, and of one that it calls.
fn files_of(program: &str) -> Vec<OutputFile> {
    let file = |name: &str| OutputFile::new(name, format!("{name} of {program}"));
    vec![file("part.nc.points.csv"), file("sub.nc"), file("part.nc"), file("part.nc.html")]
}

/// Puts `files` in their places, but not beyond so many `steps`; how many there are.
fn replaced(files: Vec<OutputFile>, out: &Path, steps: usize) -> usize {
    let prepared = ProgramFiles::prepare(out, Foreign::KeptUnlessForced).unwrap();
    let made = staging_beside(out).unwrap();
    let names: Vec<String> = files.iter().map(|file| file.name.clone()).collect();
    write_all(made.path(), files).unwrap();
    let changes = prepared.prepare_replacement(made.path(), &names, &json!({ "program": "kinetostat" })).unwrap();
    let count = changes.steps.len();
    changes.steps.into_iter().take(steps).for_each(|step| step.apply().unwrap());
    count
}

#[test]
fn what_is_cut_short_leaves_no_program_beside_files_of_another() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("part.nc");
    let count = replaced(files_of("one"), &out, usize::MAX);
    let text = |name: &str| std::fs::read_to_string(folder.path().join(name)).unwrap_or_default();
    let sets = |names: &[&str]| -> Vec<bool> { names.iter().map(|name| text(name).ends_with("two")).collect() };
    for steps in 0..=count {
        replaced(files_of("one"), &out, usize::MAX);
        replaced(files_of("two"), &out, steps);
        let of_two = sets(&["part.nc.points.csv", "sub.nc", "part.nc", "part.nc.html"]);
        let report: Value = serde_json::from_str(&text("part.nc.report.json")).unwrap();
        let is_whole = of_two.iter().all(|is| *is) || !of_two.iter().any(|is| *is) && !text("part.nc").is_empty();
        let is_said = text("part.nc.html").contains("was stopped");
        assert!(is_whole || is_said, "{steps}: {of_two:?}");
        assert!(text("part.nc").is_empty() || of_two[0] == of_two[2] && of_two[1] == of_two[2], "{steps}");
        assert_eq!(report["unfinished"] == true, (1..count).contains(&steps), "{steps}");
        // The next command knows all of them, and nothing else remains.
        replaced(files_of("one"), &out, usize::MAX);
        assert_eq!(sets(&["part.nc.points.csv", "sub.nc", "part.nc", "part.nc.html"]), [false; 4]);
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 5);
    }
}

/// What corrects for a force leads the tool off where that is absent; how far is said first, and refused where the process allows less.
#[test]
fn what_the_program_does_without_force_is_said_and_limited() {
    let process = std::fs::read_to_string(folder().join("process.toml")).unwrap();
    let program = std::fs::read_to_string(folder().join("groove.nc")).unwrap();
    let with = |limit: f64| format!("{process}\n[limits]\nunloaded_gouge_mm = {limit:?}\n");
    let (output, out) = compensate_on("orthoglide", ("groove.nc", &program), &with(10.0), &[]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let most = report(&out)["without_force"]["error_max_mm"].as_f64().unwrap();
    let said = unwrapped(&text(&output.stdout));
    let expected = format!(
        "Where the cutting force is absent (in air, in a spring pass, with a broken tool), the program as written leads the tool off its path by \
         up to {most:.3} mm, line "
    );
    assert!(said.contains(&expected), "{expected}{said}");
    let mut table = csv::Reader::from_path(out.path().join("out.nc.points.csv")).unwrap();
    let header = table.headers().unwrap().clone();
    let column = |name: &str| header.iter().position(|own| own == name).unwrap();
    let (without, cutting, by_force) =
        (column("error_without_force_mm"), column("cutting"), column("error_before_cutting_mm"));
    let number = |row: &csv::StringRecord, column: usize| row[column].parse::<f64>().unwrap();
    let mut largest = 0.0f64;
    for row in table.records().map(Result::unwrap).filter(|row| &row[cutting] == "1") {
        // Nearly what the force does alone, to the other side.
        let (off, moved) = (number(&row, without), number(&row, by_force));
        assert!((off - moved).abs() < 0.08 * moved + 0.006, "{off} and {moved}");
        largest = largest.max(off);
    }
    assert!((largest / most - 1.0).abs() < 1e-12, "{largest} and {most}");
    let (output, out) = compensate_on("orthoglide", ("groove.nc", &program), &with(0.01), &[]);
    let refused = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{refused}");
    assert!(refused.contains("limits.unloaded_gouge_mm allows 0.01 mm") && refused.contains("groove.nc"), "{refused}");
    let mut left: Vec<_> = std::fs::read_dir(out.path()).unwrap().map(|file| file.unwrap().file_name()).collect();
    left.sort();
    assert_eq!(left, ["groove.nc", "process.toml"]);
}
