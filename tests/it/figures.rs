//! Figures are drawn, or refused, as they should be.

use kinetostat::figures::{
    Colours, Figure, FigureError, LineFigure, LineSeries, PlaneMark, Shading, SliceFigure, SlicePanel, SpaceMark,
    VolumeFigure,
};

fn panel(nodes: usize, value: impl Fn(usize) -> Option<f64>) -> SlicePanel {
    let axis: Vec<f64> = (0..nodes).map(|i| -73.5 + 10.0 * i as f64).collect();
    SlicePanel {
        title: "z = 0 mm".into(),
        x: axis.clone(),
        y: axis,
        values: (0..nodes * nodes).map(value).collect(),
        marks: vec![PlaneMark { label: "Q0".into(), x: 0.0, y: 0.0 }],
    }
}

fn slices(panels: Vec<SlicePanel>) -> SliceFigure {
    SliceFigure {
        title: "Where does the tool deflect most?".into(),
        subtitle: "100 N < F".into(),
        x_label: "x [mm]".into(),
        y_label: "y [mm]".into(),
        quantity: "deflection [mm]".into(),
        panels,
        range: None,
        limit: None,
        shading: Shading::Ordered,
        remark: String::new(),
        missing: "no solution".into(),
    }
}

fn volume(nodes: usize, value: impl Fn(usize) -> Option<f64>) -> VolumeFigure {
    let axis: Vec<f64> = (0..nodes).map(|i| i as f64).collect();
    VolumeFigure {
        title: "Volume".into(),
        subtitle: String::new(),
        axis_labels: ["x [mm]", "y [mm]", "z [mm]"].map(String::from),
        quantity: "deflection [mm]".into(),
        axes: [axis.clone(), axis.clone(), axis],
        values: (0..nodes.pow(3)).map(value).collect(),
        marks: vec![SpaceMark { label: "Q9".into(), position: [0.1, 0.2, 0.3] }],
        range: None,
    }
}

fn lines(points: Vec<(f64, f64)>) -> LineFigure {
    LineFigure {
        title: "Lines".into(),
        subtitle: "setting".into(),
        x_label: "step [mm]".into(),
        y_label: "error [mm]".into(),
        series: vec![LineSeries { label: "measured".into(), points, dashed: false, band: Vec::new() }],
        equal_axes: false,
        log_x: false,
        log_y: false,
        closed_note: Some("errors amplified 20x".into()),
    }
}

fn size(png: &[u8]) -> (u32, u32) {
    let image = image::load_from_memory(png).expect("decodes");
    (image.width(), image.height())
}

#[test]
fn svg_keeps_the_words_of_labels() {
    let svg = Figure::Slices(slices(vec![panel(3, |i| Some(i as f64))])).svg(Colours::Viridis).unwrap();
    for label in ["Where does", "100 N &lt; F", "x [mm]", "y [mm]", "deflection [mm]", "z = 0 mm", "\"Q0\""] {
        assert!(svg.contains(label), "{label}");
    }
    assert!(!svg.contains("no solution"));
    let svg = Figure::Volume(volume(3, |i| (i > 0).then_some(i as f64))).svg(Colours::Viridis).unwrap();
    for label in ["z [mm]", "no solution", "dashed ring", "\"Q9\""] {
        assert!(svg.contains(label), "{label}");
    }
    let svg = Figure::Lines(lines(vec![(0.0, 1.0), (1.0, 2.0)])).svg(Colours::Viridis).unwrap();
    for label in ["measured", "errors amplified 20x", "error [mm]"] {
        assert!(svg.contains(label), "{label}");
    }
}

#[test]
fn png_is_1600_wide_and_the_same_each_time() {
    let figures = [
        Figure::Slices(slices(vec![panel(3, |i| Some(i as f64)); 3])),
        Figure::Volume(volume(3, |i| Some(i as f64))),
        Figure::Lines(lines(vec![(0.0, 1.0), (1.0, 2.0)])),
    ];
    for figure in figures {
        let png = figure.png(Colours::Viridis).unwrap();
        let (width, height) = size(&png);
        assert_eq!(width, 1600);
        assert!((400..2000).contains(&height), "{height}");
        assert_eq!(png, figure.png(Colours::Viridis).unwrap());
        assert_eq!(figure.svg(Colours::Viridis).unwrap(), figure.svg(Colours::Viridis).unwrap());
    }
}

#[test]
fn six_fine_maps_stay_small() {
    let wave = |i: usize| Some((i as f64 * 0.013).sin());
    let svg = Figure::Slices(slices(vec![panel(41, wave); 6])).svg(Colours::Viridis).unwrap();
    assert!(svg.len() < 300_000, "{}", svg.len());
}

