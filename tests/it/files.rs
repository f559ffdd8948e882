//! What results are left in: tables in every format, maps as images, the words of both, and files that appear whole or not at all.

use std::{borrow::Cow, collections::BTreeMap, path::Path};

use kinetostat::{
    files::{
        Foreign, Manifest, OutputFile, PreparedFolder, Recorded, StatusCount, check_may_replace, counted, display_json,
        exchange::{self, Cell, Table, counts, description, numbers, texts, unescape_formula},
        lock_folder, millimetres, position, prepare, temporary_file, visible, visible_json, with_minus_signs,
        write_all,
    },
    input::{Inputs, file},
    page::headline::KeyNumber,
};
use serde_json::{Value, json};

fn sample() -> Table {
    let columns = [counts(["point"]), numbers(["x_mm"]), texts(["reason, if any"])].concat();
    let rows = [
        vec![0.into(), 0.1.into(), "".into()],
        vec![1.into(), Cell::Missing, "\"no\",\nsaid the leg".into()],
        vec![2.into(), (-1e-300).into(), "μ".into()],
    ];
    Table::new(columns, rows)
}

#[test]
fn a_table_as_csv_is_read_back_as_it_was() {
    let bytes = exchange::csv(&sample()).unwrap();
    let mut reader = csv::Reader::from_reader(bytes.as_slice());
    assert_eq!(reader.headers().unwrap(), vec!["point", "x_mm", "reason, if any"]);
    let rows: Vec<(usize, Option<f64>, Option<String>)> = reader.deserialize().map(|row| row.unwrap()).collect();
    let expected = vec![
        (0, Some(0.1), None),
        (1, None, Some("\"no\",\nsaid the leg".into())),
        (2, Some(-1e-300), Some("μ".into())),
    ];
    assert_eq!(rows, expected);
}

#[test]
fn no_text_is_a_formula_and_numbers_are_not_touched() {
    let names = ["=cmd|' /C calc'!A0", "+1", "-1", "@SUM(1)", "\t=1", "'=1", "''-", "a=1", "'quoted'", "−1"];
    let rows = names.map(|name| vec![name.into(), (-1.5).into()]);
    let bytes = exchange::csv(&Table::new([texts(["name"]), numbers(["x_mm"])].concat(), rows)).unwrap();
    let mut reader = csv::Reader::from_reader(bytes.as_slice());
    for (name, row) in names.iter().zip(reader.records()) {
        let row = row.unwrap();
        assert!(!row[0].starts_with(['=', '+', '-', '@', '\t', '\r', '\n']), "{row:?}");
        assert_eq!((unescape_formula(&row[0]), &row[1]), (*name, "-1.5"));
    }
}

#[test]
fn the_description_has_units_and_types() {
    let described = description([("a.csv", &sample())]);
    let columns = &described["tables"][0]["tableSchema"]["columns"];
    assert_eq!(described["schema:version"], "3");
    assert_eq!(described["tables"][0]["url"], "a.csv");
    assert_eq!(columns[1], json!({ "titles": "x_mm", "datatype": "double", "schema:unitText": "mm" }));
    assert_eq!(columns[2], json!({ "titles": "reason, if any", "datatype": "string" }));
}

#[test]
fn the_unit_is_what_the_name_ends_with() {
    let units = [
        ("deflection_mm", Some("mm")),
        ("stiffness_min_N_per_mm", Some("N/mm")),
        ("drive_torque_a1_Nmm", Some("N·mm")),
        ("drive_force_x_N", Some("N")),
        ("delta_rho_x_Fx_mm_per_N", Some("mm/N")),
        ("delta_rho_a1_Fx_Fy_deg_per_N2", Some("deg/N²")),
        ("tool angle φ [°]", Some("°")),
        ("ratio", None),
    ];
    for (name, unit) in units {
        assert_eq!(numbers([name])[0].unit(), unit, "{name}");
        assert_eq!(texts([name])[0].unit(), None, "{name}");
    }
}

#[test]
#[should_panic(expected = "in column")]
fn a_word_is_no_number() {
    Table::new(numbers(["x_mm"]), [vec![Cell::from("word")]]);
}

#[test]
fn one_is_singular() {
    let shown = [0, 1, 2].map(|count| counted(count, "path point"));
    assert_eq!(shown, ["0 path points", "1 path point", "2 path points"]);
}

#[test]
fn small_lengths_keep_two_digits_and_less_than_a_nanometre_is_said_to_be_less() {
    let lengths = [0.0, 3e-10, 2e-7, 2.34e-5, 8.2e-4, 0.0098, 0.012345, 1.0];
    let shown = lengths.map(|length| millimetres(length, 3));
    let expected =
        ["0 mm", "less than 0.001 µm", "less than 0.001 µm", "0.023 µm", "0.82 µm", "9.8 µm", "0.012 mm", "1.000 mm"];
    assert_eq!(shown, expected);
}

