//! The page that a run leaves: self-contained, made again from its files byte for byte, safe against what a user wrote,
//! small with many points, and comparable.

use std::{
    fmt::Write,
    fs,
    path::{Path, PathBuf},
    process::{Command, Output},
};

use serde_json::Value;

use crate::support::placement::short_placement;

fn kinetostat(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_kinetostat")).args(arguments).current_dir(std::env::temp_dir()).output().unwrap()
}

/// What a command that must end well prints.
fn done(arguments: &[&str]) -> String {
    let output = kinetostat(arguments);
    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.code() == Some(0) && errors.is_empty(), "{arguments:?}: {errors}");
    String::from_utf8(output.stdout).unwrap()
}

/// What a command that must be refused says.
fn refused(arguments: &[&str]) -> String {
    let output = kinetostat(arguments);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}");
    assert!(output.stdout.is_empty(), "{arguments:?}");
    String::from_utf8(output.stderr).unwrap()
}

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

const QUESTION: &str = "Is 1 < 2 & \"safe\"? </script><script>alert(1)</script><img src=x onerror=alert(2)>";

/// A small map with force law `law`, run at `grid`; its result folder.
fn map(folder: &Path, name: &str, law: &str, grid: &str, figures: bool) -> PathBuf {
    let study = folder.join("studies").join(name);
    fs::create_dir_all(&study).unwrap();
    let toml = format!(
        r#"schema = 3
question = '''{QUESTION}'''
machine = "orthoglide"
workspace_map = {{ grid = [3, 3, 3], slices_z_mm = [0.0], phi_step_deg = 90.0 }}
[process.force]
path_frame = {{ radial_force_N = 215.0, tangential_force_N = -10.0, axial_force_N = -25.0, law = "{law}" }}
[[process.chain_error]]
chain = "x"
turn_about_drive_axis_deg = 1.0
"#
    );
    fs::write(study.join("study.toml"), toml).unwrap();
    let out = folder.join(name);
    let mut arguments = vec!["run", text(&study), "--grid", grid, "--out", text(&out)];
    if !figures {
        arguments.push("--no-figures");
    }
    done(&arguments);
    out
}

fn page(folder: &Path) -> String {
    fs::read_to_string(folder.join("report.html")).unwrap()
}

/// The page without its scripts and styles: what a reader sees without them.
fn body(page: &str) -> String {
    let mut rest = page;
    let mut body = String::new();
    while let Some((before, after)) = rest.split_once("<script") {
        body += before;
        rest = after.split_once("</script>").expect("every script ends").1;
    }
    // A slash is escaped as well.
    (body + rest).replace("&#x2f;", "/")
}

/// The data of the first view.
fn data(page: &str) -> Value {
    let after = page.split_once("id=\"data-0\">").expect("the page has a view").1;
    serde_json::from_str(after.split_once("</script>").unwrap().0).unwrap()
}

#[test]
fn a_page_is_one_file_and_is_made_again_byte_for_byte() {
    let folder = tempfile::tempdir().unwrap();
    let out = map(folder.path(), "map", "paper_eq17", "3", true);
    let html = page(&out);
    let body = body(&html);
    assert!(html.contains("default-src 'none'"), "the page forbids itself the network");
    for address in ["src=\"http", "href=\"http", "url(http", "@import"] {
        assert!(!body.contains(address), "{address}");
    }
    let images: Vec<&str> = body.split("<img ").skip(1).map(|tag| tag.split_once('>').unwrap().0).collect();
    assert_eq!(images.len(), 10, "machine at home, the answer, seven figures, machine bent");
    for image in images {
        let alternative = image.split_once("alt=\"").unwrap().1;
        assert!(!alternative.starts_with('"') && image.contains("src=\"data:image"), "{image:.200}");
    }
    for expected in [
        "The cutting force alone moves the tool",
        "215 N radial",
        "error of chain x",
        "href=\"map.csv\"",
        "input sha256",
    ] {
        assert!(body.contains(expected), "{expected} is missing");
    }
    fs::remove_file(out.join("report.html")).unwrap();
    assert_eq!(done(&["report", text(&out)]), format!("Written to {}\n", out.join("report.html").display()));
    assert!(page(&out) == html, "the page made again differs");

    let elsewhere = folder.path().join("elsewhere.html");
    done(&["report", text(&out), "--out", text(&elsewhere)]);
    assert!(self::body(&fs::read_to_string(&elsewhere).unwrap()).contains("href=\"map/map.csv\""));
}

