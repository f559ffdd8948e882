//! Figure of the workspace in 3-D: the faces of a box of values, seen from above, right and front.

use super::axis::{self, Axis, Spacing};
use super::colour_bar::{ColourBar, NO_SOLUTION, Scale};
use super::colours::{Colours, Shading};
use super::drawing::{Anchor, Drawing, Point, Rect, Stroke, Text};
use super::error::{FigureError, check_ascending, check_drawable, check_grid};
use super::field::{self, Picture};
use super::labels::{self, PlacedMark};
use super::projection::Projection;
use super::style::{self, BORDER, INK, Sizes, WHITE, outline};
use super::text::{self, Weight};

/// Direction of view: the eye stands at this azimuth from +x and elevation from the xy plane, in degrees.
const AZIMUTH: f64 = -52.0;
const ELEVATION: f64 = 27.0;
/// Highest projection of the box, in pixels.
const TALLEST: f64 = 1000.0;
/// Length of ticks, and their distance to the labels, in pixels.
const TICK: f64 = 12.0;
const GAP: f64 = 8.0;
const BAR_GAP: f64 = 44.0;
const BAR_HEIGHT: f64 = 620.0;
/// Note that explains dashed rings.
const HIDDEN_NOTE: &str = "dashed ring: not on a visible face; the dashed line leads straight up to the top plane";

const LEADER_RIM: Stroke = Stroke { colour: WHITE, width: 7.0, dash: &[] };
const LEADER: Stroke = Stroke { colour: INK, width: 3.0, dash: &[9.0, 11.0] };

/// A labelled point in space.
#[derive(Debug, Clone, PartialEq)]
pub struct SpaceMark {
    /// Text beside the ring.
    pub label: String,
    /// Coordinates in O, mm.
    pub position: [f64; 3],
}

/// A box of values, drawn at one scale of length on all axes, in cells as in [`super::SlicePanel`]. The faces at the largest x, the
/// smallest y and the largest z are visible. Marks elsewhere get a dashed ring and a dashed line straight up to the top plane.
#[derive(Debug, Clone, PartialEq)]
pub struct VolumeFigure {
    /// Question that the figure answers.
    pub title: String,
    /// Conditions of the computation.
    pub subtitle: String,
    /// Labels of the axes x, y and z, for example "x \[mm\]".
    pub axis_labels: [String; 3],
    /// Label of the colour bar, for example "worst tool deflection \[mm\]".
    pub quantity: String,
    /// Node coordinates along x, y and z, ascending, mm.
    pub axes: [Vec<f64>; 3],
    /// One value per node, x fastest, then y, then z; `None` where there is no solution (drawn hatched).
    pub values: Vec<Option<f64>>,
    /// Points marked with a ring.
    pub marks: Vec<SpaceMark>,
    /// Ends of the colour scale; `None` takes the smallest and largest of all values, hidden ones included.
    pub range: Option<(f64, f64)>,
}

impl VolumeFigure {
    /// Checks that nodes increase, values fill the grid, and every number can be drawn.
    fn check(&self) -> Result<(), FigureError> {
        for (nodes, label) in self.axes.iter().zip(&self.axis_labels) {
            check_ascending(nodes, || format!("volume, axis {label}"))?;
        }
        check_grid(&self.values, self.axes.iter().map(Vec::len).product(), || "volume".into())?;
        check_drawable(self.marks.iter().flat_map(|m| m.position), || "volume, marks".into())
    }

    /// Returns the cell edges along each axis, mm.
    fn edges(&self) -> [Vec<f64>; 3] {
        let [x, y, z] = &self.axes;
        field::edges([x, y, z])
    }

    /// Returns the value at the node with these indices along x, y and z; `None` where there is no solution.
    fn value(&self, [i, j, k]: [usize; 3]) -> Option<f64> {
        let [x, y, _] = &self.axes;
        self.values[(k * y.len() + j) * x.len() + i]
    }

    /// Returns the index of the last node along each axis.
    fn last_node(&self) -> [usize; 3] {
        [0, 1, 2].map(|axis| self.axes[axis].len() - 1)
    }
}

