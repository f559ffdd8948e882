//! What pages are made of: numbers of views and tables read back, who is best where, addresses, reasons and commands.

use std::{collections::BTreeMap, fs, io::Read as _, path::Path};

use base64::{Engine, engine::general_purpose::STANDARD};
use brotli_decompressor::Decompressor;
use kinetostat::page::{
    Better, Column, Explorer, Group, GroupValue, Packed, PointCommand, Precision, Quantity, Shape, TableNote,
    count_reasons,
    dataset::{Dataset, thin_axes},
    explore_page, href, point_commands, relative_display,
    table::{Table, TableView, format_number},
    winners::{NodeWinner, Winners, difference_text, percent},
};
use serde_json::{Value, json};
use sha2::{Digest, Sha256};

fn explorer(shape: Shape) -> Explorer {
    let coordinates = match shape {
        Shape::Grid => vec![Column::new("x", "x", "mm"), Column::new("y", "y", "mm")],
        Shape::Curve | Shape::Names => vec![Column::new("x", "x", "mm")],
    };
    let value = |value: &str| GroupValue { cells: vec![value.into()], label: value.into() };
    Explorer {
        title: "test".into(),
        table: "t.csv".into(),
        shape,
        coordinates,
        group: Some(Group { columns: vec!["g".into()], label: "g".into(), values: vec![value("b"), value("a")] }),
        quantities: vec![Quantity::new(["v", "w"], "largest", "mm", Better::Smaller)],
        marks: Vec::new(),
    }
}

const TABLE: &str =
    "x,y,g,status,reason,v,w\n0,0,a,solved,,1,-2\n0,0,b,solved,,3,1\n1,0,a,lost,far,,\n1,0,b,solved,,5,-6\n";

fn read(shape: Shape, most: usize) -> Dataset {
    read_table(TABLE, shape, most)
}

fn read_table(table: &str, shape: Shape, most: usize) -> Dataset {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("t.csv");
    std::fs::write(&file, table).unwrap();
    Dataset::read(&explorer(shape), &Table::open(&file).unwrap(), most).unwrap()
}

#[test]
fn rows_find_their_nodes_and_groups() {
    let data = read(Shape::Grid, 1000);
    assert_eq!(data.axes, [vec![0.0, 1.0], vec![0.0]]);
    assert_eq!(data.values[0][0], [3.0, 6.0]);
    assert_eq!(data.values[0][1][0], 2.0);
    assert!(data.values[0][1][1].is_nan());
    assert_eq!((data.flags[1].as_slice(), data.notes.as_slice()), (&[(1, 0)][..], &["lost: far".to_string()][..]));
    assert_eq!(read(Shape::Curve, 1000).axes, [vec![0.0, 1.0]]);
    assert_eq!(read(Shape::Names, 1000).names, ["0", "1"]);
}

#[test]
fn a_coordinate_of_minus_zero_is_that_of_zero() {
    let data = read_table(&TABLE.replace("0,0,b", "-0,-0.0,b"), Shape::Grid, 1000);
    assert_eq!((&data.axes, &data.values[0][0]), (&vec![vec![0.0, 1.0], vec![0.0]], &vec![3.0, 6.0]));
}

#[test]
fn only_nodes_of_both_are_in_common() {
    for shape in [Shape::Grid, Shape::Curve, Shape::Names] {
        let all = read(shape, 1000);
        let mut other = all.clone();
        other.axes.first_mut().into_iter().for_each(|axis| axis[0] = 7.0);
        other.names.first_mut().into_iter().for_each(|name| *name = "other".into());
        other.axes.first_mut().into_iter().for_each(|axis| axis.sort_by(f64::total_cmp));
        let part = all.restricted_to(&other);
        assert_eq!(part.node_count(), 1, "{shape:?}");
        assert_eq!(part.values[0][0], [6.0], "{shape:?}");
        assert_eq!(part.flags[1], [(0, 0)], "{shape:?}");
        other.axes.first_mut().into_iter().for_each(|axis| axis.truncate(0));
        other.names.clear();
        assert_eq!(all.restricted_to(&other).node_count(), 0, "{shape:?}");
    }
}

