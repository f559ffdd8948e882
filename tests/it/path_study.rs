//! Path studies: the groove of study 02, reduced and long, and a straight line.

use std::{
    fs,
    path::{Path, PathBuf},
    process::Command,
};

use kinetostat::{
    answer::ReportText,
    files::exchange::MAX_ROWS,
    questions::{
        Overrides, Study, StudyKind,
        path::{
            self, PathResults, Shown,
            report::{Curve, MAX_POINTS, Summary, drawn_indices, text, view_axes},
            run,
        },
    },
    simulation::Source,
    work::Work,
};
use nalgebra::Vector3;
use parquet::file::reader::{FileReader, SerializedFileReader};

fn studies() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/02_groove_50mm")
}

fn results(study: Study) -> PathResults {
    let StudyKind::Path(path, _) = &study.kind else { panic!("a path study") };
    run(path, &Work::default()).unwrap()
}

fn largest_displacement(results: &PathResults, source: Source) -> f64 {
    let sizes = (0..results.study.stations.len()).map(|k| results.whole.displacement(source, k).unwrap().norm());
    sizes.fold(0.0, f64::max)
}

#[test]
fn groove_of_study_02_has_the_numbers_its_readme_quotes() {
    let overrides = Overrides { points: Some(73), ..Overrides::default() };
    let results = results(Study::open(&studies(), &overrides).unwrap());
    for (source, expected) in [(Source::Cutting, 0.95), (Source::Geometry, 1.05), (Source::All, 1.76)] {
        let found = largest_displacement(&results, source);
        assert!((found - expected).abs() < 0.01, "{source:?}: {found}");
    }
    let both = &results.whole.sources[Source::All];
    let correction = both.iter().flat_map(|at| at.answer.delta_rho()).fold(0.0f64, |most, d| most.max(d.abs()));
    assert!((correction - 1.71).abs() < 0.01, "{correction}");
    assert!(
        results.study.stations.iter().all(|station| station.phi_deg.is_some_and(|phi| (0.0..360.0).contains(&phi)))
    );
    for method in &results.methods {
        let compensates = !["none", "linear", "mirror", "mirror_3"].contains(&method.method.label().as_str());
        assert_eq!(method.summary.failed, 0, "{:?}", method.method);
        assert_eq!(method.summary.max_mm.unwrap() < 1.5e-9, compensates, "{:?}: {:?}", method.method, method.summary);
    }
}

#[test]
fn a_line_is_cut_with_the_heading_less_a_quarter_turn() {
    let toml = r#"
schema = 3
question = "q"
machine = "orthoglide"

process = "process.toml"
[path]
line = { start_mm = [0.0, 0.0, 0.0], end_mm = [0.0, 20.0, 0.0] }
methods = ["mirror_2", "direct"]
"#;
    let study = Study::from_toml(toml, "study.toml", studies(), &Overrides::default()).unwrap();
    let results = results(study);
    assert_eq!(results.study.stations.len(), 21, "a point every millimetre");
    // Heading +y: φ = 0, the radial force points to +x.
    assert!(results.study.stations.iter().all(|station| station.phi_deg == Some(0.0)));
    assert!(results.study.tasks.iter().all(|task| (task.load.force.x - 215.0).abs() < 1e-9));
    let labels: Vec<String> = results.methods.iter().map(|method| method.method.label()).collect();
    assert_eq!(labels, ["mirror_2", "direct"]);
    assert!(results.methods[1].summary.max_mm.unwrap() < 1e-9);
}

/// What is said of all points.
fn said(found: &PathResults) -> ReportText {
    let mut summary = Summary::new(&found.study, Shown { is_circle: false });
    summary.add(&found.whole);
    text(&summary)
}

/// A path study of the polyline `rows` on `machine`, cut as in study 02.
fn along(machine: &str, rows: &[&str]) -> PathResults {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("path.csv"), format!("x_mm,y_mm,z_mm\n{}\n", rows.join("\n"))).unwrap();
    let force = "radial_force_N = 215.0\ntangential_force_N = -10.0\naxial_force_N = -25.0\nlaw = \"rotated\"";
    let process = format!("schema = 1\n[force.path_frame]\n{force}\n");
    fs::write(folder.path().join("process.toml"), process).unwrap();
    let toml = format!(
        "schema = 3\nquestion = \"q\"\nmachine = \"{machine}\"\nprocess = \"process.toml\"\n[path]\n\
         file = \"path.csv\"\nmethods = [\"none\", \"mirror\"]\n"
    );
    results(Study::from_toml(&toml, "study.toml", folder.path(), &Overrides::default()).unwrap())
}

