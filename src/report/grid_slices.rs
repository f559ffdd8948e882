//! Slices of a grid over the workspace.

use crate::{
    machine::Machine,
    report::figures::{Mark2, SlicePanel},
    study::workspace_map::Grid,
};

/// With minus signs instead of hyphens, as on the axes.
pub fn typographic(text: &str) -> String {
    text.replace('-', "\u{2212}")
}

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

/// The planes nearest to the heights `slices_z` (mm) of `values`, in grid order, with the points of the machine that lie
/// nearer to a plane than to its neighbours.
pub fn panels(machine: &Machine, grid: &Grid, slices_z: &[f64], values: &[Option<f64>]) -> Vec<SlicePanel> {
    let [xs, ys, zs] = &grid.axes;
    let half_step = if zs.len() > 1 { 0.5 * (zs[1] - zs[0]) } else { f64::INFINITY };
    let panel = |k: usize| {
        let in_plane = machine.points.iter().filter(|p| (p.position.z - zs[k]).abs() <= half_step);
        SlicePanel {
            title: typographic(&format!("z = {:.2} mm", zs[k])),
            x: xs.clone(),
            y: ys.clone(),
            values: values[k * xs.len() * ys.len()..][..xs.len() * ys.len()].to_vec(),
            marks: in_plane.map(|p| Mark2 { label: p.name.clone(), x: p.position.x, y: p.position.y }).collect(),
        }
    };
    planes(grid, slices_z).into_iter().map(panel).collect()
}
