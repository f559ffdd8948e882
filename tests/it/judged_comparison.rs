//! Comparisons judge by what each result is judged by: shares by volume, 95 % quantiles, and the worst over the same points.

use std::path::{Path, PathBuf};

use crate::support::command::told;

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

fn done(arguments: &[&str]) -> String {
    let (code, out, err) = told(arguments);
    assert_eq!(code, Some(0), "{arguments:?}: {out}{err}");
    out.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Runs a map of the Orthoglide under a radial force, N.
fn map(folder: &Path, name: &str, force: f64, more: &str) -> PathBuf {
    let study = folder.join(format!("study_{name}"));
    std::fs::create_dir(&study).unwrap();
    let text_of = format!(
        "schema = 3\nquestion = \"?\"\nmachine = \"orthoglide\"\n[process]\ntolerance_mm = 0.5\n[process.force.path_frame]\nradial_force_N = {force:?}\n\
         tangential_force_N = 0.0\naxial_force_N = 0.0\nlaw = \"rotated\"\n{more}\n[workspace_map]\ngrid = [5, 4, 3]\nslices_z_mm = [0.0]\nphi_step_deg = 90.0\n"
    );
    std::fs::write(study.join("study.toml"), text_of).unwrap();
    let out = folder.join(name);
    done(&["run", text(&study), "--out", text(&out), "--no-figures"]);
    out
}

/// Cells of the rows of all sources: the position of P and the numbers of `column`.
fn rows(folder: &Path, column: &str) -> Vec<([f64; 3], f64)> {
    let mut reader = csv::Reader::from_path(folder.join("map.csv")).unwrap();
    let headers = reader.headers().unwrap().clone();
    let at = |name: &str| headers.iter().position(|own| own == name).unwrap_or_else(|| panic!("{name}: {headers:?}"));
    let [source, x, y, z, value] = [at("source"), at("x_mm"), at("y_mm"), at("z_mm"), at(column)];
    let rows = reader.records().map(Result::unwrap).filter(|row| &row[source] == "all");
    let number = |row: &csv::StringRecord, k: usize| row[k].parse::<f64>().unwrap();
    rows.map(|row| ([x, y, z].map(|k| number(&row, k)), number(&row, value))).collect()
}

/// Share of the box within `tolerance` by hand: a point stands for half the way to its neighbours along each axis.
fn share(rows: &[([f64; 3], f64)], tolerance: f64) -> f64 {
    let axis = |i: usize| {
        let mut values: Vec<f64> = rows.iter().map(|row| row.0[i]).collect();
        values.sort_by(f64::total_cmp);
        values.dedup();
        values
    };
    let axes = [axis(0), axis(1), axis(2)];
    let volume = |place: &[f64; 3]| -> f64 {
        let length = |i: usize| {
            let (axis, at) = (&axes[i], place[i]);
            let before = axis.iter().rev().find(|own| **own < at).map_or(0.0, |own| 0.5 * (at - own));
            before + axis.iter().find(|own| **own > at).map_or(0.0, |own| 0.5 * (own - at))
        };
        length(0) * length(1) * length(2)
    };
    let (all, within) = rows.iter().fold((0.0, 0.0), |(all, within), (place, value)| {
        let own = volume(place);
        (all + own, within + if *value <= tolerance { own } else { 0.0 })
    });
    within / all
}

fn percent(share: f64) -> String {
    format!("{:.0} %", 100.0 * share)
}

#[test]
fn a_share_that_differs_is_no_take_either() {
    let folder = tempfile::tempdir().unwrap();
    let [a, b] = [("weaker", 215.0), ("stronger", 185.0)].map(|(name, force)| map(folder.path(), name, force, ""));
    let [in_a, in_b] = [&a, &b].map(|out| rows(out, "deflection_mm"));
    // A tolerance at which some of the box is within, more of it in the second, and no place differs by as much.
    let mut sizes: Vec<f64> = in_a.iter().map(|row| row.1).collect();
    sizes.sort_by(f64::total_cmp);
    let tolerance = (1e3 * sizes[sizes.len() / 2]).round() / 1e3;
    let [share_a, share_b] = [&in_a, &in_b].map(|rows| share(rows, tolerance));
    assert!(share_b > share_a + 0.05 && share_b < 1.0, "{share_a} {share_b}");
    let unweighted = in_b.iter().filter(|row| row.1 <= tolerance).count() as f64 / in_b.len() as f64;
    assert!(percent(unweighted) != percent(share_b), "cells tell nothing here");
    let page = folder.path().join("comparison.html");
    let said = done(&["compare", text(&a), text(&b), "--out", text(&page), "--tolerance", &tolerance.to_string()]);
    let said = said.replace('\u{a0}', " ");
    let verdict = format!("B within {tolerance} mm in {}, A in {}", percent(share_b), percent(share_a));
    assert!(said.contains(&verdict) && !said.contains("take either"), "{verdict}: {said}");
}

#[test]
fn what_differs_in_nothing_makes_no_difference() {
    let folder = tempfile::tempdir().unwrap();
    let [a, b] = [("one", 200.0), ("other", 200.1)].map(|(name, force)| map(folder.path(), name, force, ""));
    let page = folder.path().join("comparison.html");
    let said = done(&["compare", text(&a), text(&b), "--out", text(&page), "--tolerance", "5"]);
    assert!(said.contains("No difference that matters"), "{said}");
}

#[test]
fn maps_with_uncertain_inputs_are_compared_by_their_quantiles() {
    let folder = tempfile::tempdir().unwrap();
    let uncertain =
        |std: f64| format!("[uncertainty]\nmachine = \"exact\"\n[uncertainty.process]\nforce_relative_std = {std:?}\n");
    let a = map(folder.path(), "sure", 200.0, &uncertain(0.01));
    let b = map(folder.path(), "unsure", 195.0, &uncertain(0.3));
    let [nominal_a, nominal_b] = [&a, &b].map(|out| rows(out, "deflection_mm"));
    let [p95_a, p95_b] = [&a, &b].map(|out| rows(out, "deflection_p95_mm"));
    let largest = |rows: &[([f64; 3], f64)]| rows.iter().map(|row| row.1).fold(0.0, f64::max);
    assert!(largest(&nominal_a) > largest(&nominal_b) && largest(&p95_a) < largest(&p95_b));
    let mut sizes: Vec<f64> = p95_b.iter().map(|row| row.1).collect();
    sizes.sort_by(f64::total_cmp);
    let tolerance = (1e3 * sizes[sizes.len() / 2]).round() / 1e3;
    let page = folder.path().join("comparison.html");
    let said = done(&["compare", text(&a), text(&b), "--out", text(&page), "--tolerance", &tolerance.to_string()]);
    let verdict = format!(
        "A within {tolerance} mm in {}, B in {}",
        percent(share(&p95_a, tolerance)),
        percent(share(&p95_b, tolerance))
    );
    assert!(said.replace('\u{a0}', " ").contains(&verdict), "{verdict}: {said}");
}

#[test]
fn a_map_names_the_place_of_the_tool_tip() {
    let folder = tempfile::tempdir().unwrap();
    let out = map(folder.path(), "map", 215.0, "");
    let rows = rows(&out, "deflection_mm");
    let least = rows.iter().reduce(|a, b| if b.1 < a.1 { b } else { a }).unwrap();
    // The tool of the Orthoglide is 100 mm long, along z of a platform that does not rotate.
    let [x, y, z] = least.0;
    let report = std::fs::read_to_string(out.join("report.json")).unwrap();
    let said = report.split_once("place the part near the tool tip at (").unwrap().1.split_once(')').unwrap().0;
    let said: Vec<f64> = said.replace('\u{2212}', "-").split(", ").map(|own| own.parse().unwrap()).collect();
    for (said, own) in said.iter().zip([x, y, z + 100.0]) {
        assert!((said - own).abs() <= 0.05 + 1e-9, "{said} and {own}");
    }
    let summary: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(out.join("summary.json")).unwrap()).unwrap();
    let ends = summary["sources"]["all"]["deflection_mm"].clone();
    let tip = ends.to_string();
    assert!(tip.contains("tool_tip_mm"), "{tip}");
}