#[test]
fn what_a_user_wrote_is_text() {
    let folder = tempfile::tempdir().unwrap();
    let out = map(folder.path(), "map", "paper_eq17", "1", false);
    let html = page(&out);
    assert!(!html.contains("<script>alert") && !html.contains("<img src=x"), "the question is markup");
    assert!(html.contains("1 &lt; 2 &amp; &quot;safe&quot;"), "the question is not shown");

    // Names in the description, and reasons in a table, may come from anywhere.
    let file = out.join("report.json");
    let described =
        fs::read_to_string(&file).unwrap().replace("\"Workspace map\"", "\"</script><script>alert(3)\u{202e}\"");
    fs::write(&file, described).unwrap();
    let table = out.join("map.csv");
    let rows = fs::read_to_string(&table).unwrap();
    fs::write(&table, rows.replacen("solved,", "lost,<b onclick=alert(4)>far</b></script>", 1)).unwrap();
    done(&["report", text(&out)]);
    let html = page(&out);
    assert!(!html.contains("<script>alert") && !html.contains("<b onclick"), "a name or reason is markup");
    assert!(html.contains(r"alert(3)\u{202e}") && !html.contains('\u{202e}'), "a name turns the text after it around");
    assert_eq!(data(&html)["notes"][0], "lost: <b onclick=alert(4)>far</b></script>");
}

#[test]
fn a_page_without_figures_still_shows_the_machine() {
    let folder = tempfile::tempdir().unwrap();
    let out = map(folder.path(), "map", "paper_eq17", "2", false);
    assert_eq!(body(&page(&out)).matches("<img ").count(), 1);
    assert!(!out.join("machine_at_home.svg").exists());
}

#[test]
fn every_kind_of_study_leaves_a_page_with_views() {
    let folder = tempfile::tempdir().unwrap();
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/02_groove_50mm");
    let placement = short_placement(folder.path());
    for (number, (study, size, views)) in [
        (path, &["--points", "9"][..], ["Along the path", "Methods of compensation"]),
        (placement, &[], ["Places of the sweep", "Named and found places"]),
    ]
    .into_iter()
    .enumerate()
    {
        let out = folder.path().join(number.to_string());
        done(&[&["run", text(&study), "--out", text(&out), "--no-figures"], size].concat());
        let html = page(&out);
        for view in views {
            assert!(html.contains(view), "{view}");
        }
        assert!(!data(&html)["quantities"].as_array().unwrap().is_empty());
        let report: Value = serde_json::from_str(&fs::read_to_string(out.join("report.json")).unwrap()).unwrap();
        hold_to_few_words(&report["headline"]);
        // A path is drawn in plan: where it is, and which displacements lie along the same axes.
        let plan = data(&html)["plan"].as_array().unwrap().clone();
        let labels: Vec<&str> = plan.iter().map(|axis| axis[1].as_str().unwrap()).collect();
        let along = ["displacement along x", "displacement along y", "displacement along z"];
        assert_eq!(labels, if number == 0 { &along[..] } else { &[] });
        if number == 0 {
            // A circle of 50 mm about Q1, whose tool is 100 mm above P.
            let ends = |axis: usize| ["low", "high"].map(|end| plan[axis][0][end].as_f64().unwrap());
            assert_eq!(ends(0).map(|x| (x * 1e6).round()), [101.35e6, 151.35e6]);
            assert_eq!(ends(2), [226.35, 226.35]);
        }
    }
}

