//! Golden figures: small ones of each kind, byte for byte.

use std::{fs, path::Path};

use crate::support::{command::printed, golden::same, placement::short_placement};
use kinetostat::figures::{
    AgreementFigure, AgreementRow, Colours, Criterion, CurvePanel, Figure, Limit, LineFigure, LineSeries, Look,
    PanelCurve, PanelFigure, PlanField, PlanFigure, PlanShape, PlaneMark, Shading, SliceFigure, SlicePanel, SpaceMark,
    VolumeFigure,
};

fn nodes(count: u8) -> Vec<f64> {
    (0..count).map(|i| -50.0 + 25.0 * f64::from(i)).collect()
}

/// A value at each of `count` nodes, without one at the second.
fn field(count: u8) -> Vec<Option<f64>> {
    (0..count).map(|i| (i != 1).then(|| 0.125 * f64::from(i))).collect()
}

fn slices() -> Figure {
    let panel = SlicePanel {
        title: "z = 0 mm".into(),
        x: nodes(4),
        y: nodes(3),
        values: field(12),
        marks: vec![PlaneMark { label: "Q0".into(), x: 0.0, y: -25.0 }],
    };
    Figure::Slices(SliceFigure {
        title: "How far does the tool move?".into(),
        subtitle: "4 × 3 points, F < 215 N".into(),
        x_label: "x [mm]".into(),
        y_label: "y [mm]".into(),
        quantity: "deflection [mm]".into(),
        panels: vec![panel],
        range: Some((0.0, 1.0)),
        limit: Some(Limit::Most(0.5)),
        shading: Shading::Ordered,
        remark: String::new(),
        missing: "no solution".into(),
    })
}

fn volume() -> Figure {
    Figure::Volume(VolumeFigure {
        title: "The workspace".into(),
        subtitle: "3 × 3 × 2 points".into(),
        axis_labels: ["x [mm]", "y [mm]", "z [mm]"].map(String::from),
        quantity: "deflection [mm]".into(),
        axes: [nodes(3), nodes(3), nodes(2)],
        values: field(18),
        marks: vec![SpaceMark { label: "Q1".into(), position: [0.0, 0.0, -25.0] }],
        range: None,
    })
}

fn curve(factor: f64) -> Vec<(f64, f64)> {
    (1..6).map(|k| (f64::from(k), factor * f64::from(k * k))).collect()
}

fn lines() -> Figure {
    let series = |label: &str, factor, dashed| LineSeries {
        label: label.into(),
        points: curve(factor),
        dashed,
        band: Vec::new(),
    };
    Figure::Lines(LineFigure {
        title: "How the error grows".into(),
        subtitle: "doubly logarithmic".into(),
        x_label: "factor".into(),
        y_label: "superposition error [mm]".into(),
        series: vec![series("load", 0.001, false), series("both", 0.002, true)],
        equal_axes: false,
        log_x: true,
        log_y: true,
        closed_note: Some("errors drawn 20 times as large".into()),
    })
}

fn panels() -> Figure {
    let panel = |title: &str, factor| CurvePanel {
        title: title.into(),
        curves: vec![
            PanelCurve { pieces: vec![curve(factor)] },
            PanelCurve { pieces: vec![vec![(1.0, 1.0), (2.0, 1.0)], vec![(4.0, 1.0), (5.0, 2.0)]] },
        ],
    };
    Figure::Panels(PanelFigure {
        title: "The best and a poor place".into(),
        subtitle: "groove".into(),
        x_label: "x [mm]".into(),
        y_label: "y [mm]".into(),
        curves: vec![("wanted".into(), false), ("loaded".into(), true)],
        panels: vec![panel("best", 0.2), panel("poor", 0.5)],
        equal_axes: true,
        note: "errors drawn 20 times as large".into(),
    })
}

fn plan() -> Figure {
    let square = |look, label: &str, x: f64, y: f64| PlanShape {
        look,
        points: vec![(x, y), (x + 30.0, y), (x + 30.0, y + 20.0), (x, y + 20.0)],
        label: label.into(),
    };
    Figure::Plan(Box::new(PlanFigure {
        title: "Where the part stands".into(),
        subtitle: "seen along −z".into(),
        x_label: "x [mm]".into(),
        y_label: "y [mm]".into(),
        quantity: "deflection [mm]".into(),
        field: Some(PlanField { x: nodes(4), y: nodes(3), values: field(12), missing: "cannot be cut there".into() }),
        shapes: vec![
            square(Look::Ghost, "as drawn\n0.5 mm", -10.0, -10.0),
            square(Look::Obstacle, "clamp", -60.0, -60.0),
            square(Look::Part, "", 0.0, 0.0),
            square(Look::Room, "", 10.0, 5.0),
            PlanShape { look: Look::Path, points: vec![(5.0, 5.0), (25.0, 15.0)], label: String::new() },
        ],
        coloured: vec![vec![(-40.0, 30.0, 0.1), (-10.0, 40.0, 0.9)]],
        marks: vec![(15.0, 10.0, "best\n0.4 mm".into())],
        note: "room: orange".into(),
    }))
}

fn agreement() -> Figure {
    let row = |label: &str, criterion, difference, agrees| AgreementRow {
        label: label.into(),
        numbers: ["1.7", "1.71 mm"].map(String::from),
        criterion,
        difference,
        agrees,
    };
    Figure::Agreement(AgreementFigure {
        title: "2 of 4 numbers agree".into(),
        subtitle: "orthoglide".into(),
        numbers: ["quoted", "ours"].map(String::from),
        rows: vec![
            row("Q0: correction", Criterion::About, Some(0.3), true),
            row("Q1: correction", Criterion::AtLeast, Some(7.0), true),
            row("Q2: correction", Criterion::AtMost, Some(1.5), false),
            row("Q3: correction", Criterion::About, None, false),
        ],
    })
}

