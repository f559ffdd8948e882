//! Results of paths with uncertain inputs, compared draw by draw, against closed forms.

use std::path::{Path, PathBuf};

use crate::support::{
    command::told,
    uncertain::{LEVER, force, study_text},
};
use kinetostat::process::uncertainty::{Distribution, normal_cdf};

/// Runs a path of a prismatic joint under a force along it; `stiffness` N/mm varies by `spread`.
fn run(folder: &Path, name: &str, stiffness: f64, spread: f64, uncertainty: &str) -> PathBuf {
    let study = folder.join(format!("study_{name}"));
    std::fs::create_dir(&study).unwrap();
    let lever = LEVER.replace("stiffness_N_per_mm = 1e4", &format!("stiffness_N_per_mm = {stiffness:?}"));
    std::fs::write(study.join("lever.toml"), lever).unwrap();
    let uncertainty = match uncertainty {
        "exact" => String::new(),
        more => format!(
            "[uncertainty]\n{more}\n[[uncertainty.parameter]]\nname = \"guide.slide.stiffness\"\nrelative_std = {spread}\n\
             [uncertainty.process]\nforce_relative_std = 0.15"
        ),
    };
    let process = "process.tolerance_mm = 0.05\nprocess.placement = { origin_mm = [0.0, 0.0, 50.0] }\n".to_string()
        + &force(0.0, 1000.0, 0.0);
    let path = "[path]\nmethods = [\"direct\"]\nline = { start_mm = [-0.5, 0.0, 0.0], end_mm = [0.5, 0.0, 0.0] }";
    std::fs::write(study.join("study.toml"), study_text("lever.toml", &process, &uncertainty, path)).unwrap();
    let out = folder.join(name);
    done(&["run", text(&study), "--out", text(&out), "--no-figures"]);
    out
}

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

/// What a command says that does what is asked, in one line.
fn done(arguments: &[&str]) -> String {
    let (code, out, err) = told(arguments);
    assert_eq!(code, Some(0), "{arguments:?}: {out}{err}");
    out.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// What is said of two results, and the page.
fn compared(folder: &Path, results: [&Path; 2]) -> (String, String) {
    let page = folder.join("comparison.html");
    let said = done(&["compare", text(results[0]), text(results[1]), "--out", text(&page), "--force"]);
    (said, std::fs::read_to_string(page).unwrap().replace('\u{a0}', " "))
}

/// The number before "% probability" behind `words`.
fn probability_behind(words: &str, all: &str) -> f64 {
    let rest = all.split_once(words).unwrap_or_else(|| panic!("{words}: {all:.3000}")).1;
    let (number, _) = rest.split_once(" % probability").unwrap();
    number.rsplit(' ').next().unwrap().parse().unwrap_or_else(|_| panic!("{number}"))
}

/// Logarithms of force over stiffness are normal: what is said of the distances is known.
#[test]
fn the_probability_that_one_is_better_is_the_exact_one() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let std = |relative: f64| match Distribution::of_relative_std(relative) {
        Distribution::Logarithm { above, .. } => above,
        _ => unreachable!(),
    };
    let first = run(at, "first", 1e4, 0.3, "");
    let stiffer = run(at, "stiffer", 1.1e4, 0.3, "");
    let (said, page) = compared(at, [&first, &stiffer]);
    // The same draws: 10 % in each of them, whatever the spread.
    assert!(said.starts_with("◐ B better with more than 99.9 % probability "), "{said}");
    for words in [
        "B (study_stiffer) is better than A (study_first) with",
        "A and B have the same draws",
        "not exceeded with 95 % probability in A, compensated",
        "not exceeded with 95 % probability in A, without compensation",
        "With nominal numbers: ",
    ] {
        assert!(page.contains(words), "{words}");
    }

    // Known better, its distance without compensation is smaller where it is above the nominal one: the same number decides both.
    let known = run(at, "known", 1e4, 0.1, "");
    let (said, page) = compared(at, [&first, &known]);
    let safer = "◐ B is the safer one [of what is computed: some causes are unknown] B (study_known) stays within 0.0";
    assert!(said.starts_with(safer), "{said}");
    assert!(
        said.contains(" In a single draw either may be better: the largest distance from the path, compensated"),
        "{said}"
    );
    let alike = 1.005f64.ln() / (std(0.3) - std(0.1));
    let found = probability_behind(" better with", page.split_once("in A, without compensation").unwrap().1);
    let expected = 100.0 * normal_cdf(-alike);
    assert!((found - expected).abs() < 1.0, "{found}, not {expected}");

    // Of other seeds, machine and force of each are independent.
    let other = run(at, "other", 1.1e4, 0.3, "seed = 7");
    let (said, page) = compared(at, [&first, &other]);
    let both = (2.0 * (std(0.3).powi(2) + std(0.15).powi(2))).sqrt();
    let expected = 100.0 * normal_cdf((1.1f64 / 1.005).ln() / both);
    let found = probability_behind("B better with", page.split_once("in A, without compensation").unwrap().1);
    assert!((found - expected).abs() < 1.0, "{found}, not {expected}");
    let safer = "◐ B is the safer one [of what is computed: some causes are unknown] B (study_other) stays within 0.0";
    assert!(said.starts_with(safer), "{said}");
    assert!(page.contains("do not have the same draws, as their seeds differ (0 and 7)"));

    // So they are where other parameters are uncertain.
    let fewer = run(at, "fewer", 1.1e4, 0.3, "[[uncertainty.parameter]]\nname = \"guide.slide.offset\"\nstd = 0.001");
    assert!(compared(at, [&first, &fewer]).1.contains("as their uncertain parameters differ"));

    // A result is as good as itself.
    let (said, _) = compared(at, [&first, &first]);
    assert!(
        said.starts_with("– Cannot be told apart [of what is computed: some causes are unknown] A (first) and B (first) cannot be told apart.")
            && said.contains("in B with less than 0.1 % (95 % quantile"),
        "{said}"
    );

    let exact = run(at, "exact", 1e4, 0.3, "exact");
    let (said, page) = compared(at, [&first, &exact]);
    assert!(said.contains("B takes its inputs as exact: only nominal numbers are compared."), "{said}");
    assert!(page.contains("B takes its inputs as exact"));
    assert!(compared(at, [&exact, &exact]).0.contains("are the same but for rounding."));
}

