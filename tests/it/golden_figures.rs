//! Golden figures: small ones of each kind, byte for byte.

use crate::support::golden::same;
use kinetostat::report::figures::{
    Colours, CurvePanel, Figure, LineFigure, LineSeries, Mark2, Mark3, PanelCurve, PanelFigure, Shading, SliceFigure,
    SlicePanel, VolumeFigure,
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
        marks: vec![Mark2 { label: "Q0".into(), x: 0.0, y: -25.0 }],
    };
    Figure::Slices(SliceFigure {
        title: "How far does the tool move?".into(),
        subtitle: "4 × 3 points, F < 215 N".into(),
        x_label: "x [mm]".into(),
        y_label: "y [mm]".into(),
        quantity: "deflection [mm]".into(),
        panels: vec![panel],
        range: Some((0.0, 1.0)),
        contour: Some(0.5),
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
        marks: vec![Mark3 { label: "Q1".into(), position: [0.0, 0.0, -25.0] }],
        range: None,
    })
}

fn curve(factor: f64) -> Vec<(f64, f64)> {
    (1..6).map(|k| (f64::from(k), factor * f64::from(k * k))).collect()
}

fn lines() -> Figure {
    let series = |label: &str, factor, dashed| LineSeries { label: label.into(), points: curve(factor), dashed };
    Figure::Lines(LineFigure {
        title: "How the error grows".into(),
        subtitle: "doubly logarithmic".into(),
        x_label: "factor".into(),
        y_label: "departure [mm]".into(),
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

#[test]
fn figures_are_the_golden_ones() {
    for (name, figure, colours) in [
        ("slices_viridis", slices(), Colours::Viridis),
        ("slices_cividis", slices(), Colours::Cividis),
        ("slices_grey", slices(), Colours::Grey),
        ("volume", volume(), Colours::Viridis),
        ("lines", lines(), Colours::Viridis),
        ("panels", panels(), Colours::Viridis),
    ] {
        same(&format!("figures/{name}.svg"), &figure.svg(colours).unwrap());
    }
}