/// A verdict has at most eight words, the first sentence twelve, where a number and its unit are one; three numbers, and what to do next.
fn hold_to_few_words(headline: &Value) {
    let words = |text: &Value| {
        text.as_str()
            .unwrap()
            .split(' ')
            .filter(|own| !["mm", "%", "µm", "N"].contains(&own.trim_matches([',', '.', ';'])))
            .count()
    };
    let (verdict, sentence) = (&headline["verdict"]["words"], &headline["sentence"]);
    // Of what it holds comes first where readers took it for all.
    let told = sentence.as_str().unwrap();
    let conditions = ["Deflection alone: ", "What is computed alone: "];
    let sentence = &Value::from(conditions.into_iter().find_map(|own| told.strip_prefix(own)).unwrap_or(told));
    assert!(words(verdict) <= 8 && words(sentence) <= 12, "{verdict} {sentence}");
    assert!(headline["numbers"].as_array().unwrap().len() <= 3, "{headline:#}");
    assert!(!headline["next"].as_str().unwrap().is_empty());
}

#[test]
fn first_screens_of_results_that_come_with_it_have_few_words() {
    let results = Path::new(env!("CARGO_MANIFEST_DIR")).join("results");
    let mut held = 0;
    for entry in fs::read_dir(results).unwrap() {
        if let Ok(report) = fs::read_to_string(entry.unwrap().path().join("report.json")) {
            hold_to_few_words(&serde_json::from_str::<Value>(&report).unwrap()["headline"]);
            held += 1;
        }
    }
    assert!(held > 15, "{held}");
}

/// What the first screen of a comparison of results that come with the program says: few words, the inputs that differ most, and bars where one is best everywhere.
#[test]
fn first_screens_of_comparisons_have_few_words_and_name_what_differs() {
    let folder = tempfile::tempdir().unwrap();
    let results = Path::new(env!("CARGO_MANIFEST_DIR")).join("results");
    let page = folder.path().join("comparison.html");
    let compared = |names: &[&str], more: &[&str]| {
        let folders: Vec<String> = names.iter().map(|name| results.join(name).display().to_string()).collect();
        let all: Vec<&str> =
            ["report", "--force", "--out", text(&page)].into_iter().chain(more.iter().copied()).collect();
        let said = done(&[all, folders.iter().map(String::as_str).collect()].concat());
        let body = body(&fs::read_to_string(&page).unwrap());
        let (first, rest) = said.split_once('\n').unwrap();
        let sentence = rest.lines().take_while(|line| !line.is_empty()).collect::<Vec<_>>().join(" ");
        let [verdict, sentence] = [Value::from(first), Value::from(sentence)];
        let of = |tag: &str| {
            body.split_once(tag).unwrap().1.split_once('>').unwrap().1.split_once("</").unwrap().0.to_string()
        };
        let headline = serde_json::json!({
            // Neither the sign nor a mark is a word.
            "verdict": { "words": verdict.as_str().unwrap().split_once(' ').unwrap().1.split(" [").next().unwrap() },
            "sentence": of("id=\"answer-title\""), "numbers": [], "next": of("class=\"next\""),
        });
        hold_to_few_words(&headline);
        assert_eq!(headline["sentence"], sentence, "the page says what the terminal says");
        (verdict.as_str().unwrap().to_string(), body)
    };
    // Of these git keeps no maps.
    let arms = ["07_robot_arm", "07_robot_arm_fitted"].map(|name| {
        let study = Path::new(env!("CARGO_MANIFEST_DIR")).join("studies").join(name);
        let out = folder.path().join(name);
        done(&["run", text(&study), "--grid", "2", "--out", text(&out), "--no-figures"]);
        out
    });
    let (verdict, fitted) = compared(&[text(&arms[0]), text(&arms[1])], &[]);
    assert!(verdict.starts_with("– ") && verdict.ends_with(" [no tolerance given]"), "{verdict}");
    assert!(verdict.to_lowercase().contains("typically"), "{verdict}");
    assert!(
        fitted.contains("stiffness of J6: 79.6 kN·m/rad in A, 210 kN·m/rad in B, 2.64 times as much"),
        "{fitted:.6000}"
    );
    let listed = fitted.split_once("stiffness of J6:").unwrap().1.split_once("</ul>").unwrap().0;
    assert!(listed.contains("stiffness of J2: 4129 kN·m/rad in A, 2720 kN·m/rad in B, 0.66 times as much"), "{listed}");
    assert!(!listed.contains("source") && listed.matches("<li>").count() == 4, "{listed}");

    let (verdict, other) =
        compared(&["08_three_architectures", "08_three_architectures_3puu"], &["--tolerance", "0.1"]);
    assert_eq!(verdict, "✗ All out of tolerance everywhere");
    assert!(other.contains("q2 of leg: parallelogram in A, revolute joint in B"), "{other:.6000}");
    assert!(other.contains("rod of leg: not in A, link in B") && other.contains("each at its worst"), "{other:.6000}");

    let (verdict, _) = compared(&["03_placement_circle", "04_placement_pocket"], &[]);
    assert_eq!(verdict, "? Not decided: force of B unknown [of what is computed: some causes are unknown]");
    let (verdict, _) = compared(&["03_placement_circle", "04_placement_pocket"], &["--tolerance", "0.01"]);
    assert_eq!(verdict, "? Not decided: force of B unknown [of what is computed: some causes are unknown]");
    let (verdict, again) = compared(&["03_placement_circle", "03_placement_circle"], &[]);
    assert_eq!(verdict, "– No difference but for rounding");
    assert!(again.contains("take either"));
}