/// Results of a path that come with the program, with this verdict on causes of which some are unknown and some bounds, mm.
fn judged(folder: &Path, base: &str, state: &str, asked: &[&str], unknown: &[&str], bounds: &[(&str, f64)]) -> PathBuf {
    let from = Path::new(env!("CARGO_MANIFEST_DIR")).join("results").join(base);
    let out = tempfile::tempdir_in(folder).unwrap().keep();
    for entry in std::fs::read_dir(from).unwrap().map(Result::unwrap) {
        let name = entry.file_name().into_string().unwrap();
        if ["csv", "json"].iter().any(|ending| name.ends_with(ending)) {
            std::fs::copy(entry.path(), out.join(name)).unwrap();
        }
    }
    let entry = |cause: &&str| {
        let bound = bounds.iter().find(|own| own.0 == *cause).map(|own| own.1);
        let mark = if unknown.contains(cause) { "hollow" } else { "full" };
        serde_json::json!({ "cause": cause, "mark": mark, "mm": bound, "counted": bound.is_none(), "source": "a test" })
    };
    let file = out.join("report.json");
    let mut report: serde_json::Value = serde_json::from_slice(&std::fs::read(&file).unwrap()).unwrap();
    report["headline"]["causes"] = asked.iter().map(entry).collect();
    report["headline"]["verdict"] = serde_json::json!({ "state": state, "words": format!("As the test says {state}") });
    std::fs::write(file, report.to_string()).unwrap();
    out
}