#[test]
fn a_large_grid_is_thinned_with_its_ends_kept() {
    let axis: Vec<f64> = (0..101).map(f64::from).collect();
    let axes = thin_axes(&[axis.clone(), axis.clone(), vec![5.0]], 500);
    assert_eq!((axes[0].len(), axes[1].len(), axes[2].len()), (22, 22, 1));
    for axis in &axes[..2] {
        assert_eq!((axis[0], axis[axis.len() - 1]), (0.0, 100.0));
        assert!(axis.windows(2).all(|pair| pair[0] < pair[1]));
    }
    let whole = [axis];
    assert_eq!(thin_axes(&whole, 101), whole);
}

#[test]
fn numbers_keep_five_digits() {
    for (value, shown) in [
        (0.0, "0"),
        (-0.0, "0"),
        (-73.65, "\u{2212}73.650"),
        (1.123456789, "1.1235"),
        (0.00012345678, "0.00012346"),
        (1.5e-13, "1.500e\u{2212}13"),
        (123456.78, "123457"),
        (-10.0, "\u{2212}10"),
        (361.0, "361"),
        (f64::NAN, "–"),
    ] {
        assert_eq!(format_number(value), shown);
    }
}

#[test]
fn the_largest_rows_come_first_and_the_rest_is_counted() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("t.csv");
    let rows: String = (0..200).map(|k| format!("{k},{}\n", (k * 37) % 200)).collect();
    std::fs::write(&file, format!("k,v\n{rows}")).unwrap();
    let view =
        TableView::new(&Table::open(&file).unwrap(), &TableNote::ranked("t.csv", "", "v"), "t.csv".into()).unwrap();
    assert_eq!((view.total, view.rows.len()), (200, 60));
    assert_eq!(view.rows[0][1].text, "199");
    assert_eq!(view.numeric, [true, true]);
    let fault = TableView::new(&Table::open(&file).unwrap(), &TableNote::ranked("t.csv", "", "w"), String::new());
    assert!(fault.unwrap_err().to_string().contains("there is no column \"w\""));
}

#[test]
fn any_column_is_sorted_over_all_rows() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("t.csv");
    let rows: String =
        (0..500).map(|k| format!("{k},{},{}\n", (k * 37) % 500, if k == 400 { "" } else { "x" })).collect();
    std::fs::write(&file, format!("k,v,w\n{rows}")).unwrap();
    let note = TableNote::ranked("t.csv", "", "v");
    let view = TableView::new(&Table::open(&file).unwrap(), &note, "t.csv".into()).unwrap();
    let found: Value = serde_json::from_str(&view.ranking).unwrap();
    assert_eq!(found["total"], 500);
    let column = |order: &str, column: usize| -> Vec<String> {
        let indices = found[order][column].as_array().unwrap().iter();
        indices.map(|i| found["rows"][i.as_u64().unwrap() as usize][column].as_str().unwrap().into()).collect()
    };
    let expected: Vec<String> = (0..20).map(|k| (499 - k).to_string()).collect();
    assert_eq!(column("largest", 1), expected);
    assert_eq!(column("smallest", 0), (0..20).map(|k| k.to_string()).collect::<Vec<_>>());
    assert!(column("smallest", 2).iter().all(|cell| cell == "x"));
}

fn part(values: Vec<f64>, flagged: &[usize]) -> Dataset {
    Dataset {
        axes: vec![(0..values.len()).map(|k| k as f64).collect()],
        names: Vec::new(),
        flags: vec![flagged.iter().map(|node| (*node, 0)).collect()],
        values: vec![vec![values]],
        notes: vec!["lost".into()],
        thinned_from: None,
    }
}