#[test]
fn degenerate_fields_are_drawn() {
    let mut long = panel(1, |_| Some(1.0));
    long.x = (0..50).map(f64::from).collect();
    long.values = vec![Some(1e-7); 50];
    let mut far = panel(3, |_| Some(2.0));
    far.marks[0].x = 1e6;
    let mut fine = panel(41, |i| (i % 7 > 0).then_some(i as f64));
    fine.marks[0].y = -1e6;
    let long_quantity = SliceFigure { quantity: "very long quantity ".repeat(100), ..slices(vec![fine.clone(); 3]) };
    let cases = [
        slices(vec![fine]),
        long_quantity,
        slices(vec![panel(1, |_| Some(3.0))]),
        slices(vec![panel(4, |_| Some(0.0))]),
        slices(vec![panel(4, |_| None)]),
        slices(vec![panel(2, |i| Some(1e80 * i as f64))]),
        slices(vec![long]),
        slices(vec![far, panel(2, |_| None)]),
    ];
    for figure in cases {
        Figure::Slices(figure).png(Colours::Viridis).unwrap();
    }
    for nodes in [1, 2] {
        Figure::Volume(volume(nodes, |_| None)).png(Colours::Viridis).unwrap();
        Figure::Volume(volume(nodes, |_| Some(-1.0))).png(Colours::Viridis).unwrap();
    }
    Figure::Lines(lines(vec![(5.0, 5.0)])).png(Colours::Viridis).unwrap();
    Figure::Lines(LineFigure { equal_axes: true, ..lines(vec![(0.0, 0.0), (1e9, 1e-9)]) })
        .png(Colours::Viridis)
        .unwrap();
    Figure::Lines(LineFigure { log_x: true, log_y: true, ..lines(vec![(1e-90, 1e90), (1.0, 1.0)]) })
        .png(Colours::Viridis)
        .unwrap();
}

#[test]
fn values_beyond_the_range_are_drawn_with_the_end_colours() {
    let figure = SliceFigure { range: Some((1.0, 2.0)), ..slices(vec![panel(3, |i| Some(i as f64))]) };
    Figure::Slices(figure).png(Colours::Viridis).unwrap();
}

#[test]
fn wrong_data_are_named() {
    let message = |figure: Figure| figure.svg(Colours::Viridis).unwrap_err().to_string();
    assert_eq!(message(Figure::Slices(slices(vec![]))), "slice figure: nothing to draw");
    let seven = slices(vec![panel(2, |_| Some(1.0)); 7]);
    assert_eq!(message(Figure::Slices(seven)), "7 panels: at most 6 fit in one figure");
    let mut short = panel(2, |_| Some(1.0));
    short.values.pop();
    assert_eq!(
        message(Figure::Slices(slices(vec![short]))),
        "panel \"z = 0 mm\", values: 3 values for a grid of 4 nodes"
    );
    let mut unsorted = panel(2, |_| Some(1.0));
    unsorted.x.reverse();
    assert_eq!(
        message(Figure::Slices(slices(vec![unsorted]))),
        "panel \"z = 0 mm\", x: coordinates must increase, but -73.5 follows -63.5"
    );
    assert_eq!(message(Figure::Volume(volume(2, |_| Some(f64::NAN)))), "volume: NaN cannot be drawn");
    let reversed = VolumeFigure { range: Some((2.0, 1.0)), ..volume(2, |_| Some(1.0)) };
    assert_eq!(message(Figure::Volume(reversed)), "colour range 2 to 1: the first must be below the second");
    assert_eq!(message(Figure::Lines(lines(vec![]))), "line figure: nothing to draw");
    let log = LineFigure { log_x: true, ..lines(vec![(0.0, 1.0)]) };
    assert_eq!(message(Figure::Lines(log)), "series \"measured\": 0 has no place on a logarithmic axis");
    let both = LineFigure { log_x: true, equal_axes: true, ..lines(vec![(1.0, 1.0)]) };
    assert_eq!(Figure::Lines(both).png(Colours::Viridis), Err(FigureError::EqualAxesWithLog));
}

#[test]
fn the_alternative_names_axes_curves_and_ranges() {
    let series = |label: &str, points: Vec<(f64, f64)>| LineSeries {
        label: label.into(),
        points,
        dashed: false,
        band: Vec::new(),
    };
    let figure = LineFigure {
        title: "Errors".into(),
        subtitle: "orthoglide".into(),
        x_label: "path length [mm]".into(),
        y_label: "|Δt| [mm]".into(),
        series: vec![series("both", vec![(0.0, 0.123456), (1.0, -2.0)]), series("none", vec![])],
        equal_axes: false,
        log_x: false,
        log_y: false,
        closed_note: Some("amplified".into()),
    };
    let figure = Figure::Lines(figure);
    assert_eq!(figure.caption(), "");
    let expected = "Curves of |Δt| [mm] over path length [mm]: both (from \u{2212}2.000 to 0.1235). amplified.";
    assert_eq!(figure.alternative_text(), expected);
}
