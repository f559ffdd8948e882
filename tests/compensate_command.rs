//! `kinetostat compensate` end to end: the written program, read again and simulated, follows the wanted path.

use std::{
    path::{Path, PathBuf},
    process::{Command, Output},
};

use serde_json::Value;

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
fn written_program_keeps_the_tool_on_its_path_to_the_last_decimal() {
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
    // Three decimals: half a micrometre along each axis, times what the machine makes of it.
    assert!(error_max(written) < 1.5e-3, "{written}");
    let stdout = text(&output.stdout);
    assert!(stdout.contains("direct, as written"), "{stdout}");
    assert!(text(&output.stderr).is_empty(), "no progress in a pipe");
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
    let programs = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/gcode");
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
    assert!(text(&output.stderr).contains("has 1 positions, but the path has 6 points"), "{}", text(&output.stderr));
}

#[test]
fn a_cut_beyond_reach_writes_nothing_and_says_where() {
    let inputs = tempfile::tempdir().unwrap();
    let program = write(&inputs, "far.nc", "G21 G90\nG0 X0 Y0 Z0\nG1 X400 F500\n");
    let process = write(&inputs, "p.toml", "schema = 1\n[placement]\norigin_mm = [0.0, 0.0, 100.0]\n");
    let (output, out) = compensate(&program, &process, &[]);
    assert_eq!(output.status.code(), Some(1));
    let stdout = text(&output.stdout);
    assert!(stdout.contains("nothing was written") && stdout.contains("line 3, point"), "{stdout}");
    assert_eq!(std::fs::read_dir(out.path()).unwrap().count(), 0);
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
    // Rounded to three decimals when it was written.
    assert!((1.49..1.5015).contains(&largest), "{largest}");

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