#[test]
fn rounding_and_what_is_not_solved_have_no_winner() {
    let a = part(vec![1.0, 2.0, 2.8e-17, 1.0, 1.0, f64::NAN], &[]);
    let b = part(vec![2.0, 1.5, 5.7e-14, 1.0, 9.0, 1.0], &[4]);
    let parts = [&a, &b];
    let winners = Winners::new(&parts, 0, 0, Better::Smaller, 1e-7).unwrap();
    let best = |who, lead| NodeWinner::Best { who, lead };
    assert_eq!(
        winners.at,
        [best(0, 0.5), best(1, 0.25), NodeWinner::Same, NodeWinner::Same, NodeWinner::Nothing, NodeWinner::Nothing]
    );
    assert_eq!((winners.compared_count(), winners.win_share(0), winners.same_share()), (4, 0.25, 0.5));
    assert_eq!((winners.largest_lead_node(1), winners.typical_lead(0)), (Some(1), Some(0.5)));
    let larger = Winners::new(&parts, 0, 0, Better::Larger, 1e-7).unwrap();
    assert_eq!(larger.at[..2], [best(1, 1.0), best(0, 0.5 / 1.5)]);
    assert_eq!(Winners::new(&parts, 0, 0, Better::Neither, 0.0), None);
    // A name twice in one result.
    let twice = part(vec![0.5, 2.0, 3.0], &[2]);
    let winners = Winners::new(&[&twice, &part(vec![1.0, 1.0], &[])], 0, 0, Better::Smaller, 1e-7).unwrap();
    assert_eq!(winners.at, [best(0, 0.5), best(1, 0.5)]);
}

#[test]
fn rounding_is_the_same_and_differences_are_said_in_percent() {
    let floor = 1.7e-7;
    for (value, reference, expected) in [
        (2.8e-17, 5.7e-14, "the same"),
        (0.76, 1.0, "24 % less"),
        (1.03, 1.0, "3 % more"),
        (3.2, 1.0, "3.2 times as much"),
        (0.0, 1.0, "nothing left"),
        (0.001, 1.0, "1/1000 of it"),
        (1.0, 0.0, "–"),
        (1.0, -2.0, "–"),
        (0.997, 1.0, "0.3 % less"),
    ] {
        assert_eq!(difference_text(value, reference, floor), expected);
    }
    let shown = [0.0, 0.0004, 0.93, 0.9999, 1.0].map(percent);
    assert_eq!(shown, ["0 %", "less than 0.1 %", "93 %", "99.9 %", "100 %"]);
}

#[test]
fn codes_are_within_half_a_step_of_the_numbers() {
    let values: Vec<f64> = (0..1000).map(|k| (f64::from(k) * 0.37).sin() * 1.7).chain([f64::NAN]).collect();
    let packed = Packed::new(&values, Precision::Steps).unwrap();
    let bytes = STANDARD.decode(&packed.codes).unwrap();
    for (value, pair) in values.iter().zip(bytes.chunks(2)) {
        let code = u16::from_le_bytes([pair[0], pair[1]]);
        assert_eq!(code == 65535, value.is_nan());
        let back = packed.low + f64::from(code) / 65534.0 * (packed.high - packed.low);
        assert!(value.is_nan() || (back - value).abs() <= 0.51 * (packed.high - packed.low) / 65534.0);
    }
    assert_eq!(Packed::new(&[f64::NAN], Precision::Steps), None);
    assert_eq!(Packed::new(&[2.0, 2.0], Precision::Steps).unwrap().codes, "AAAAAA==");
}

#[test]
fn single_precision_keeps_small_numbers_beside_large_ones() {
    let values = [1.76, 9.8e-10, 4.9e-14, f64::NAN];
    let packed = Packed::new(&values, Precision::for_numbers(values.len())).unwrap();
    assert_eq!((packed.bits, packed.low, packed.high), (32, 4.9e-14, 1.76));
    let bytes = STANDARD.decode(&packed.codes).unwrap();
    for (value, four) in values.iter().zip(bytes.chunks(4)) {
        let back = f64::from(f32::from_le_bytes([four[0], four[1], four[2], four[3]]));
        assert!((back.is_nan() && value.is_nan()) || (back / value - 1.0).abs() < 1e-7, "{value}: {back}");
    }
    assert_eq!(Precision::for_numbers(900_001), Precision::Steps);
}