#[test]
fn a_program_that_calls_others_is_written_out_if_the_process_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    let study = || {
        let toml = "schema = 3\nquestion = \"q\"\nmachine = \"orthoglide\"\nprocess = \"process.toml\"\n[path]\nfile = \"main.nc\"\n\
                    methods = [\"none\"]\n";
        Study::from_toml(toml, "study.toml", folder.path(), &Overrides::default())
    };
    let process = |expand: &str| {
        let force = "radial_force_N = 215.0\ntangential_force_N = -10.0\naxial_force_N = -25.0";
        write("process.toml", &format!("schema = 1\n[force.path_frame]\n{force}\n[gcode]\n{expand}\n"));
    };
    write("main.nc", "G21 G90\nG0 X0 Y0 Z0\nG1 X5 F300\nM98 P70\nG1 X0\nM30\n");
    write("O0070.nc", "O70\nG1 Y20\nX40\nM99\n");
    process("expand = false");
    let refused = study().map(|_| ()).unwrap_err().to_string();
    assert!(refused.ends_with("main.nc:4:1: `M98`: subprograms are not read; expected one program, or expand in [gcode] of the process file (--expand), which writes it out"), "{refused}");
    process("expand = true");
    let asked = results(study().unwrap());
    process("");
    let opened = study().unwrap();
    let before = opened.inputs.sha256();
    let StudyKind::Path(path, _) = &opened.kind else { panic!("a path study") };
    let lines: std::collections::BTreeSet<_> = path.stations.iter().map(|station| station.line.unwrap()).collect();
    // Lines 2 and 3 of the subprogram, 2, 3 and 5 of the program.
    assert_eq!(lines.into_iter().collect::<Vec<_>>(), [2, 3, 5]);
    let found = results(study().unwrap());
    assert_eq!(largest_displacement(&found, Source::All), largest_displacement(&asked, Source::All));
    let said = said(&found).place;
    assert!(said.contains("mm, O0070.nc line 2, "), "{said}");
    // What is called decides the results.
    write("O0070.nc", "O70\nG1 Y20\nX41\nM99\n");
    assert_ne!(study().unwrap().inputs.sha256(), before);
}

#[test]
fn heights_that_a_planar_machine_does_not_control_are_taken_where_it_stands_and_that_is_said() {
    let planar = format!("{}/tests/machines/rrr3.toml", env!("CARGO_MANIFEST_DIR"));
    let (deep, level) = (along(&planar, &["10,5,-1.5", "-20,5,-1.5"]), along(&planar, &["10,5,60", "-20,5,60"]));
    for (deep, level) in deep.methods.iter().zip(&level.methods) {
        assert_eq!((deep.summary.failed, deep.summary.solved), (0, 31));
        assert_eq!(deep.summary, level.summary);
    }
    let said = said(&deep).cautions;
    let expected = "Not controlled by this machine: z of the base, taken where the machine stands; words of a program for \
                    z stay.\n";
    assert!(said.contains(expected), "{said}");
    assert!(deep.study.facts.iter().any(|(label, _)| *label == "not controlled by this machine"));
}

#[test]
fn a_closed_polyline_leaves_the_same_errors_from_every_corner() {
    let corners = ["60,40,10", "90,40,0", "90,60,0", "60,60,0"];
    let from = |first: usize| {
        let rows: Vec<&str> = (0..=4).map(|k| corners[(first + k) % 4]).collect();
        along("orthoglide", &rows)
    };
    let first = from(0);
    for other in (1..4).map(from) {
        for (a, b) in other.methods.iter().zip(&first.methods) {
            let (a, b) = (&a.summary, &b.summary);
            assert_eq!((a.points, a.solved), (b.points, b.solved));
            for (a, b) in [(a.rms_mm.unwrap(), b.rms_mm.unwrap()), (a.max_mm.unwrap(), b.max_mm.unwrap())] {
                assert!((a - b).abs() < 1e-8 * b, "{a} {b}");
            }
        }
    }
}

/// The numbers of a column, by file and header.
fn numbers(file: &Path, column: usize, keep: impl Fn(&csv::StringRecord) -> bool) -> Vec<f64> {
    let mut reader = csv::Reader::from_path(file).unwrap();
    let rows = reader.records().map(|row| row.unwrap()).filter(keep);
    rows.map(|row| row[column].parse().unwrap()).collect()
}