/// Replaces the rows of a map by `n`³ made-up ones.
fn enlarge(out: &Path, n: usize) {
    let table = out.join("map.csv");
    let header = fs::read_to_string(&table).unwrap().lines().next().unwrap().to_string();
    let columns = header.split(',').count();
    let mut rows = header + "\n";
    for node in 0..n.pow(3) {
        let place = [node % n, node / n % n, node / (n * n)].map(|i| i as f64 * 5.0 - 73.65);
        for (s, source) in ["cutting", "geometry", "all"].iter().enumerate() {
            write!(rows, "{},{},{},{source},solved,,solved,", place[0], place[1], place[2]).unwrap();
            for column in 8..columns {
                write!(rows, ",{}", ((node * (s + 1)) as f64 * 0.001 + column as f64).sin()).unwrap();
            }
            rows.push('\n');
        }
    }
    fs::write(table, rows).unwrap();
}

#[test]
fn fifty_thousand_points_make_a_page_below_fifteen_megabytes() {
    let folder = tempfile::tempdir().unwrap();
    let out = map(folder.path(), "map", "paper_eq17", "2", true);
    enlarge(&out, 37);
    done(&["report", text(&out)]);
    let html = page(&out);
    assert!(html.len() < 15_000_000, "{} bytes", html.len());
    assert_eq!(data(&html)["axes"][0].as_array().unwrap().len(), 37, "no point is left out");
    enlarge(&out, 50);
    done(&["report", text(&out)]);
    let html = page(&out);
    assert!(html.len() < 15_000_000, "{} bytes", html.len());
    assert!(html.contains("50 × 50 × 50 nodes of map.csv, evenly chosen"), "a larger grid is thinned, and says so");
}

/// The smallest or largest deflection under both sources that a map's summary gives, mm.
fn deflection(folder: &Path, which: &str) -> f64 {
    let summary: Value = serde_json::from_str(&fs::read_to_string(folder.join("summary.json")).unwrap()).unwrap();
    summary["sources"]["all"]["deflection_mm"][which]["value"].as_f64().unwrap()
}