/// The commands of a map for all sources and for errors alone, and what they leave out.
fn told(phi: Option<usize>, keys: &BTreeMap<(String, String), String>) -> ([Option<PointCommand>; 2], String) {
    let sources = ["all", "geometry"].map(|source| GroupValue { cells: vec![source.into()], label: source.into() });
    let group = Group { columns: vec!["source".into()], label: "source".into(), values: sources.into() };
    let view = Explorer { group: Some(group), ..explorer(Shape::Grid) };
    let (commands, left) = point_commands(&view, phi, keys);
    (commands.try_into().unwrap(), left)
}

#[test]
fn a_point_is_asked_for_with_force_and_errors_of_its_source() {
    let keys: BTreeMap<(String, String), String> = [
        ("study", "machine", "my machine.toml"),
        ("process", "force.path_frame.radial_force_N", "215.0"),
        ("process", "force.path_frame.tangential_force_N", "-10.0"),
        ("process", "force.path_frame.axial_force_N", "-25.0"),
        ("process", "force.path_frame.law", "paper_eq17"),
        ("process", "chain_error.x.chain", "x"),
        ("process", "chain_error.x.turn_about_drive_axis_deg", "1.0"),
        ("process", "compensate.target", "tool_tip"),
        ("process", "tool.tip_mm", "[0, 0, 150]"),
    ]
    .map(|(part, key, value)| ((part.into(), key.into()), value.into()))
    .into();
    let ([Some(all), Some(errors)], left) = told(Some(8), &keys) else { panic!("both are commands") };
    assert_eq!(
        all.text,
        "kinetostat point --machine 'my machine.toml' --position {position} --phi {phi} --force 215.0,-10.0,-25.0 \
         --law paper_eq17 --set x.turn=1.0"
    );
    assert_eq!(all.phi, Some(8));
    assert!(errors.text.ends_with("{position} --wrench 0,0,0,0,0,0 --set x.turn=1.0") && errors.phi.is_none());
    for (target, flag) in [("platform_point", " --platform"), ("full_pose", " --full-pose")] {
        let mut other = keys.clone();
        other.insert(("process".into(), "compensate.target".into()), target.into());
        let ([Some(all), _], _) = told(Some(8), &other) else { panic!("a command") };
        assert!(all.text.ends_with(&format!("--set x.turn=1.0{flag}")), "{}", all.text);
    }
    assert_eq!(told(None, &keys).0[0], None);
    assert_eq!(
        left,
        "The command leaves out of the process: tool; where these act, its numbers differ from those above. Run the command in the folder of the study."
    );
}

/// The library that draws charts, as it is kept.
fn charts() -> String {
    let mut text = String::new();
    let compressed: &[u8] = include_bytes!("../../src/page/assets/plotly/plotly-kinetostat.min.js.br");
    Decompressor::new(compressed, 1 << 16).read_to_string(&mut text).unwrap();
    text
}

#[test]
fn the_charting_library_is_the_pinned_one() {
    let readme = include_str!("../../src/page/assets/plotly/README.md");
    let hash: String = Sha256::digest(charts().as_bytes()).iter().map(|byte| format!("{byte:02x}")).collect();
    assert!(readme.contains(&hash), "assets/plotly/README.md does not name {hash}");
}

#[test]
fn texts_are_escaped_and_visible_and_scripts_are_left() {
    let page = explore_page("<\u{202e}>", "", json!("</script><!--"), None).unwrap();
    assert!(page.contains("<title>&lt;\\u{202e}&gt;</title>") && !page.contains('\u{202e}'));
    assert!(page.contains(include_str!("../../src/page/assets/explore.js")));
    // JSON cannot end its script.
    assert!(page.contains(">\"\\u003c/script>\\u003c!--\"</script>"));
}