#[test]
fn numbers_come_apart_from_their_units() {
    for shown in ["1.712 mm", "8.5e\u{2212}4 mm", "11", "90.0°", "100 %", "12 N·mm"] {
        assert_eq!(KeyNumber::new(shown, "", "").shown(), shown);
    }
    assert_eq!(KeyNumber::new("1.712 mm", "", "").unit, "mm");
    assert_eq!(KeyNumber::new("90.0°", "", "").unit, "°");
}

fn keys(study: &str, machine: &str) -> BTreeMap<(String, String), String> {
    Recorded::by_part(&Recorded::of(&Inputs::of("study.toml", study).and(Inputs::of("arm", machine))))
}

#[test]
fn a_foot_is_found_by_its_name_and_comments_do_not_count() {
    let machine = |height: f64| {
        format!(
            "# a comment of {height}\n[[chain]]\nname = \"leg\"\nelements = [\n  {{ fixed = {{ x = 1 }} }},\n  \
             {{ beam = {{ name = \"foot\", section = {{ height_mm = {height:.1} }} }} }} ]\n"
        )
    };
    let (a, b) = (keys("machine = \"arm\"", &machine(20.0)), keys("machine = \"arm\" # same", &machine(22.0)));
    let changed: Vec<_> = a.iter().filter(|(key, value)| b.get(*key) != Some(value)).collect();
    let key = ("machine".to_string(), "chain.leg.elements.foot.beam.section.height_mm".to_string());
    assert_eq!(changed, [(&key, &"20.0".to_string())]);
    assert_eq!(b[&key], "22.0");
    assert_eq!(a[&("machine".into(), "chain.leg.elements.1.fixed.x".into())], "1");
}

#[test]
fn a_process_is_the_same_in_a_study_and_in_a_file() {
    let within = keys("[process.force]\nlaw = \"paper_eq17\"", "");
    let study = Inputs::of("study.toml", "process = \"p.toml\"").and(Inputs::of("arm", ""));
    let apart = Recorded::by_part(&Recorded::of(&study.and(Inputs::of("p.toml", "[force]\nlaw = \"paper_eq17\""))));
    let key = ("process".to_string(), "force.law".to_string());
    assert_eq!((within[&key].as_str(), apart[&key].as_str()), ("paper_eq17", "paper_eq17"));
}

#[test]
fn a_path_is_known_by_its_hash() {
    let inputs = Inputs::of("study.toml", "").and(Inputs::of("arm", "")).and(Inputs::of("part.nc", "G0 X1\nG1 X2\n"));
    let keys = Recorded::by_part(&Recorded::of(&inputs.and(Inputs::of("points of the path", "73"))));
    assert!(keys[&("part.nc".into(), String::new())].starts_with("part.nc (SHA-256 "));
    assert_eq!(keys[&("points of the path".into(), String::new())], "73");
}

#[test]
fn what_is_not_solved_is_counted_by_its_status_most_frequent_first() {
    let statuses = ["solved", "unreachable", "slow", "converged", "slow", "no_equilibrium"];
    let counts = Manifest::count(statuses.into_iter());
    let expected = "4 of 6 not solved: 2 slow, 1 unreachable, 1 no equilibrium.";
    assert_eq!(StatusCount::unsolved(&counts).as_deref(), Some(expected));
    assert_eq!(StatusCount::unsolved(&counts[..1]), None);
}