/// Lays the figure out, its faces in `colours`; `Err` when its data cannot be drawn.
pub(super) fn drawing(figure: &VolumeFigure, colours: Colours, sizes: Sizes) -> Result<Drawing, FigureError> {
    figure.check()?;
    let scale = Scale::new(figure.values.iter().copied().flatten(), figure.range, colours, Shading::Ordered)?;
    let bar = ColourBar {
        scale,
        quantity: &figure.quantity,
        missing: figure.values.iter().any(Option::is_none).then_some(NO_SOLUTION),
        size: sizes.body,
        tick_size: sizes.tick,
    };
    let (mut drawing, top) = style::page_with_heading(&figure.title, &figure.subtitle, sizes);
    let edges = figure.edges();
    let bar_width = bar.width(BAR_HEIGHT);
    let beside = if sizes.is_portrait() { 0.0 } else { bar_width + BAR_GAP };
    let view = View::fitted(figure, &edges, top, sizes.width - BORDER - beside, sizes);
    draw_faces(&mut drawing, figure, &edges, &view, scale);
    // The nine visible edges of the box.
    FACES.iter().for_each(|face| drawing.outline(&face.corners(&view), outline()));
    for axis in 0..3 {
        draw_axis(&mut drawing, &view, axis, &figure.axis_labels[axis]);
    }
    let any_hidden = draw_marks(&mut drawing, figure, &view);
    let mut bottom = if sizes.is_portrait() {
        let below = drawing.lowest() + sizes.body;
        bar.draw_across(&mut drawing, 2.0 * BORDER, below, sizes.width - 4.0 * BORDER)
    } else {
        let bar_top = (view.bounds.centre()[1] - BAR_HEIGHT / 2.0).max(top);
        bar.draw(&mut drawing, sizes.width - BORDER - bar_width, bar_top, BAR_HEIGHT);
        drawing.lowest()
    };
    if any_hidden {
        bottom = style::draw_paragraph(&mut drawing, HIDDEN_NOTE, bottom + sizes.body, sizes.body);
    }
    drawing.height = bottom + BORDER;
    Ok(drawing)
}

/// The box (mm), and where it stands on the page.
struct View {
    low: [f64; 3],
    high: [f64; 3],
    projection: Projection,
    /// Largest x on the page for axis labels.
    limit: f64,
    sizes: Sizes,
    /// Rectangle on the page around the projected box and marks.
    bounds: Rect,
}

impl View {
    /// Returns the projection that fits box and marks between `BORDER` and `limit`, below `top`, with room for the axis labels.
    fn fitted(figure: &VolumeFigure, edges: &[Vec<f64>; 3], top: f64, limit: f64, sizes: Sizes) -> Self {
        let low = [0, 1, 2].map(|axis: usize| edges[axis][0]);
        let high = [0, 1, 2].map(|axis: usize| edges[axis][edges[axis].len() - 1]);
        let mut view = Self {
            low,
            high,
            projection: Projection::new(AZIMUTH, ELEVATION),
            limit,
            sizes,
            bounds: Rect { x: 0.0, y: 0.0, width: 0.0, height: 0.0 },
        };
        let corners = (0..8).map(|k| view.corner([k & 1 != 0, k & 2 != 0, k & 4 != 0]));
        let [(x0, x1), (y0, y1)] = view.projection.ranges(corners.chain(figure.marks.iter().map(|mark| mark.position)));
        let numbers = Axis::vertical(low[2], high[2], Spacing::Linear, 0.5 * TALLEST, sizes.tick);
        let left = BORDER + axis::label_depth(sizes.body) + numbers.depth_beside(sizes.tick);
        let right = limit - sizes.tick * 2.0;
        let above = sizes.tick;
        let scale = ((right - left) / (x1 - x0)).min(TALLEST / (y1 - y0));
        let slack = (right - left - scale * (x1 - x0)) / 2.0;
        view.projection.scale = scale;
        view.projection.origin = [left + slack - scale * x0, top + above - scale * y0];
        view.bounds = Rect { x: left + slack, y: top + above, width: scale * (x1 - x0), height: scale * (y1 - y0) };
        view
    }