#[test]
fn two_maps_are_compared_node_by_node() {
    let folder = tempfile::tempdir().unwrap();
    let printed = map(folder.path(), "printed", "paper_eq17", "3", false);
    let rotated = map(folder.path(), "rotated", "rotated", "3", false);
    let out = folder.path().join("comparison.html");
    done(&["report", text(&printed), text(&rotated), "--out", text(&out)]);
    let html = fs::read_to_string(&out).unwrap();
    let body = body(&html);
    for expected in [
        "printed, rotated compared",
        "law of path frame: paper_eq17 in A, rotated in B",
        "side by side over 27 grid points",
        "Who is better where",
        "B against A",
        "Who is best where: worst tool deflection, all at once",
        "no tolerance is given for the difference",
    ] {
        assert!(body.contains(expected), "{expected} is missing");
    }
    assert!(body.contains("href=\"printed/report.html\""));
    let data = data(&html);
    let names: Vec<&str> = data["cases"].as_array().unwrap().iter().map(|c| c["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["A: printed", "B: rotated", "B \u{2212} A"]);

    // The extremes are those of the tables, whose ratio stands beside them.
    let (a, b) = (deflection(&printed, "largest"), deflection(&rotated, "largest"));
    assert!(body.contains(&format!("data-sort=\"{a}\"")) && body.contains(&format!("data-sort=\"{b}\"")));
    assert!(body.contains(&format!("data-sort=\"{:.4}\"", b / a)), "{a} {b}");
    // The first screen says of which numbers of which tables it is made.
    let checks = html.split_once("data-checks=\"").unwrap().1.split_once('"').unwrap().0.replace("&quot;", "\"");
    let checks: Value = serde_json::from_str(&checks.replace("&#x2f;", "/")).unwrap();
    assert_eq!((checks[0]["file"].as_str(), checks[0]["rule"].as_str()), (Some("printed/map.csv"), Some("max")));
    assert_eq!((checks[0]["value"].as_f64(), checks[1]["value"].as_f64()), (Some(a), Some(b)));
    let difference = &data["cases"][2]["series"][0][0];
    let (low, high) = (difference["low"].as_f64().unwrap(), difference["high"].as_f64().unwrap());
    assert!(low <= b - a && b - a <= high && low < high, "{low} {} {high}", b - a);
}

#[test]
fn a_result_compared_with_itself_is_the_same_everywhere() {
    let folder = tempfile::tempdir().unwrap();
    let out = map(folder.path(), "map", "paper_eq17", "2", false);
    let page = folder.path().join("page.html");
    done(&["report", text(&out), text(&out), "--out", text(&page)]);
    let body = body(&fs::read_to_string(&page).unwrap());
    assert!(body.contains("A and B are the same but for rounding."), "{body:.3000}");
    assert!(body.contains("Their worst tool deflection differs nowhere by more than"), "{body:.3000}");
    assert!(body.contains("Machine, process and study hold the same values."), "{body:.3000}");
    assert!(!body.contains("class=\"differs\"") && !body.contains("class=\"win "), "{body:.3000}");
}

#[test]
fn maps_over_other_nodes_are_compared_as_far_as_they_can_be() {
    let folder = tempfile::tempdir().unwrap();
    let coarse = map(folder.path(), "coarse", "paper_eq17", "2", false);
    let page = folder.path().join("page.html");
    let compare = |other: &Path| {
        done(&["report", text(&coarse), text(other), "--out", text(&page)]);
        body(&fs::read_to_string(&page).unwrap())
    };
    let finer = map(folder.path(), "finer", "paper_eq17", "3", false);
    let found = compare(&finer);
    assert!(
        found.contains("The results have 8 and 27 grid points, 8 of them in common: smallest, mean"),
        "{found:.3000}"
    );
    // What only the finer grid has does not count.
    assert!(
        found.contains("computed over 8 grid points in common")
            && found.contains("A (coarse) and B (finer) are the same"),
        "{found:.3000}"
    );
    let [own, shared] = [&finer, &coarse].map(|folder| deflection(folder, "smallest"));
    assert!(own < 0.9 * shared, "{own} {shared}");
    let sort = |value: f64| format!("data-sort=\"{value}\"");
    assert!(found.contains(&sort(shared)) && !found.contains(&sort(own)));
    let single = map(folder.path(), "single", "paper_eq17", "1", false);
    let found = compare(&single);
    assert!(
        found.contains("The results have 8 and 1 grid points and none in common: their numbers are not compared"),
        "{found:.3000}"
    );
    assert!(!found.contains("side by side over") && !found.contains("Who is better where"));
}

#[test]
fn curves_of_other_points_have_extremes_over_all_of_their_own() {
    let folder = tempfile::tempdir().unwrap();
    let study = Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/02_groove_50mm");
    let [coarse, finer] = ["5", "9"].map(|points| {
        let out = folder.path().join(points);
        done(&["run", text(&study), "--points", points, "--out", text(&out), "--no-figures"]);
        out
    });
    let page = folder.path().join("page.html");
    done(&["report", text(&coarse), text(&finer), "--out", text(&page)]);
    let found = body(&fs::read_to_string(&page).unwrap());
    assert!(found.contains("The results have 5 and 9 path points, 5 of them in common: differences"), "{found:.3000}");
    assert!(found.contains("Along the path, side by side over all own path points"), "{found:.3000}");
    assert!(found.contains("Methods of compensation, side by side over 9 methods"), "{found:.3000}");
}

#[test]
fn what_is_no_result_or_of_another_kind_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let out = map(folder.path(), "map", "paper_eq17", "1", false);
    let nowhere = folder.path().join("nowhere");
    assert!(refused(&["report", text(&nowhere)]).contains("nowhere: is not a folder; expected a result folder"));
    assert!(refused(&["report", text(folder.path())]).contains("has no report.json; expected a result folder"));
    assert!(refused(&["report"]).contains("<RESULTS>..."));

    let path = folder.path().join("path");
    let study = Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/02_groove_50mm");
    done(&["run", text(&study), "--points", "5", "--out", text(&path), "--no-figures"]);
    let message = refused(&["report", text(&out), text(&path)]);
    assert!(message.contains("path: is a result of kind path, but") && message.contains("of one kind"), "{message}");
    let seven = [text(&out); 7];
    assert!(refused(&[&["report"], &seven[..]].concat()).contains("at most 6 can be compared, got 7"));

    let file = out.join("report.json");
    let described = fs::read_to_string(&file).unwrap();
    let broken = |text_of_file: String| {
        fs::write(&file, text_of_file).unwrap();
        refused(&["report", text(&out)])
    };
    assert!(
        broken(described.replacen("\"schema\": 3", "\"schema\": 9", 1))
            .contains("report.json: schema: must be 3, got 9")
    );
    assert!(broken(described.replacen("\"question\"", "\"doubt\"", 1)).contains("unknown field `doubt`"));
    assert!(broken("{".into()).contains("report.json:1: "));
    let outside = described.replace("\"map.csv\"", "\"../map.csv\"");
    assert!(broken(outside).contains("must be the name of a file in the folder, got \"../map.csv\""));
    fs::write(&file, &described).unwrap();
    fs::write(out.join("map.csv"), "x_mm,y_mm\n1,2\n").unwrap();
    assert!(refused(&["report", text(&out)]).contains("map.csv:1: there is no column \"z_mm\""));
    fs::remove_file(out.join("map.csv")).unwrap();
    assert!(refused(&["report", text(&out)]).contains("map.csv: cannot be read: "));
}

#[test]
fn results_of_two_runs_are_not_one_page() {
    let folder = tempfile::tempdir().unwrap();
    let out = map(folder.path(), "map", "paper_eq17", "1", false);
    let manifest = || fs::read_to_string(out.join("manifest.json")).unwrap();
    assert!(!manifest().contains("publishing"), "of a run that ended");
    // As a run leaves it that is cut short between its tables and its summary.
    fs::write(out.join("manifest.json"), manifest().replacen('{', "{\n  \"publishing\": true,", 1)).unwrap();
    let study = folder.path().join("studies/map");
    for arguments in [vec!["report", text(&out)], vec!["report", text(&out), text(&out)]] {
        let message = refused(&arguments);
        assert!(message.contains("some files are of that run, others of the one before"), "{message}");
    }
    done(&["run", text(&study), "--grid", "2", "--out", text(&out), "--no-figures"]);
    assert!(!manifest().contains("publishing"), "{}", manifest());
    done(&["report", text(&out)]);
}

#[test]
fn what_differs_is_told_key_by_key_and_held_against_a_tolerance() {
    let folder = tempfile::tempdir().unwrap();
    let short = map(folder.path(), "short", "paper_eq17", "2", false);
    // The same study of the same machine with a longer tool.
    let study = folder.path().join("studies/short/study.toml");
    let machine = Path::new(env!("CARGO_MANIFEST_DIR")).join("crates/engine/src/machine/catalogue/orthoglide.toml");
    let longer = fs::read_to_string(machine)
        .unwrap()
        .replace("tool_tip_mm = [0.0, 0.0, 100.0]", "tool_tip_mm = [0.0, 0.0, 150.0]");
    fs::write(folder.path().join("studies/short/longer.toml"), longer).unwrap();
    let text_of_study = fs::read_to_string(&study).unwrap();
    fs::write(&study, text_of_study.replace("machine = \"orthoglide\"", "machine = \"longer.toml\"")).unwrap();
    let long = folder.path().join("long");
    done(&["run", text(&folder.path().join("studies/short")), "--grid", "2", "--out", text(&long), "--no-figures"]);
    let page = folder.path().join("page.html");
    done(&["compare", text(&short), text(&long), "--tolerance", "0.25", "--out", text(&page)]);
    let found = body(&fs::read_to_string(&page).unwrap());
    for expected in [
        "tool tip of platform: [0.0, 0.0, 100.0] in A, [0.0, 0.0, 150.0] in B",
        "of the workspace within 0.25 mm in A",
        "larger than 0.25 mm (--tolerance)",
        "The tool of A",
    ] {
        assert!(found.replace("against 0.25 mm", "of 0.25 mm").contains(expected), "{expected}: {found:.4000}");
    }
    let refused_of = |arguments: &[&str]| refused(&[arguments, &["--out", text(&page)]].concat());
    assert!(
        refused_of(&["compare", text(&short), text(&long), "--tolerance", "0"])
            .contains("--tolerance: must be greater")
    );
    assert!(refused_of(&["report", text(&short), "--tolerance", "1"]).contains("is for the comparison of several"));
    assert!(
        refused_of(&["compare", text(&short), text(&long), "--machine", "orthoglide"]).contains("cannot be used with")
    );
}

#[test]
fn a_cell_that_is_no_number_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let out = map(folder.path(), "map", "rotated", "2", false);
    let table = out.join("map.csv");
    let text_of_table = std::fs::read_to_string(&table).unwrap();
    let (head, rows) = text_of_table.split_once('\n').unwrap();
    let column = head.split(',').position(|name| name == "deflection_mm").unwrap();
    let mut cells: Vec<&str> = rows.lines().next().unwrap().split(',').collect();
    cells[column] = "abc";
    let others = rows.split_once('\n').unwrap().1;
    std::fs::write(&table, format!("{head}\n{}\n{others}", cells.join(","))).unwrap();
    let said = refused(&["report", text(&out)]);
    assert!(said.contains("map.csv:2: deflection_mm: expected a number or nothing, got \"abc\""), "{said}");
}
