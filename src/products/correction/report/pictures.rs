//! What is left over the box, as maps: without correction, with the table, with exact corrections.

use super::Report;
use crate::{
    figures::{Figure, Shading, SliceFigure, SlicePanel},
    files::words::typographic,
    products::correction::ResidualPoint,
    simulation::ROUNDING_MM,
};

/// Most planes of a figure.
const PLANES: usize = 3;
const AXES: [&str; 3] = ["x", "y", "z"];

/// The maps: with the table first.
pub(super) fn figures(report: &Report<'_>) -> Vec<(String, Figure)> {
    let Some(plane) = Plane::of(report) else { return Vec::new() };
    let titles = [
        "What is left without correction",
        "What the table leaves",
        "What exact corrections leave",
        "What a table for each joint leaves",
    ];
    let ways = report.residuals.first().map_or(0, |point| point.left_mm.len());
    let map = |way: usize| Figure::Slices(slices(report, &plane, way, titles[way]));
    let table = ("answer".to_string(), map(TABLE));
    let all = (0..ways).map(|way| (format!("slices_error_{}", ResidualPoint::WAYS[way]), map(way)));
    std::iter::once(table).chain(all).collect()
}

/// Places of the table and of exact corrections among the ways to correct.
const TABLE: usize = 1;
const EXACT: usize = 2;

/// The colour scale of what the table and exact corrections leave is one, from none on.
fn range(report: &Report<'_>, way: usize) -> Option<(f64, f64)> {
    let left = report.residuals.iter().map(|point| point.left_mm[TABLE]);
    [TABLE, EXACT].contains(&way).then(|| (0.0, left.fold(report.question.tolerance_mm, f64::max)))
}

/// Axes across, up and through the maps.
struct Plane {
    axes: [usize; 3],
}

impl Plane {
    /// `None` where the box has no area.
    fn of(report: &Report<'_>) -> Option<Self> {
        let mut axes: Vec<usize> = report.question.axes().collect();
        if axes.len() < 2 {
            return None;
        }
        axes.extend((0..3).filter(|axis| !report.question.axes().any(|own| own == *axis)));
        Some(Self { axes: [axes[0], axes[1], axes[2]] })
    }
}

fn slices(report: &Report<'_>, plane: &Plane, way: usize, title: &str) -> SliceFigure {
    let [across, up, through] = plane.axes;
    let grid = report.grid;
    let value = |i: usize, j: usize, k: usize| {
        let mut node = [0; 3];
        (node[across], node[up], node[through]) = (i, j, k);
        let left = report.residuals[grid.index(node)].left_mm[way];
        // Rounding is no pattern.
        Some(if left <= ROUNDING_MM { 0.0 } else { left })
    };
    let count = grid.axes[through].len();
    let mut planes: Vec<usize> = (0..PLANES).map(|k| k * (count - 1) / (PLANES - 1)).collect();
    planes.dedup();
    let panel = |&k: &usize| SlicePanel {
        title: typographic(&format!("{} = {:.2} mm", AXES[through], grid.axes[through][k])),
        x: grid.axes[across].clone(),
        y: grid.axes[up].clone(),
        values: (0..grid.axes[up].len())
            .flat_map(|j| (0..grid.axes[across].len()).map(move |i| (i, j)))
            .map(|(i, j)| value(i, j, k))
            .collect(),
        marks: Vec::new(),
    };
    SliceFigure {
        title: title.into(),
        subtitle: format!(
            "{}, forces of {} N along each axis and none, table of {} nodes",
            report.question.machine.short_title(),
            report.force(),
            report.size()
        ),
        x_label: format!("{} [mm]", AXES[across]),
        y_label: format!("{} [mm]", AXES[up]),
        quantity: "largest error of the tool [mm]".into(),
        panels: planes.iter().map(panel).collect(),
        range: range(report, way),
        contour: (way == TABLE).then_some(report.question.tolerance_mm),
        shading: Shading::Ordered,
        remark: String::new(),
        missing: "no solution".into(),
    }
}