/// The table of draws has what the summary says, the same on any number of threads, and is read with its lines.
#[test]
fn the_table_of_draws_is_that_of_the_largest_distances() {
    let folder = tempfile::tempdir().unwrap();
    let out = run(folder.path(), "out", 1e4, 0.3, "");
    let table = std::fs::read_to_string(out.join("draws.csv")).unwrap();
    let again = folder.path().join("again");
    let study = folder.path().join("study_out");
    done(&["run", text(&study), "--out", text(&again), "--no-figures", "--threads", "1"]);
    assert!(std::fs::read_to_string(again.join("draws.csv")).unwrap() == table);
    let rows: Vec<Vec<f64>> =
        table.lines().skip(1).map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect()).collect();
    assert!(table.starts_with("draw,largest_distance_mm,compensated_largest_distance_mm\n0,"), "{table:.200}");
    assert_eq!(rows.len(), 4096);
    let summary: serde_json::Value = serde_json::from_slice(&std::fs::read(out.join("summary.json")).unwrap()).unwrap();
    let largest = &summary["uncertainty"]["largest"];
    let worse = rows.iter().filter(|row| row[2] > 1.005 * row[1]).count() as f64 / 4096.0;
    assert!((largest["worse"].as_f64().unwrap() - worse).abs() < 1e-9, "{largest}");
    assert_eq!(summary["uncertainty"]["seed"], 0);
    for (column, key) in [(1, "plain"), (2, "compensated")] {
        let mut sizes: Vec<f64> = rows.iter().map(|row| row[column]).collect();
        sizes.sort_by(f64::total_cmp);
        let p95 = largest[key]["spread"]["p95_mm"].as_f64().unwrap();
        assert!((sizes[3891] / p95 - 1.0).abs() < 0.01, "{key}: {} {p95}", sizes[3891]);
    }
    let broken = table.replacen("\n1,", "\n1,-", 1);
    std::fs::write(out.join("draws.csv"), broken).unwrap();
    let (code, _, err) = told(&["compare", text(&out), text(&again), "--out", text(&folder.path().join("page.html"))]);
    assert!(
        code == Some(2) && err.contains("draws.csv:3: largest_distance_mm: expected a number or nothing"),
        "{code:?} {err}"
    );
}

/// What is better of what cannot be run comes second.
#[test]
fn a_path_that_cannot_be_run_is_named_before_the_comparison() {
    let folder = tempfile::tempdir().unwrap();
    let out = run(folder.path(), "out", 1e4, 0.3, "");
    let study = folder.path().join("study_out/study.toml");
    let moved = std::fs::read_to_string(&study).unwrap().replace("end_mm = [0.5,", "end_mm = [2.5,");
    std::fs::write(&study, moved).unwrap();
    let outside = folder.path().join("outside");
    done(&["run", text(&folder.path().join("study_out")), "--out", text(&outside), "--no-figures"]);
    let summary: serde_json::Value =
        serde_json::from_slice(&std::fs::read(outside.join("summary.json")).unwrap()).unwrap();
    let (all, beyond) = (&summary["points"], &summary["points_outside_workspace"]);
    let expected =
        format!("As placed, B cannot be run: {beyond} of {all} points are outside the workspace box of lever.");
    let (said, page) = compared(folder.path(), [&out, &outside]);
    assert!(
        beyond.as_u64().unwrap() > 0
            && said.starts_with("✗ One of the paths cannot be run as placed")
            && said.contains(&expected)
            && page.contains(&expected),
        "{said}"
    );
    assert!(!compared(folder.path(), [&out, &out]).0.contains("cannot be run"));
}

/// Maps keep no draws, and that is said.
#[test]
fn of_maps_no_probability_is_known() {
    let folder = tempfile::tempdir().unwrap();
    let study = folder.path().join("study");
    std::fs::create_dir(&study).unwrap();
    let map = "[workspace_map]\ngrid = [1, 1, 1]\nslices_z_mm = [0.0]\nphi_step_deg = 120.0";
    let uncertainty = "[uncertainty.process]\nforce_relative_std = 0.15";
    let toml = study_text("orthoglide", &force(215.0, -10.0, -25.0), uncertainty, map);
    std::fs::write(study.join("study.toml"), toml).unwrap();
    let out = folder.path().join("out");
    done(&["run", text(&study), "--out", text(&out), "--no-figures"]);
    let (said, page) = compared(folder.path(), [&out, &out]);
    assert!(
        said.contains("Draws are not kept of these results: quantiles and probabilities are compared as they"),
        "{said}"
    );
    assert!(page.contains("Draws are not kept of these results"));
}
