//! Slices of a grid over the workspace.

use crate::{
    figures::{Mark2, SlicePanel},
    files::words::typographic,
    machine::Machine,
    spatial::Grid,
};

/// Grid planes nearest to the heights asked for, without repetition.
fn planes(grid: &Grid, slices_z: &[f64]) -> Vec<usize> {
    let heights = &grid.axes[2];
    let mut planes: Vec<usize> = Vec::new();
    for z in slices_z {
        let distance = |k: &usize| (heights[*k] - z).abs();
        let nearest = (0..heights.len()).min_by(|a, b| distance(a).total_cmp(&distance(b)));
        if let Some(plane) = nearest.filter(|plane| !planes.contains(plane)) {
            planes.push(plane);
        }
    }
    planes
}

/// Most nodes drawn along an axis; a finer grid is thinned for pictures.
const MOST_NODES: usize = 201;

/// Indices of the nodes drawn along an axis of `count` nodes: at most `most`, evenly spread, both ends included.
pub fn drawn(count: usize, most: usize) -> Vec<usize> {
    if count <= most {
        return (0..count).collect();
    }
    (0..most).map(|k| (k * (count - 1) + (most - 1) / 2) / (most - 1)).collect()
}

/// Indices along x, y and z of the nodes that slices at the heights `slices_z` (mm) show.
pub(crate) fn drawn_nodes(grid: &Grid, slices_z: &[f64]) -> [Vec<usize>; 3] {
    let [nx, ny, _] = grid.counts();
    [drawn(nx, MOST_NODES), drawn(ny, MOST_NODES), planes(grid, slices_z)]
}

/// What a subtitle says of a grid of which only the nodes with the indices `drawn` along the first axes are shown: empty if
/// all are.
pub(crate) fn thinned_words(grid: &Grid, drawn: &[Vec<usize>]) -> String {
    if drawn.iter().zip(grid.counts()).all(|(drawn, count)| drawn.len() == count) {
        return String::new();
    }
    let drawn: Vec<String> = drawn.iter().map(|axis| axis.len().to_string()).collect();
    format!(", {} nodes drawn", drawn.join(" × "))
}

/// The planes nearest to the heights `slices_z` (mm) of the values at the nodes, by their indices along x, y and z, with
/// the points of the machine that lie nearer to a plane than to its neighbours.
pub fn panels(
    machine: &Machine,
    grid: &Grid,
    slices_z: &[f64],
    value: &dyn Fn([usize; 3]) -> Option<f64>,
) -> Vec<SlicePanel> {
    let [xs, ys, zs] = &grid.axes;
    let half_step = if zs.len() > 1 { 0.5 * (zs[1] - zs[0]) } else { f64::INFINITY };
    let [columns, rows, planes] = drawn_nodes(grid, slices_z);
    let panel = |k: usize| {
        let in_plane = machine.points.iter().filter(|p| (p.position.z - zs[k]).abs() <= half_step);
        let nodes = rows.iter().flat_map(|&y| columns.iter().map(move |&x| [x, y, k]));
        SlicePanel {
            title: typographic(&format!("z = {:.2} mm", zs[k])),
            x: columns.iter().map(|&x| xs[x]).collect(),
            y: rows.iter().map(|&y| ys[y]).collect(),
            values: nodes.map(value).collect(),
            marks: in_plane.map(|p| Mark2 { label: p.name.clone(), x: p.position.x, y: p.position.y }).collect(),
        }
    };
    planes.into_iter().map(panel).collect()
}