    /// Returns the corner of the box at the high end of the axes with `true`, at the low end of the others, mm.
    fn corner(&self, at_high: [bool; 3]) -> [f64; 3] {
        [0, 1, 2].map(|axis: usize| if at_high[axis] { self.high[axis] } else { self.low[axis] })
    }

    /// Projects a point (mm) onto the page.
    fn project(&self, point: [f64; 3]) -> Point {
        self.projection.project(point)
    }

    /// Returns whether a point lies on one of the three visible faces.
    fn is_visible(&self, point: [f64; 3]) -> bool {
        let near = |axis: usize, end: f64| (point[axis] - end).abs() <= 1e-9 * (self.high[axis] - self.low[axis]);
        let inside = (0..3).all(|axis| {
            (self.low[axis]..=self.high[axis]).contains(&point[axis])
                || near(axis, self.low[axis])
                || near(axis, self.high[axis])
        });
        inside && (near(0, self.high[0]) || near(1, self.low[1]) || near(2, self.high[2]))
    }
}

/// A visible face: the axes along its columns and rows of cells, and whether it lies at the high end of the third axis.
struct Face {
    columns: usize,
    rows: usize,
    at_high: bool,
}

impl Face {
    /// Returns its corners on the page, in turn from the low ends of both axes, along the columns first.
    fn corners(&self, view: &View) -> [Point; 4] {
        [(false, false), (true, false), (true, true), (false, true)].map(|(column, row)| {
            let mut at_high = [self.at_high; 3];
            at_high[self.columns] = column;
            at_high[self.rows] = row;
            view.project(view.corner(at_high))
        })
    }
}

const FACES: [Face; 3] = [
    Face { columns: 0, rows: 2, at_high: false },
    Face { columns: 1, rows: 2, at_high: true },
    Face { columns: 0, rows: 1, at_high: true },
];

/// Draws the cells of the three visible faces.
fn draw_faces(drawing: &mut Drawing, figure: &VolumeFigure, edges: &[Vec<f64>; 3], view: &View, scale: Option<Scale>) {
    for face in FACES {
        let [low, _, far, origin] = face.corners(view);
        let [across, down] = [far, low].map(|to| [to[0] - origin[0], to[1] - origin[1]]);
        let colour = |column, row| {
            let mut node = if face.at_high { figure.last_node() } else { [0; 3] };
            node[face.columns] = column;
            node[face.rows] = row;
            figure.value(node).zip(scale).map(|(value, scale)| scale.colour(value))
        };
        drawing.picture(Picture::new([origin, across, down], &edges[face.columns], &edges[face.rows], colour));
    }
}

/// Returns the projected edge of the box that carries the ticks of `axis`, from its low to its high end, and the direction of the ticks
/// on the page: x runs along the lower left edge, y along the lower right one, z up the left one.
fn tick_edge(view: &View, axis: usize) -> ([Point; 2], Point) {
    let (mut corner, outward) = match axis {
        0 => ([false, false, false], [-0.35, 0.94]),
        1 => ([true, false, false], [0.94, 0.35]),
        _ => ([false, false, false], [-1.0, 0.0]),
    };
    let from = view.project(view.corner(corner));
    corner[axis] = true;
    ([from, view.project(view.corner(corner))], outward)
}