#[test]
fn only_what_a_run_wrote_is_replaced() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let refused = |names: &[&str], expected: &str| {
        let error = Manifest::check_may_write(folder.path(), names.iter().copied()).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    };
    std::fs::write(at("map.csv"), "mine").unwrap();
    Manifest::check_may_write(folder.path(), ["points.csv"].into_iter()).unwrap();
    refused(&["points.csv", "map.csv"], "map.csv: cannot be written: was not written by kinetostat");
    std::fs::write(at(Manifest::FILE), r#"{ "program": "another", "files": ["map.csv"] }"#).unwrap();
    refused(&[], "manifest.json: cannot be written: was not written by kinetostat");
    std::fs::write(at(Manifest::FILE), r#"{ "program": "kinetostat", "files": ["map.csv", "../other"] }"#).unwrap();
    Manifest::check_may_write(folder.path(), ["map.csv"].into_iter()).unwrap();
    file::read(&at("map.csv")).unwrap();
    refused(&[], "map.csv: cannot be written: is an input of this command");
    std::fs::create_dir(at("points.csv")).unwrap();
    std::fs::remove_file(at("map.csv")).unwrap();
    refused(&["points.csv"], "points.csv: cannot be written: is a folder");
    refused(&[&"x".repeat(300)], "cannot be written: File name too long");
}

#[cfg(unix)]
#[test]
fn links_and_devices_are_left_alone() {
    let folder = tempfile::tempdir().unwrap();
    let link = folder.path().join("map.csv");
    std::os::unix::fs::symlink("/etc/hostname", &link).unwrap();
    let error = check_may_replace(&link, Foreign::Replaced, || true).unwrap_err().to_string();
    assert!(error.contains("map.csv: cannot be written: is a link"), "{error}");
    let error = check_may_replace(Path::new("/dev/null"), Foreign::Replaced, || true).unwrap_err().to_string();
    assert!(error.contains("/dev/null: cannot be written: is a device"), "{error}");
}

#[test]
fn a_folder_that_cannot_be_made_is_an_error_naming_it() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("taken");
    std::fs::write(&file, b"x").unwrap();
    let below = file.join("below");
    let written = write_all(&below, vec![OutputFile::new("a.csv", "1")]).map(drop);
    for error in [written.unwrap_err(), prepare(&below).unwrap_err()] {
        assert!(error.to_string().contains("taken/below: cannot be written"), "{error}");
    }
}

#[test]
fn what_was_made_and_stays_empty_is_removed() {
    let folder = tempfile::tempdir().unwrap();
    let (outer, inner) = (folder.path().join("new"), folder.path().join("new/inner"));
    drop(PreparedFolder::new(&inner).unwrap());
    assert!(!outer.exists() && folder.path().exists());
    let prepared = PreparedFolder::new(&inner).unwrap();
    std::fs::write(outer.join("result"), "").unwrap();
    drop(prepared);
    assert!(outer.exists() && !inner.exists());
    std::fs::create_dir(&inner).unwrap();
    drop(PreparedFolder::new(&inner).unwrap());
    assert!(inner.exists(), "it was there before");
}

const NAME: &str = "gpj.\u{202e}\u{1b}[31mred\u{9b}0m\u{2066}é漢\t\u{200d}";
const SHOWN: &str = "gpj.\\u{202e}\\u{1b}[31mred\\u{9b}0m\\u{2066}é漢\t\u{200d}";
const ACTING: [char; 4] = ['\u{202e}', '\u{1b}', '\u{9b}', '\u{2066}'];

#[test]
fn what_acts_is_written_out_and_letters_stay() {
    assert_eq!(visible(NAME), SHOWN);
    assert!(matches!(visible("Größe 1\n漢字"), Cow::Borrowed(_)));
}

#[test]
fn json_keeps_its_strings_or_shows_them() {
    let text = json!({ "name": NAME, "n": 1 }).to_string();
    let read = |text: &str| serde_json::from_str::<Value>(text).unwrap()["name"].as_str().unwrap().to_string();
    let sent = visible_json(&text);
    assert!(!sent.contains(ACTING));
    assert_eq!(read(&sent), NAME);
    let shown = display_json(&text);
    assert!(!shown.contains(ACTING));
    assert!(read(&shown).starts_with("gpj.\\u{202e}"), "{shown}");
}

#[test]
fn signs_are_minus_signs_and_names_keep_their_hyphens() {
    let shown = with_minus_signs("box clamp-2 at (-1.5, 3) mm, -4 to -2, a-b");
    assert_eq!(shown, "box clamp-2 at (\u{2212}1.5, 3) mm, \u{2212}4 to \u{2212}2, a-b");
}

#[test]
fn positions_have_minus_signs_and_no_negative_zero() {
    assert_eq!(position(-73.65, 126.35, -0.004), "(\u{2212}73.65, 126.35, 0.0) mm");
    assert_eq!(position(59.683, 1.0 / 3.0, 100.0), "(59.7, 0.3, 100.0) mm");
}

#[test]
fn writing_replaces_and_leaves_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    prepare(folder.path()).unwrap();
    for content in ["1", "2"] {
        write_all(folder.path(), vec![OutputFile::new("a.csv", content)]).unwrap();
    }
    // What a running command makes stays, what a killed one has made goes.
    let made = temporary_file(folder.path()).unwrap();
    let refused = lock_folder(folder.path()).unwrap_err().to_string();
    assert!(refused.contains("is being written by another command") && made.folder.path().exists(), "{refused}");
    let left = folder.path().join(".partial-left");
    std::fs::create_dir(&left).unwrap();
    std::fs::copy(made.folder.path().join("kinetostat_unfinished"), left.join("kinetostat_unfinished")).unwrap();
    drop(made);
    drop(lock_folder(folder.path()).unwrap());
    assert_eq!(std::fs::read_to_string(folder.path().join("a.csv")).unwrap(), "2");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}
