//! Which pictures a map of turns gives: slices at the heights asked for, of the worst direction where there are several, and the places
//! in 3-D.

use super::summary::{Found, Report};
use crate::{
    answer::{
        Shown,
        grid_slices::{drawn, drawn_nodes, panels, thinned_words},
    },
    figures::{Figure, Shading, SliceFigure, SlicePanel, VolumeFigure},
    files::words::signed,
};

/// A quantity that is drawn: file stem, title, label with unit, colours, value.
type Quantity = (&'static str, &'static str, &'static str, Shading, fn(&Found<'_>) -> Option<f64>);

const QUANTITIES: [Quantity; 3] = [
    (
        "slices_best",
        "How far the tool moves, turned well about its axis",
        "deflection at the best turn [mm]",
        Shading::Ordered,
        |found| Some(found.best.deflection_mm),
    ),
    ("slices_turn", "How to turn the tool about its axis", "best turn [°]", Shading::Cyclic, |found| {
        Some(found.best.turn_deg.rem_euclid(360.0))
    }),
    (
        "slices_gain",
        "How much the turn counts",
        "deflection at the worst turn over the best",
        Shading::Ordered,
        |found| Some(found.gain()).filter(|gain| gain.is_finite()),
    ),
];

/// Most nodes along an axis of the picture in 3-D.
const MOST_NODES: usize = 41;

/// All pictures with their file stems.
pub(super) fn figures(report: &Report<'_>, shown: &Shown) -> Vec<(String, Figure)> {
    let each =
        QUANTITIES.iter().map(|quantity| (quantity.0.to_string(), Figure::Slices(slices(report, shown, quantity))));
    let answer = ("answer".to_string(), Figure::Slices(slices(report, shown, &QUANTITIES[0])));
    let mut figures: Vec<(String, Figure)> = std::iter::once(answer).chain(each).collect();
    if report.study.grid.counts().iter().all(|&n| n > 1) {
        figures.push(("turns_in_3d".into(), Figure::Volume(volume(report))));
    }
    figures
}

fn slices(report: &Report<'_>, shown: &Shown, (_, title, label, shading, value): &Quantity) -> SliceFigure {
    let study = report.study;
    let is_deflection = label.ends_with("[mm]");
    let at = |node: [usize; 3]| report.all_axes(study.grid.index(node)).and_then(|found| value(&found));
    SliceFigure {
        title: (*title).into(),
        subtitle: setting(report, &drawn_nodes(&study.grid, &shown.slices_z)[..2]),
        x_label: "x [mm]".into(),
        y_label: "y [mm]".into(),
        quantity: (*label).into(),
        panels: panels(&study.scene.machine, &study.grid, &shown.slices_z, &at)
            .into_iter()
            .map(|panel| SlicePanel { marks: Vec::new(), ..panel })
            .collect(),
        range: None,
        contour: study.scene.tolerance_mm.filter(|_| is_deflection),
        shading: *shading,
        remark: String::new(),
        missing: "no turn".into(),
    }
}

fn volume(report: &Report<'_>) -> VolumeFigure {
    let grid = &report.study.grid;
    let nodes = grid.counts().map(|count| drawn(count, MOST_NODES));
    let [x, y, z] = &nodes;
    let all = z.iter().flat_map(|&k| y.iter().flat_map(move |&j| x.iter().map(move |&i| [i, j, k])));
    let value = |node: [usize; 3]| report.all_axes(grid.index(node)).map(|found| found.best.deflection_mm);
    VolumeFigure {
        title: "The places, coloured by deflection at the best turn".into(),
        subtitle: setting(report, &nodes),
        axis_labels: ["x [mm]".into(), "y [mm]".into(), "z [mm]".into()],
        quantity: "deflection at the best turn [mm]".into(),
        axes: [0, 1, 2].map(|i| nodes[i].iter().map(|&k| grid.axes[i][k]).collect()),
        values: all.map(value).collect(),
        marks: Vec::new(),
        range: None,
    }
}

fn setting(report: &Report<'_>, drawn: &[Vec<usize>]) -> String {
    let study = report.study;
    let [nx, ny, nz] = study.grid.counts();
    let tool = match study.axes.len() {
        1 => format!("tool along {}", report.axis_name(0)),
        count => format!("worst of {count} directions of the tool"),
    };
    let force = &study.scene.force;
    signed(&format!(
        "{}, {tool}, force {} / {} / {} N (radial / tangential / axial), {} turns, grid {nx} × {ny} × {nz}{}",
        study.scene.machine.short_title(),
        force.radial,
        force.tangential,
        force.axial,
        study.turns(),
        thinned_words(&study.grid, drawn)
    ))
}