/// Draws ticks, numbers and label of one axis.
fn draw_axis(drawing: &mut Drawing, view: &View, axis: usize, label: &str) {
    let ([[x0, y0], [x1, y1]], outward) = tick_edge(view, axis);
    let (low, high) = (view.low[axis], view.high[axis]);
    let span = [(x1 - x0).abs(), (y1 - y0).abs()];
    let scale = if axis == 2 {
        Axis::vertical(low, high, Spacing::Linear, span[1], view.sizes.tick)
    } else {
        Axis::slanted(low, high, span, view.sizes.tick)
    };
    for (value, number) in scale.ticks.values.iter().zip(&scale.ticks.labels) {
        let share = scale.fraction(*value);
        let start = [x0 + share * (x1 - x0), y0 + share * (y1 - y0)];
        let end = [start[0] + TICK * outward[0], start[1] + TICK * outward[1]];
        drawing.line(vec![start, end], axis::tick_stroke());
        draw_centred_text(drawing, number, view.sizes.tick, centre_beside(number, view.sizes.tick, end, outward));
    }
    let label = axis::label_with_power(label, scale.ticks.exponent);
    let middle = [(x0 + x1) / 2.0, (y0 + y1) / 2.0];
    if axis == 2 {
        let size = view.sizes.body;
        let x = middle[0] - scale.depth_beside(view.sizes.tick) - 0.6 * size - GAP;
        drawing.text(Text::new(label, size, [x, middle[1]], Anchor::Middle).upward());
    } else {
        let numbers = axis::label_width(&scale.ticks, view.sizes.tick);
        draw_slanted_label(drawing, view, axis, &label, middle, numbers);
    }
}

/// Draws the label of x or y: beside the numbers at the middle of its edge if the page is wide enough, else in a row below the box.
fn draw_slanted_label(drawing: &mut Drawing, view: &View, axis: usize, label: &str, middle: Point, numbers: f64) {
    let size = view.sizes.body;
    let half_width = text::width(label, size, Weight::Regular) / 2.0;
    let side = if axis == 0 { -1.0 } else { 1.0 };
    let start = [middle[0] + side * (TICK + 2.0 * GAP + 0.9 * numbers), middle[1] + TICK + 1.2 * view.sizes.tick];
    let mut centre = [start[0] + side * half_width, start[1] + 0.3 * view.sizes.tick];
    let (first, last) = (BORDER + half_width, view.limit - half_width);
    if centre[0] < first || centre[0] > last {
        let row = axis as f64 * 1.3 * view.sizes.body;
        centre = [centre[0].min(last).max(first), view.bounds.bottom() + 2.4 * view.sizes.tick + row];
    }
    draw_centred_text(drawing, label, size, centre);
}

/// Returns the centre of a text next to the point `at`, on the side that `outward` points to.
fn centre_beside(content: &str, size: f64, at: Point, outward: Point) -> Point {
    let half_width = text::width(content, size, Weight::Regular) / 2.0;
    let half_height = text::capital_height(size) / 2.0;
    let aside = outward[0].signum() * outward[0].abs().sqrt() * half_width + GAP * outward[0];
    [at[0] + aside, at[1] + (half_height + GAP) * outward[1]]
}

/// Draws a text centred on a point of the page.
fn draw_centred_text(drawing: &mut Drawing, content: &str, size: f64, centre: Point) {
    let at = [centre[0], centre[1] + text::capital_height(size) / 2.0];
    drawing.text(Text::new(content, size, at, Anchor::Middle));
}

/// Draws the marks; returns whether any of them is not on a visible face.
fn draw_marks(drawing: &mut Drawing, figure: &VolumeFigure, view: &View) -> bool {
    let mut placed = Vec::with_capacity(figure.marks.len());
    for mark in &figure.marks {
        let at = view.project(mark.position);
        let hidden = !view.is_visible(mark.position);
        if hidden {
            let [x, y, _] = mark.position;
            let foot = view.project([x, y, view.high[2]]);
            drawing.line(vec![foot, at], LEADER_RIM);
            drawing.line(vec![foot, at], LEADER);
            let cross = |dx: f64| vec![[foot[0] - dx, foot[1] - 5.0], [foot[0] + dx, foot[1] + 5.0]];
            drawing.line(cross(9.0), LEADER_RIM);
            drawing.line(cross(-9.0), LEADER_RIM);
            drawing.line(cross(9.0), outline());
            drawing.line(cross(-9.0), outline());
        }
        placed.push(PlacedMark { at, label: &mark.label, hidden });
    }
    labels::draw_marks(drawing, &placed, &[], view.bounds, view.sizes.tick);
    placed.iter().any(|mark| mark.hidden)
}