/// More points than are computed together and than a curve draws.
#[test]
fn a_long_path_is_written_whole_and_drawn_thinned_with_its_peaks() {
    let folder = tempfile::tempdir().unwrap();
    let study = folder.path().join("long");
    fs::create_dir(&study).unwrap();
    fs::copy(studies().join("process.toml"), study.join("process.toml")).unwrap();
    let toml = fs::read_to_string(studies().join("study.toml")).unwrap();
    fs::write(study.join("study.toml"), toml.replace("[path]", "[path]\nmethods = [\"none\"]")).unwrap();
    let points = 4200;
    let out = folder.path().join("out");
    let mut run = Command::new(env!("CARGO_BIN_EXE_kinetostat"));
    run.arg("run").arg(&study).args(["--points", &points.to_string(), "--quiet", "--out"]).arg(&out);
    assert!(run.status().unwrap().success());

    let table = out.join("points.csv");
    let of = |source: &'static str| move |row: &csv::StringRecord| row.iter().any(|cell| cell == source);
    let indices = numbers(&table, 0, of("all"));
    assert_eq!(indices, (0..points).map(f64::from).collect::<Vec<_>>());
    let header = fs::read_to_string(&table).unwrap().lines().next().unwrap().to_string();
    let column = header.split(',').position(|name| name == "displacement_mm").unwrap();
    let largest = |values: &[f64]| values.iter().copied().fold(0.0, f64::max);
    let smallest = |values: &[f64]| values.iter().copied().fold(f64::MAX, f64::min);
    for (source, curve) in [("all", "all at once"), ("cutting", "cutting force")] {
        let all = numbers(&table, column, of(source));
        let drawn = numbers(&out.join("displacement_data.csv"), 3, of(curve));
        // The curve ends at the angle at which it begins.
        assert_eq!(drawn.len(), 2 * all.len() / 3 + 1, "{source}");
        assert_eq!((smallest(&drawn), largest(&drawn)), (smallest(&all), largest(&all)), "{source}");
    }
    let text = |name: &str| fs::read_to_string(out.join(name)).unwrap();
    for (figure, said) in [("displacement.svg", "4200 points, the smallest"), ("paths.svg", " of 4200 points drawn")] {
        assert!(text(figure).contains(said), "{figure}: {said}");
    }
    let summary: serde_json::Value = serde_json::from_str(&text("summary.json")).unwrap();
    let found = summary["sources"]["all"]["displacement_max_mm"]["value"].as_f64().unwrap();
    assert_eq!(found, largest(&numbers(&table, column, of("all"))));
    assert_eq!(summary["methods"][0]["failed"], 0);
}

/// The lines of a table, the header first.
fn lines(file: &Path) -> Vec<String> {
    fs::read_to_string(file).unwrap().lines().map(String::from).collect()
}

#[test]
fn a_table_of_very_many_points_has_the_worst_the_extremes_and_points_at_equal_steps_or_all() {
    let folder = tempfile::tempdir().unwrap();
    let study = folder.path().join("very_long");
    fs::create_dir(&study).unwrap();
    fs::copy(studies().join("process.toml"), study.join("process.toml")).unwrap();
    let toml = fs::read_to_string(studies().join("study.toml")).unwrap();
    let toml = toml.replace("[path]", "[path]\nmethods = [\"none\"]").replace("points = 361", "points = 17000");
    fs::write(study.join("study.toml"), toml).unwrap();
    let run = |name: &str, more: &[&str]| {
        let out = folder.path().join(name);
        let mut run = Command::new(env!("CARGO_BIN_EXE_kinetostat"));
        run.arg("run").arg(&study).args(["--no-figures", "--out"]).arg(&out).args(more);
        let output = run.output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        (out, String::from_utf8(output.stdout).unwrap())
    };
    let (kept, said) = run("kept", &["--threads", "1"]);
    let (whole, said_of_all) = run("whole", &["--points", "all"]);
    let [some, all] = [&kept, &whole].map(|out| lines(&out.join("points.csv")));
    assert_eq!(all.len(), 3 * 17_000 + 1);
    let rows = some.len() - 1;
    assert!(rows > MAX_ROWS / 8 && rows <= MAX_ROWS, "{rows}");
    // Each is a row of the whole table, in its order, and so are all sources of its point.
    let mut rest = all.iter();
    assert!(some.iter().all(|row| rest.any(|other| other == row)));
    let point = |row: &String| row.split(',').next().unwrap().parse::<usize>().unwrap();
    assert!(some[1..].chunks(3).all(|rows| rows.iter().all(|row| point(row) == point(&rows[0]))));
    let points: Vec<usize> = some[1..].iter().step_by(3).map(point).collect();
    let step = (1..).find(|step| (0..17_000).step_by(*step).all(|k| points.binary_search(&k).is_ok())).unwrap();
    assert!(step < 17_000 / 1000, "{step}");
    // The largest of every number of every source, and the worst of each step.
    let header: Vec<&str> = all[0].split(',').collect();
    let of = |rows: &[String], source: &str, column: usize| -> Vec<(usize, f64)> {
        let rows = rows[1..].iter().filter(|row| row.split(',').any(|cell| cell == source));
        rows.filter_map(|row| Some((point(row), row.split(',').nth(column)?.parse().ok()?))).collect()
    };
    let largest = |values: &[(usize, f64)]| values.iter().fold(0.0, |most, (_, value)| f64::max(most, value.abs()));
    for source in ["all", "cutting", "geometry"] {
        for (column, name) in header.iter().enumerate() {
            let [some, all] = [&some, &all].map(|rows| largest(&of(rows, source, column)));
            assert_eq!(some, all, "{name} of {source}");
        }
    }
    let displacement = header.iter().position(|name| *name == "displacement_mm").unwrap();
    let worst_of_steps = |rows: &[String]| {
        let mut worst = vec![0.0_f64; 17_000_usize.div_ceil(step)];
        ["all", "cutting", "geometry"].iter().flat_map(|source| of(rows, source, displacement)).for_each(
            |(k, value)| {
                worst[k / step] = worst[k / step].max(value);
            },
        );
        worst
    };
    assert_eq!(worst_of_steps(&some), worst_of_steps(&all));
    // Results are those of all points, and what the table leaves out is said in the terminal, on the page and beside the table.
    let read = |out: &Path, name: &str| fs::read_to_string(out.join(name)).unwrap();
    assert_eq!(read(&kept, "summary.json"), read(&whole, "summary.json"));
    let note = format!("points.csv has {rows} of 51000 rows: every ");
    for text in [said, read(&kept, "report.json"), read(&kept, "csv-metadata.json"), read(&kept, "report.html")] {
        assert!(text.contains(&note), "{text}");
    }
    for text in [said_of_all, read(&whole, "report.json"), read(&whole, "csv-metadata.json")] {
        assert!(!text.contains("of 51000 rows"), "{text}");
    }
    let (again, _) = run("again", &["--threads", "2", "--format", "csv,parquet"]);
    assert_eq!(lines(&again.join("points.csv")), some);
    let parquet = SerializedFileReader::new(fs::File::open(again.join("points.parquet")).unwrap()).unwrap();
    assert_eq!(parquet.metadata().file_metadata().num_rows(), 51_000);
}

