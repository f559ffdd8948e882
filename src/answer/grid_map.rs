//! Figures of quantities over a grid: slices and a view in 3-D, of values added point by point. A large grid is thinned.

use super::{Tolerance, quantity::Getter, setting::size_text};
use crate::{
    answer::point_text,
    figures::{Figure, Limit, PlaneMark, Shading, SliceFigure, SlicePanel, SpaceMark, VolumeFigure},
    files::words::{millimetres, typographic, with_minus_signs},
    simulation::LoadCase,
    spatial::Grid,
};

/// A quantity drawn over a grid, computed from the result `P` at each point.
pub struct MapLayer<P> {
    /// File stem of its slices, after `slices_`.
    pub stem: &'static str,
    /// Title of its slices.
    pub title: String,
    /// Label of the quantity, with its unit.
    pub label: String,
    /// Conditions under which it holds, for the caption.
    pub setting: String,
    /// What its values are held to.
    pub limit: Option<Limit>,
    /// Words about that, behind the caption.
    pub of_limit: String,
    /// Colour scale.
    pub shading: Shading,
    /// Computes the value at a point.
    pub value: Box<Getter<P>>,
}

/// Values over a grid, of which figures are drawn.
pub struct GridMap<'a, P> {
    load_case: &'a LoadCase,
    grid: &'a Grid,
    /// Legend of points without a value.
    pub missing: &'static str,
    /// Whether the grid is of positions of P, so that named points of the machine are marked.
    pub has_points: bool,
    drawn: Vec<MapLayer<P>>,
    /// Indices along each axis of the nodes drawn in slices at the heights of the study.
    slices: [Vec<usize>; 3],
    /// Indices along each axis of the nodes drawn in 3-D and in slices through an extreme.
    volume: [Vec<usize>; 3],
    /// Grid indices of all nodes that are drawn, ascending.
    nodes: Vec<usize>,
    /// Values of all layers at each of these nodes, as far as points were added.
    values: Vec<Vec<Option<f64>>>,
    /// Grid index of the next point.
    next: usize,
}

/// Most nodes drawn along an axis of a slice, and of the picture in 3-D.
const MAX_NODES: usize = 201;
const MAX_IN_3D: usize = 41;

impl<'a, P> GridMap<'a, P> {
    /// Starts a map of these layers without points; slices are at the heights `slices_z`, mm.
    pub fn new(load_case: &'a LoadCase, grid: &'a Grid, slices_z: &[f64], drawn: Vec<MapLayer<P>>) -> Self {
        let [nx, ny, _] = grid.counts();
        let slices = [thinned_indices(nx, MAX_NODES), thinned_indices(ny, MAX_NODES), nearest_planes(grid, slices_z)];
        let volume = grid.counts().map(|count| thinned_indices(count, MAX_IN_3D));
        let mut nodes: Vec<usize> = nodes_of(&slices).chain(nodes_of(&volume)).map(|node| grid.index(node)).collect();
        nodes.sort_unstable();
        nodes.dedup();
        let (missing, has_points) = ("no solution", true);
        Self { load_case, grid, missing, has_points, drawn, slices, volume, nodes, values: Vec::new(), next: 0 }
    }

    /// Adds the result at the next point, in grid order.
    pub fn add(&mut self, point: &P) {
        if self.nodes.get(self.values.len()) == Some(&self.next) {
            self.values.push(self.drawn.iter().map(|drawn| (drawn.value)(point)).collect());
        }
        self.next += 1;
    }

    /// Returns whether layer `k` has a value anywhere.
    pub fn has_values(&self, k: usize) -> bool {
        self.values.iter().any(|values| values[k].is_some())
    }

    /// Returns the value of layer `k` at a node; `None` where there is none.
    fn value_at(&self, k: usize, node: [usize; 3]) -> Option<f64> {
        let drawn_index = self.nodes.binary_search(&self.grid.index(node)).ok()?;
        self.values.get(drawn_index)?[k]
    }

    /// Draws slices of each layer at the heights of the study; yields file stem and figure of each layer.
    pub fn slices(&self) -> impl Iterator<Item = (String, Figure)> {
        self.drawn.iter().enumerate().map(|(k, drawn)| {
            let panels = self.slices[2].iter().map(|plane| self.panel(k, &self.slices, *plane, self.points_on(*plane)));
            let figure = SliceFigure {
                title: drawn.title.clone(),
                subtitle: self.subtitle(k, &self.slices[..2]) + &drawn.of_limit,
                panels: panels.collect(),
                limit: drawn.limit,
                shading: drawn.shading,
                remark: match k == 0 && self.has_points {
                    true => point_text::named_points_text(&self.load_case.machine),
                    false => String::new(),
                },
                ..self.empty_slices(k)
            };
            (format!("slices_{}", drawn.stem), Figure::Slices(figure))
        })
    }