#[test]
fn scripts_and_styles_cannot_end_their_elements() {
    let assets = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/page/assets");
    let mut seen = 0;
    for file in fs::read_dir(assets).unwrap().map(|entry| entry.unwrap().path()) {
        let end = match file.extension().and_then(|extension| extension.to_str()) {
            Some("js") => "</script",
            Some("css") => "</style",
            _ => continue,
        };
        assert!(!fs::read_to_string(&file).unwrap().to_ascii_lowercase().contains(end), "{}", file.display());
        seen += 1;
    }
    assert!(seen >= 20, "{seen} scripts and styles");
    assert!(!charts().to_ascii_lowercase().contains("</script"));
}

#[test]
fn reasons_that_differ_in_numbers_are_one() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("t.csv");
    std::fs::write(&file, "status,reason\nsolved,\nlost,gap 1.5 mm\nlost,gap 20 mm\nbent,x\n").unwrap();
    let mut reasons = Vec::new();
    count_reasons("t.csv", &Table::open(&file).unwrap(), &mut reasons).unwrap();
    let found: Vec<_> = reasons.iter().map(|r| (r.reason.as_str(), r.rows)).collect();
    assert_eq!(found, [("gap 1.5 mm", 2), ("x", 1)]);
    let table = "status,reason,correction_status,correction_reason\nlost,gap,lost,gap\nsolved,,slow,late\n";
    std::fs::write(&file, table).unwrap();
    reasons.clear();
    count_reasons("t.csv", &Table::open(&file).unwrap(), &mut reasons).unwrap();
    let found: Vec<_> = reasons.iter().map(|r| (r.status.as_str(), r.reason.as_str(), r.rows)).collect();
    assert_eq!(found, [("lost", "gap", 1), ("slow", "late", 1)]);
}

#[test]
fn addresses_are_relative_to_the_page() {
    for (page, file, address) in [
        ("results/a/report.html", "results/a/map.csv", "map.csv"),
        ("comparison.html", "results/a b/map.csv", "results/a%20b/map.csv"),
        ("/tmp/x/page.html", "/tmp/y/map.csv", "../y/map.csv"),
    ] {
        assert_eq!(href(Path::new(page), Path::new(file)), address);
    }
    assert_eq!(relative_display(Path::new("/x/page.html"), Path::new("/x/a b")), "a b");
    assert_eq!(relative_display(Path::new("/x/page.html"), Path::new("/x")), ".");
}

/// A table whose row has no end is refused when the row is longer than any is, before the memory is full.
#[test]
fn a_row_without_end_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    for (name, begin) in [("header.csv", "x"), ("row.csv", "x,v\n1,2\n3"), ("quoted.csv", "x,v\n1,\"\n\n")] {
        let file = folder.path().join(name);
        std::fs::write(&file, begin).unwrap();
        // A file with a hole of 5 GB.
        std::fs::OpenOptions::new().append(true).open(&file).unwrap().set_len(5 << 30).unwrap();
        let view = |table: &Table| TableView::new(table, &TableNote::new(name, ""), String::new()).map(|_| ());
        let error = Table::open(&file).and_then(|table| view(&table)).unwrap_err().to_string();
        assert!(error.contains(name) && error.contains("has a row longer than 16 MiB"), "{error}");
    }
}

/// A word of any length is broken where the next letter does not fit.
#[test]
fn a_long_word_is_broken_at_once() {
    use kinetostat::figures::text::{Weight, width, wrap};
    let word: String = (0..20_000).map(|k| ['A', 'V', 'i', 'W', 'o'][k * k % 5]).collect();
    let begun = std::time::Instant::now();
    let lines = wrap(&word, 12.0, Weight::Regular, 300.0);
    assert!(begun.elapsed().as_secs() < 5);
    assert_eq!(lines.concat(), word);
    for pair in lines.windows(2) {
        let longer = format!("{}{}", pair[0], pair[1].chars().next().unwrap());
        let [own, longer] = [&pair[0], &longer].map(|line| width(line, 12.0, Weight::Regular));
        assert!(own <= 300.0 && longer > 300.0, "{own} {longer}");
    }
}
