//! Pictures of quantities over a grid: slices and a view in 3-D, of values gathered point by point. A large grid is thinned.

use super::{Tolerance, quantity::Getter, setting::size_words};
use crate::{
    answer::point_words,
    figures::{Figure, Mark2, Mark3, Shading, SliceFigure, SlicePanel, VolumeFigure},
    files::words::{millimetres, signed, typographic},
    simulation::Scene,
    spatial::Grid,
};

/// A quantity that is drawn, of what is found at a point, a `P`.
pub struct Drawn<P> {
    /// File stem of its slices behind `slices_`.
    pub stem: &'static str,
    /// Title of its slices.
    pub title: String,
    /// Its label with its unit.
    pub label: String,
    /// Under what it is so, in the caption.
    pub under: String,
    /// Where a line is drawn.
    pub contour: Option<f64>,
    /// What the line is, behind the caption.
    pub line: String,
    /// Colours.
    pub shading: Shading,
    /// Its value.
    pub value: Box<Getter<P>>,
}

/// The pictures of a map.
pub struct GridMap<'a, P> {
    scene: &'a Scene,
    grid: &'a Grid,
    /// What is said where there is no value.
    pub missing: &'static str,
    /// Whether the grid is one of positions of P, where the named points of the machine are.
    pub has_points: bool,
    drawn: Vec<Drawn<P>>,
    /// Indices along each axis of the nodes of slices at the heights asked for.
    slices: [Vec<usize>; 3],
    /// The same of the picture in 3-D and of slices through an extreme.
    volume: [Vec<usize>; 3],
    /// Grid indices of all of these nodes, ascending.
    nodes: Vec<usize>,
    /// At each of them that was seen, the values of what is drawn.
    values: Vec<Vec<Option<f64>>>,
    /// Index of the next point.
    next: usize,
}

/// Most nodes drawn along an axis of a slice, and of the picture in 3-D.
const MOST_NODES: usize = 201;
const MOST_IN_3D: usize = 41;

impl<'a, P> GridMap<'a, P> {
    /// Of what is `drawn` over a `grid`, none of its points seen.
    pub fn new(scene: &'a Scene, grid: &'a Grid, slices_z: &[f64], drawn: Vec<Drawn<P>>) -> Self {
        let [nx, ny, _] = grid.counts();
        let slices = [thinned(nx, MOST_NODES), thinned(ny, MOST_NODES), planes(grid, slices_z)];
        let volume = grid.counts().map(|count| thinned(count, MOST_IN_3D));
        let mut nodes: Vec<usize> = product(&slices).chain(product(&volume)).map(|node| grid.index(node)).collect();
        nodes.sort_unstable();
        nodes.dedup();
        let (missing, has_points) = ("no solution", true);
        Self { scene, grid, missing, has_points, drawn, slices, volume, nodes, values: Vec::new(), next: 0 }
    }

    /// Takes the next point, in grid order.
    pub fn add(&mut self, point: &P) {
        if self.nodes.get(self.values.len()) == Some(&self.next) {
            self.values.push(self.drawn.iter().map(|drawn| (drawn.value)(point)).collect());
        }
        self.next += 1;
    }

    /// Whether what is drawn as number `k` has a value anywhere.
    pub fn has_values(&self, k: usize) -> bool {
        self.values.iter().any(|values| values[k].is_some())
    }

    fn value(&self, k: usize, node: [usize; 3]) -> Option<f64> {
        let place = self.nodes.binary_search(&self.grid.index(node)).ok()?;
        self.values.get(place)?[k]
    }

    /// Slices of each quantity at the heights asked for, by file stem.
    pub fn slices(&self) -> impl Iterator<Item = (String, Figure)> {
        self.drawn.iter().enumerate().map(|(k, drawn)| {
            let panels = self.slices[2].iter().map(|plane| self.panel(k, &self.slices, *plane, self.points_in(*plane)));
            let figure = SliceFigure {
                title: drawn.title.clone(),
                subtitle: self.caption(k, &self.slices[..2]) + &drawn.line,
                panels: panels.collect(),
                contour: drawn.contour,
                shading: drawn.shading,
                remark: match k == 0 && self.has_points {
                    true => point_words::points(&self.scene.machine),
                    false => String::new(),
                },
                ..self.empty(k)
            };
            (format!("slices_{}", drawn.stem), Figure::Slices(figure))
        })
    }