    /// Draws slices of layer `k` through `ends`, each a value, its position, mm, and a word for it; without any, the lowest slice.
    pub fn slices_at(
        &self,
        k: usize,
        title: &str,
        ends: &[(f64, [f64; 3], &str)],
        tolerance: Option<Tolerance>,
    ) -> Figure {
        let (planes, zs) = (&self.volume[2], &self.grid.axes[2]);
        let plane = |z: f64| {
            let distance = |&&k: &&usize| (zs[k] - z).abs();
            planes.iter().min_by(|a, b| distance(a).total_cmp(&distance(b))).copied()
        };
        let mut heights: Vec<usize> = ends.iter().filter_map(|(_, at, _)| plane(at[2])).collect();
        heights.dedup();
        if heights.is_empty() {
            heights.extend(planes.first());
        }
        let panel = |height: &usize| {
            let on_plane = ends.iter().filter(|(_, at, _)| plane(at[2]) == Some(*height));
            let mark = |(value, [x, y, _], word): &(f64, [f64; 3], &str)| PlaneMark {
                label: format!("{word} {}", millimetres(*value, 3)),
                x: *x,
                y: *y,
            };
            self.panel(k, &self.volume, *height, on_plane.map(mark).collect())
        };
        Figure::Slices(SliceFigure {
            title: title.into(),
            subtitle: self.subtitle(k, &self.volume[..2]) + &tolerance.map_or_else(String::new, Tolerance::hatched),
            panels: heights.iter().map(panel).collect(),
            limit: tolerance.map(|Tolerance(most)| Limit::Most(most)),
            ..self.empty_slices(k)
        })
    }

    /// Draws layer `k` in 3-D; `None` if the grid is a plane.
    pub fn in_3d(&self, k: usize, title: String) -> Option<Figure> {
        let coordinates = |i: usize| self.volume[i].iter().map(|&node| self.grid.axes[i][node]).collect();
        let points = self.load_case.machine.points.iter().filter(|_| self.has_points);
        self.grid.counts().iter().all(|&count| count > 1).then(|| {
            Figure::Volume(VolumeFigure {
                title,
                subtitle: self.subtitle(k, &self.volume),
                axis_labels: ["x", "y", "z"].map(|axis| self.axis_label(axis)),
                quantity: self.drawn[k].label.clone(),
                axes: [0, 1, 2].map(coordinates),
                values: nodes_of(&self.volume).map(|node| self.value_at(k, node)).collect(),
                marks: points.map(|p| SpaceMark { label: p.name.clone(), position: p.position.into() }).collect(),
                range: None,
            })
        })
    }

    /// Returns the label of an axis, which says whose position it is: where named points of the machine are drawn, that of P.
    fn axis_label(&self, axis: &str) -> String {
        format!("{axis} of {} [mm]", if self.has_points { "P" } else { "the tool tip" })
    }

    /// Returns a figure of slices of layer `k` without panels.
    fn empty_slices(&self, k: usize) -> SliceFigure {
        SliceFigure {
            title: String::new(),
            subtitle: String::new(),
            x_label: self.axis_label("x"),
            y_label: self.axis_label("y"),
            quantity: self.drawn[k].label.clone(),
            panels: Vec::new(),
            range: None,
            limit: None,
            shading: Shading::Ordered,
            remark: String::new(),
            missing: self.missing.into(),
        }
    }

    /// Returns the slice of layer `k` at a grid plane.
    fn panel(&self, k: usize, [columns, rows, _]: &[Vec<usize>; 3], plane: usize, marks: Vec<PlaneMark>) -> SlicePanel {
        let [xs, ys, zs] = &self.grid.axes;
        let nodes = rows.iter().flat_map(|&y| columns.iter().map(move |&x| [x, y, plane]));
        SlicePanel {
            title: typographic(&format!("z = {:.2} mm", zs[plane])),
            x: columns.iter().map(|&x| xs[x]).collect(),
            y: rows.iter().map(|&y| ys[y]).collect(),
            values: nodes.map(|node| self.value_at(k, node)).collect(),
            marks,
        }
    }

    /// Returns marks of the named points of the machine that are nearest to a grid plane.
    fn points_on(&self, plane: usize) -> Vec<PlaneMark> {
        let zs = &self.grid.axes[2];
        let half_step = if zs.len() > 1 { 0.5 * (zs[1] - zs[0]) } else { f64::INFINITY };
        let points = self.load_case.machine.points.iter().filter(|_| self.has_points);
        let near = points.filter(|p| (p.position.z - zs[plane]).abs() <= half_step);
        near.map(|p| PlaneMark { label: p.name.clone(), x: p.position.x, y: p.position.y }).collect()
    }

    /// Returns the subtitle of a figure of layer `k`: machine, setting, size of the grid, and how many `nodes` (indices along each axis) are drawn if
    /// not all.
    fn subtitle(&self, k: usize, nodes: &[Vec<usize>]) -> String {
        let mut text =
            format!("{}, {}, grid {}", self.load_case.machine.name, self.drawn[k].setting, size_text(self.grid));
        if nodes.iter().zip(self.grid.counts()).any(|(drawn, count)| drawn.len() != count) {
            let drawn: Vec<String> = nodes.iter().map(|axis| axis.len().to_string()).collect();
            text += &format!(", {} nodes drawn", drawn.join(" × "));
        }
        with_minus_signs(&text)
    }
}

/// Returns the indices of the grid planes nearest to the heights `slices_z`, mm, each once.
fn nearest_planes(grid: &Grid, slices_z: &[f64]) -> Vec<usize> {
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

/// Returns the indices of at most `most` of `count` nodes, evenly spread, both ends included.
pub(crate) fn thinned_indices(count: usize, most: usize) -> Vec<usize> {
    if count <= most {
        return (0..count).collect();
    }
    (0..most).map(|k| (k * (count - 1) + (most - 1) / 2) / (most - 1)).collect()
}

/// Returns all combinations of the indices along x, y and z, x fastest.
fn nodes_of([x, y, z]: &[Vec<usize>; 3]) -> impl Iterator<Item = [usize; 3]> {
    z.iter().flat_map(move |&k| y.iter().flat_map(move |&j| x.iter().map(move |&i| [i, j, k])))
}