#[test]
fn a_short_curve_keeps_every_point_and_a_long_one_its_peaks() {
    let mut short = Curve::new(3);
    (0..3).for_each(|k| short.add(k, k as f64, -(k as f64)));
    assert_eq!(short.points(), [(0.0, 0.0), (1.0, -1.0), (2.0, -2.0)]);

    let count = 100 * MAX_POINTS;
    let mut long = Curve::new(count);
    let value = |k: usize| {
        if k == 123_457 {
            7.0
        } else if k == 123_460 {
            -7.0
        } else {
            (k % 5) as f64
        }
    };
    (0..count).filter(|k| k % 3 > 0).for_each(|k| long.add(k, k as f64, value(k)));
    let points = long.points();
    assert!(points.len() <= MAX_POINTS && points.windows(2).all(|pair| pair[0].0 < pair[1].0), "{}", points.len());
    assert!(points.contains(&(123_457.0, 7.0)) && points.contains(&(123_460.0, -7.0)));
}

#[test]
fn a_long_path_keeps_its_corners_and_its_ends() {
    // Back and forth, in lines of 1000 points.
    let position = |k: usize| {
        let (line, along) = (k / 1000, (k % 1000) as f64);
        Vector3::new(if line.is_multiple_of(2) { along } else { 999.0 - along }, 2.0 * line as f64, 0.0)
    };
    for lines in [300, 900] {
        let positions: Vec<Vector3<f64>> = (0..1000 * lines).map(position).collect();
        let drawn = drawn_indices(&positions);
        assert!(drawn.len() <= MAX_POINTS && drawn.windows(2).all(|pair| pair[0] < pair[1]));
        for corner in (0..lines).flat_map(|line| [1000 * line, 1000 * line + 999]) {
            assert!(drawn.binary_search(&corner).is_ok(), "corner {corner} of {lines}");
        }
        assert!(drawn.windows(2).all(|pair| pair[1] - pair[0] <= lines / 2 + 1));
        assert_eq!(path::report::drawn_indices(&positions[..MAX_POINTS]).len(), MAX_POINTS);
    }
}

#[test]
fn a_path_is_seen_along_the_axis_in_which_it_spreads_least() {
    let path = |x: f64, y: f64, z: f64| [Vector3::zeros(), Vector3::new(x, y, z)];
    assert_eq!(view_axes(&path(10.0, 10.0, 0.0)), [0, 1, 2]);
    assert_eq!(view_axes(&path(10.0, 0.0, 10.0)), [0, 2, 1]);
    assert_eq!(view_axes(&path(0.0, 10.0, 10.0)), [1, 2, 0]);
    assert_eq!(view_axes(&path(10.0, 0.0, 0.0)), [0, 1, 2]);
}