/// Two, three or four results of which more or less is known: the verdict, and what is next.
#[test]
fn parts_are_compared_by_what_their_verdicts_rest_on() {
    let folder = tempfile::tempdir().unwrap();
    let (arm, five_axis) = ("09_robot_part_path", "10_five_axis");
    let all = ["force", "stiffness", "heat", "vibration"];
    let of = |base: &str, state: &str, unknown: &[&str], bounds: &[(&str, f64)]| {
        judged(folder.path(), base, state, &all, unknown, bounds)
    };
    let asked = |base: &str, state: &str, asked: &[&str]| judged(folder.path(), base, state, asked, &[], &[]);
    let said = |results: &[PathBuf], more: &[&str]| {
        let page = folder.path().join("comparison.html");
        let results: Vec<&str> = results.iter().map(|own| text(own)).collect();
        done(&[&["compare", "--force", "--out", text(&page)], more, &results].concat())
    };
    let (within, out) = (of(arm, "good", &[], &[]), of(arm, "bad", &[], &[]));
    let cases = [
        // Out of tolerance is out of it whatever else is unknown.
        (vec![of(arm, "bad", &["heat"], &[]), within.clone()], "✓ B alone within tolerance", "take B."),
        (vec![within.clone(), out.clone(), within.clone()], "✓ A and C alone within tolerance", "take A or C."),
        (vec![of(arm, "bad", &["heat"], &[]), out.clone()], "✗ None is within tolerance", "cut none of them"),
        (
            vec![within.clone(), of(arm, "not_decided", &["heat"], &[])],
            "? Not decided: heat of B unknown",
            "find out about heat of B,",
        ),
        (
            vec![of(arm, "not_decided", &["heat", "force"], &[]), of(arm, "not_decided", &["vibration"], &[])],
            "? Not decided: different causes are unknown",
            "find out about force and heat of A and vibration of B,",
        ),
        // Who asks less is no better for it, nor makes others so.
        (
            vec![out.clone(), asked(arm, "good", &["force"])],
            "? Not decided: different causes are asked about",
            "ask about the same",
        ),
        (
            vec![of(arm, "not_decided", &["heat"], &[]), within.clone(), asked(arm, "good", &["force"])],
            "? Not decided: different causes are asked about",
            "ask about the same",
        ),
        (
            vec![asked(arm, "good", &[]), out.clone()],
            "? Not decided: different causes are asked about",
            "ask about the same",
        ),
        // Of other tolerances one that is within its own is not the better one.
        (
            vec![of(five_axis, "bad", &[], &[]), within.clone()],
            "? Not decided: each has its own tolerance",
            "the same tolerance.",
        ),
        (
            vec![of(arm, "good", &[], &[("heat", 0.4)]), of(arm, "good", &[], &[("heat", 0.01)])],
            "? Not decided: bounds differ by 0.390 mm",
            "bounds included.",
        ),
        // Neither may be cut by the smaller number.
        (vec![out.clone(), out.clone()], "– No difference", "cut none of them yet;"),
    ];
    for (results, verdict, next) in cases {
        for more in [&[][..], &["--tolerance", "0.3"]] {
            let said = said(&results, more);
            let is_as_said = said.starts_with(verdict) || !more.is_empty() && verdict.starts_with('–');
            assert!(is_as_said && said.contains(next), "{verdict}: {said}");
            assert!(!said.starts_with('✓') || verdict.starts_with('✓'), "{said}");
            let told = said.contains("Judged each by itself. A: As the test says ");
            assert!(told, "{said}");
        }
    }
}