/// Smallest type size of a figure in points where it is set into a column of 85 mm.
fn smallest_type(svg: &str) -> f64 {
    let number = |text: &str| -> f64 { text.split([' ', ')', '"']).next().unwrap().parse().unwrap() };
    let (_, after) = svg.split_once("viewBox=\"0 0 ").unwrap();
    let column = 85.0 / 25.4 * 72.0;
    // Outlines of letters have 256 units to the type size.
    let sizes = svg.split(" scale(").skip(1).map(|rest| 256.0 * number(rest) * column / number(after));
    sizes.fold(f64::INFINITY, f64::min)
}

/// A small figure of each kind, with the name of its golden file.
fn small_figures() -> Vec<(&'static str, Figure)> {
    vec![
        ("slices_viridis", slices()),
        ("volume", volume()),
        ("lines", lines()),
        ("panels", panels()),
        ("plan", plan()),
        ("agreement", agreement()),
    ]
}

/// Whether figures of this kind are among the small ones: a new kind does not compile before this says so.
fn is_small(figure: &Figure) -> bool {
    match figure {
        Figure::Slices(_)
        | Figure::Volume(_)
        | Figure::Lines(_)
        | Figure::Panels(_)
        | Figure::Plan(_)
        | Figure::Agreement(_) => true,
        // Drawn of a machine, a part or a verdict: `figure_parts.rs`, `verdict_basis.rs` and the figures of studies hold them.
        Figure::Budget(_) | Figure::Pose(_) | Figure::Part(_) => false,
    }
}

#[test]
fn each_kind_is_once_among_the_small_figures() {
    let small = small_figures();
    assert!(small.iter().all(|(name, figure)| is_small(figure) && !name.is_empty()));
    let kinds: std::collections::HashSet<_> = small.iter().map(|(_, own)| std::mem::discriminant(own)).collect();
    assert_eq!(kinds.len(), small.len());
}

#[test]
fn texts_can_be_read_in_a_column() {
    for (_, figure) in small_figures() {
        let smallest = smallest_type(&figure.svg(Colours::Viridis).unwrap());
        assert!((7.0..12.0).contains(&smallest), "{smallest} pt in {}", figure.alternative_text());
    }
    for study in ["01_workspace_map", "03_placement_circle", "02_groove_50mm"] {
        let folder = tempfile::tempdir().unwrap();
        for (name, svg) in figures_of(study, folder.path()) {
            let smallest = smallest_type(&svg);
            assert!((7.0..12.0).contains(&smallest), "{study}, {name}: {smallest} pt");
        }
    }
}

/// 16 px is what phones take for text.
#[test]
fn texts_can_be_read_on_a_telephone() {
    for (_, figure) in small_figures() {
        let (svg, png) = figure.portrait(Colours::Viridis).unwrap();
        let pixels = smallest_type(&svg) / (85.0 / 25.4 * 72.0) * 375.0;
        assert!((15.9..20.0).contains(&pixels), "{pixels} px in {}", figure.alternative_text());
        assert_eq!(png[16..20], 1100_u32.to_be_bytes(), "{}", figure.alternative_text());
    }
}

/// The figures of a study, computed for few points: the answer comes first, and no two have one title.
fn figures_of(study: &str, out: &Path) -> Vec<(String, String)> {
    let coming_with = Path::new("studies").join(study);
    let (study_folder, size) = match study {
        "02_groove_50mm" => (coming_with, &["--points", "13"][..]),
        "03_placement_circle" => (short_placement(out), &[][..]),
        _ => (coming_with, &["--grid", "2"][..]),
    };
    let out = out.join("results");
    printed(&[&["run", study_folder.to_str().unwrap(), "--out", out.to_str().unwrap()], size].concat());
    let report: serde_json::Value = serde_json::from_slice(&fs::read(out.join("report.json")).unwrap()).unwrap();
    let notes = report["figures"].as_array().unwrap();
    assert_eq!(notes[0]["file"], "answer", "{study}");
    let named = |note: &serde_json::Value| {
        let file = note["file"].as_str().unwrap().to_string();
        let svg = fs::read_to_string(out.join(format!("{file}.svg"))).unwrap();
        (file, svg)
    };
    let figures: Vec<(String, String)> = notes.iter().map(named).collect();
    let mut titles: Vec<&str> = figures.iter().map(|(_, svg)| title(svg)).collect();
    titles.sort_unstable();
    assert!(titles.windows(2).all(|pair| pair[0] != pair[1]), "{study}: {titles:?}");
    figures
}

fn title(svg: &str) -> &str {
    svg.split_once("<title>").unwrap().1.split_once("</title>").unwrap().0
}

#[test]
fn figures_are_the_golden_ones() {
    let scales = [("cividis", Colours::Cividis), ("grey", Colours::Grey)];
    let scaled = scales.map(|(scale, colours)| (format!("slices_{scale}"), slices(), colours));
    let small = small_figures().into_iter().map(|(name, figure)| (name.to_owned(), figure, Colours::Viridis));
    for (name, figure, colours) in small.chain(scaled) {
        same(&format!("figures/{name}.svg"), &figure.svg(colours).unwrap());
    }
}