    /// The slices of number `k` through `ends`, each a value, where it is, and a word for it; without any, the lowest one.
    pub fn through(&self, k: usize, title: &str, ends: &[(f64, [f64; 3], &str)], line: Option<Tolerance>) -> Figure {
        let (planes, zs) = (&self.volume[2], &self.grid.axes[2]);
        let plane = |z: f64| {
            let gap = |&&k: &&usize| (zs[k] - z).abs();
            planes.iter().min_by(|a, b| gap(a).total_cmp(&gap(b))).copied()
        };
        let mut heights: Vec<usize> = ends.iter().filter_map(|(_, at, _)| plane(at[2])).collect();
        heights.dedup();
        if heights.is_empty() {
            heights.extend(planes.first());
        }
        let panel = |height: &usize| {
            let here = ends.iter().filter(|(_, at, _)| plane(at[2]) == Some(*height));
            let mark = |(value, [x, y, _], word): &(f64, [f64; 3], &str)| Mark2 {
                label: format!("{word} {}", millimetres(*value, 3)),
                x: *x,
                y: *y,
            };
            self.panel(k, &self.volume, *height, here.map(mark).collect())
        };
        Figure::Slices(SliceFigure {
            title: title.into(),
            subtitle: self.caption(k, &self.volume[..2]) + &line.map_or_else(String::new, Tolerance::line),
            panels: heights.iter().map(panel).collect(),
            contour: line.map(|Tolerance(tolerance)| tolerance),
            ..self.empty(k)
        })
    }

    /// Number `k` in 3-D, if the grid is no plane.
    pub fn in_3d(&self, k: usize, title: String) -> Option<Figure> {
        let coordinates = |i: usize| self.volume[i].iter().map(|&node| self.grid.axes[i][node]).collect();
        let points = self.scene.machine.points.iter().filter(|_| self.has_points);
        self.grid.counts().iter().all(|&count| count > 1).then(|| {
            Figure::Volume(VolumeFigure {
                title,
                subtitle: self.caption(k, &self.volume),
                axis_labels: ["x [mm]".into(), "y [mm]".into(), "z [mm]".into()],
                quantity: self.drawn[k].label.clone(),
                axes: [0, 1, 2].map(coordinates),
                values: product(&self.volume).map(|node| self.value(k, node)).collect(),
                marks: points.map(|p| Mark3 { label: p.name.clone(), position: p.position.into() }).collect(),
                range: None,
            })
        })
    }

    /// Slices of number `k` without any.
    fn empty(&self, k: usize) -> SliceFigure {
        SliceFigure {
            title: String::new(),
            subtitle: String::new(),
            x_label: "x [mm]".into(),
            y_label: "y [mm]".into(),
            quantity: self.drawn[k].label.clone(),
            panels: Vec::new(),
            range: None,
            contour: None,
            shading: Shading::Ordered,
            remark: String::new(),
            missing: self.missing.into(),
        }
    }

    fn panel(&self, k: usize, [columns, rows, _]: &[Vec<usize>; 3], plane: usize, marks: Vec<Mark2>) -> SlicePanel {
        let [xs, ys, zs] = &self.grid.axes;
        let nodes = rows.iter().flat_map(|&y| columns.iter().map(move |&x| [x, y, plane]));
        SlicePanel {
            title: typographic(&format!("z = {:.2} mm", zs[plane])),
            x: columns.iter().map(|&x| xs[x]).collect(),
            y: rows.iter().map(|&y| ys[y]).collect(),
            values: nodes.map(|node| self.value(k, node)).collect(),
            marks,
        }
    }

    /// The points of the machine that lie nearer to a plane than to its neighbours.
    fn points_in(&self, plane: usize) -> Vec<Mark2> {
        let zs = &self.grid.axes[2];
        let half_step = if zs.len() > 1 { 0.5 * (zs[1] - zs[0]) } else { f64::INFINITY };
        let points = self.scene.machine.points.iter().filter(|_| self.has_points);
        let here = points.filter(|p| (p.position.z - zs[plane]).abs() <= half_step);
        here.map(|p| Mark2 { label: p.name.clone(), x: p.position.x, y: p.position.y }).collect()
    }

    /// The caption of a picture that shows the nodes with these indices along the first axes.
    fn caption(&self, k: usize, nodes: &[Vec<usize>]) -> String {
        let mut text =
            format!("{}, {}, grid {}", self.scene.machine.short_title(), self.drawn[k].under, size_words(self.grid));
        if nodes.iter().zip(self.grid.counts()).any(|(drawn, count)| drawn.len() != count) {
            let drawn: Vec<String> = nodes.iter().map(|axis| axis.len().to_string()).collect();
            text += &format!(", {} nodes drawn", drawn.join(" × "));
        }
        signed(&text)
    }
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

/// Indices of the nodes drawn along an axis of `count` nodes: at most `most`, evenly spread, both ends included.
fn thinned(count: usize, most: usize) -> Vec<usize> {
    if count <= most {
        return (0..count).collect();
    }
    (0..most).map(|k| (k * (count - 1) + (most - 1) / 2) / (most - 1)).collect()
}

/// All combinations of the indices, x fastest.
fn product([x, y, z]: &[Vec<usize>; 3]) -> impl Iterator<Item = [usize; 3]> {
    z.iter().flat_map(move |&k| y.iter().flat_map(move |&j| x.iter().map(move |&i| [i, j, k])))
}
