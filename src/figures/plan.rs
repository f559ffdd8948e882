//! Plan: outlines of a part, its path and obstacles, seen along an axis, optionally over a colour map.

use super::axis::{self, Axis, Plot, Spacing};
use super::colour_bar::{ColourBar, Scale};
use super::colours::{Colours, Shading};
use super::drawing::{Anchor, Drawing, Point, Rect, Rgb, Stroke, Text};
use super::error::{FigureError, check_ascending, check_drawable, check_grid};
use super::field::{self, Picture};
use super::labels::{Occupied, Spot, rect_around};
use super::legend::{self, Sample};
use super::shapes::hatching_lines;
use super::style::{self, BORDER, GRID, HATCH, INK, MUTED, Sizes, WHITE};
use super::text::{self, Weight};

/// Highest plot, and shortest side of one, in pixels.
const TALLEST: f64 = 1150.0;
const SHORTEST: f64 = 420.0;
/// Share of the range left blank on each side.
const MARGIN: f64 = 0.05;
const BAR_GAP: f64 = 34.0;
/// Distance of the hatching lines over obstacles, in pixels.
const PITCH: f64 = 17.0;
/// Radius of a mark in pixels.
const MARK: f64 = 13.0;
/// Half the side of the square around a cross.
const CROSS: f64 = 9.0;
/// Number of different colours along a line coloured by value.
const LEVELS: f64 = 32.0;

/// Border and fill of the part at the recommended place.
pub(super) const PART: [Rgb; 2] = [[11, 79, 138], [219, 232, 245]];
pub(super) const ROOM: [Rgb; 2] = [[184, 84, 0], [253, 226, 200]];
pub(super) const OBSTACLE: Rgb = [192, 57, 43];
pub(super) const NEAREST: Stroke = Stroke { colour: [108, 52, 131], width: 7.0, dash: &[] };

/// Meaning of a shape of a plan, which decides how it is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Look {
    /// The part: a filled area with a strong border.
    Part,
    /// Space around the part's place: a smaller filled area in a colour of its own.
    Room,
    /// Something for comparison: a dashed border.
    Ghost,
    /// Another place: a small cross at a point.
    Place,
    /// An obstacle: a hatched area.
    Obstacle,
    /// A body that stands: its border.
    Body,
    /// Where bodies come nearest: a strong line between points of both.
    Nearest,
    /// The tool's path on the part: a line in the part's colour.
    Path,
    /// The target path that actual ones are compared with: a thin dark line.
    TargetPath,
    /// The tool's path without compensation.
    Before,
    /// The tool's path with compensation.
    After,
}

impl Look {
    /// Returns the stroke of lines; `None` for areas.
    fn stroke(self) -> Option<Stroke> {
        match self {
            Look::Path => Some(Stroke { colour: PART[0], width: 3.5, dash: &[] }),
            Look::Nearest => Some(NEAREST),
            Look::TargetPath => Some(Stroke { colour: INK, width: 3.5, dash: &[] }),
            Look::Before => Some(legend::BEFORE),
            Look::After => Some(legend::AFTER),
            Look::Part | Look::Room | Look::Ghost | Look::Place | Look::Obstacle | Look::Body => None,
        }
    }
}

/// A polygon or a line of a plan.
#[derive(Debug, Clone, PartialEq)]
pub struct PlanShape {
    /// What it stands for, which decides how it is drawn.
    pub look: Look,
    /// Points (x, y) of a line, or corners of a polygon in turn; a polygon that is filled or hatched must be convex.
    pub points: Vec<(f64, f64)>,
    /// Text beside it; empty for none.
    pub label: String,
}

/// A colour map under the shapes of a plan.
#[derive(Debug, Clone, PartialEq)]
pub struct PlanField {
    /// Node coordinates along the horizontal axis, ascending.
    pub x: Vec<f64>,
    /// Node coordinates along the vertical axis, ascending.
    pub y: Vec<f64>,
    /// Values in rows, y outer, x inner; cells with `None` are hatched.
    pub values: Vec<Option<f64>>,
    /// Meaning of a hatched cell.
    pub missing: String,
}

/// Shapes over two axes of equal scale.
#[derive(Debug, Clone, PartialEq)]
pub struct PlanFigure {
    /// What is shown.
    pub title: String,
    /// Conditions of the computation.
    pub subtitle: String,
    /// Label of the horizontal axis, for example "x \[mm\]".
    pub x_label: String,
    /// Label of the vertical axis, for example "y \[mm\]".
    pub y_label: String,
    /// Quantity that the colours show, for example "error \[mm\]"; empty without a map and coloured lines.
    pub quantity: String,
    /// Faint colour map under the shapes.
    pub field: Option<PlanField>,
    /// Shapes in drawing order.
    pub shapes: Vec<PlanShape>,
    /// Pieces of a line coloured by value, as points (x, y, value).
    pub coloured: Vec<Vec<(f64, f64, f64)>>,
    /// Labelled points (x, y, label).
    pub marks: Vec<(f64, f64, String)>,
    /// Remark a reader must not miss.
    pub note: String,
}

impl PlanFigure {
    /// Checks that there is something to draw, and that every value can be drawn.
    fn check(&self) -> Result<(), FigureError> {
        if self.shapes.iter().all(|shape| shape.points.is_empty()) && self.coloured.iter().all(Vec::is_empty) {
            return Err(FigureError::Empty { what: "plan".into() });
        }
        let shapes = self.shapes.iter().flat_map(|shape| &shape.points).flat_map(|p| [p.0, p.1]);
        let coloured = self.coloured.iter().flatten().flat_map(|p| [p.0, p.1, p.2]);
        let marks = self.marks.iter().flat_map(|mark| [mark.0, mark.1]);
        check_drawable(shapes.chain(coloured).chain(marks), || "plan".into())?;
        self.field.as_ref().map_or(Ok(()), |field| {
            check_ascending(&field.x, || "plan, x".into())?;
            check_ascending(&field.y, || "plan, y".into())?;
            check_grid(&field.values, field.x.len() * field.y.len(), || "plan".into())
        })
    }

    /// Returns the colour scale of the map, or else of the coloured lines; `None` without values.
    fn scale(&self, colours: Colours) -> Result<Option<Scale>, FigureError> {
        match &self.field {
            Some(field) => Scale::new(field.values.iter().copied().flatten(), None, colours, Shading::Faint),
            None => Scale::new(self.coloured.iter().flatten().map(|p| p.2), None, colours, Shading::Ordered),
        }
    }

    /// Returns the ranges of both axes: all shapes, marks, lines and the map, with a margin.
    fn extents(&self) -> [(f64, f64); 2] {
        let shapes = self.shapes.iter().flat_map(|shape| shape.points.iter().copied());
        let coloured = self.coloured.iter().flatten().map(|p| (p.0, p.1));
        let marks = self.marks.iter().map(|mark| (mark.0, mark.1));
        let mut all: Vec<(f64, f64)> = shapes.chain(coloured).chain(marks).collect();
        if let Some(field) = &self.field {
            let [x, y] = field::edges([&field.x, &field.y]);
            all.extend([(x[0], y[0]), (x[x.len() - 1], y[y.len() - 1])]);
        }
        [axis::range(all.iter().map(|p| p.0), MARGIN), axis::range(all.iter().map(|p| p.1), MARGIN)]
    }
}

/// Lays the figure out, its map in `colours`; `Err` when its data cannot be drawn.
pub(super) fn drawing(figure: &PlanFigure, colours: Colours, sizes: Sizes) -> Result<Drawing, FigureError> {
    figure.check()?;
    let scale = figure.scale(colours)?;
    let missing = figure.field.as_ref().filter(|field| field.values.iter().any(Option::is_none));
    let bar = ColourBar {
        scale,
        quantity: &figure.quantity,
        missing: missing.map(|field| field.missing.as_str()),
        size: sizes.body,
        tick_size: sizes.tick,
    };
    let (mut drawing, top) = style::page_with_heading(&figure.title, &figure.subtitle, sizes);
    let has_bar = scale.is_some() && !sizes.is_portrait();
    let beside = if has_bar { bar.width(0.7 * TALLEST) + BAR_GAP } else { 0.0 };
    let plot = plot(figure, top + 0.2 * sizes.body, beside, sizes);
    if let Some((field, scale)) = figure.field.as_ref().zip(scale) {
        let [x, y] = field::edges([&field.x, &field.y]);
        let colour =
            |column: usize, row: usize| field.values[row * field.x.len() + column].map(|value| scale.colour(value));
        drawing.picture(Picture::new(plot.cell_rect(&x, &y).frame(), &x, &y, colour));
    } else {
        plot.draw_grid(&mut drawing, Stroke { colour: GRID, width: 1.5, dash: &[] });
    }
    let mut occupied = Occupied::default();
    for shape in &figure.shapes {
        draw_shape(&mut drawing, &plot, shape, &mut occupied);
    }
    for piece in &figure.coloured {
        draw_coloured(&mut drawing, &plot, piece, scale, &mut occupied);
    }
    plot.draw_frame(&mut drawing);
    plot.draw_x_axis(&mut drawing, &figure.x_label, sizes.body, sizes.tick);
    plot.draw_y_axis(&mut drawing, &figure.y_label, sizes.body, sizes.tick);
    draw_labels(&mut drawing, &plot, figure, occupied, sizes);
    let height = plot.rect.height.clamp(SHORTEST, 0.7 * TALLEST);
    if has_bar {
        bar.draw(&mut drawing, plot.rect.right() + BAR_GAP, plot.rect.y, height);
    }
    let mut bottom = plot.rect.bottom() + axis::depth_below(sizes.tick) + axis::label_depth(sizes.body);
    if scale.is_some() && !has_bar {
        bottom = bar.draw_across(&mut drawing, plot.rect.x, bottom + 0.6 * sizes.body, plot.rect.width);
    }
    bottom = bottom.max(plot.rect.y + height);
    let mut samples = legend_samples(figure);
    if sizes.is_portrait() && figure.shapes.iter().any(|shape| shape.look == Look::Place) {
        samples.push((
            Box::new(|drawing: &mut Drawing, [x, y]: Point| draw_cross(drawing, [x + 0.5 * legend::WIDTH, y])),
            "other places",
        ));
    }
    if !samples.is_empty() {
        bottom = legend::draw(&mut drawing, samples, sizes.tick, bottom + 1.6 * sizes.body);
    }
    drawing.height = style::draw_note(&mut drawing, &figure.note, bottom, sizes.body) + BORDER;
    Ok(drawing)
}

/// Returns the legend entries of the lines, where the plan shows paths before or after compensation; otherwise none.
fn legend_samples(figure: &PlanFigure) -> Vec<Sample<'_>> {
    let has = |look: Look| figure.shapes.iter().any(|shape| shape.look == look);
    if !has(Look::Before) && !has(Look::After) {
        return Vec::new();
    }
    let words = [
        (Look::Path, "path wanted"),
        (Look::TargetPath, "path wanted"),
        (Look::Before, legend::BEFORE_WORDS),
        (Look::After, legend::AFTER_WORDS),
    ];
    let sample = |(look, words): (Look, &'static str)| Some((legend::line_sample(look.stroke()?) as _, words));
    words.into_iter().filter(|(look, _)| has(*look)).filter_map(sample).collect()
}

/// Returns the plot with its axes, its upper side at `top`, leaving `beside` pixels at its right.
fn plot(figure: &PlanFigure, top: f64, beside: f64, sizes: Sizes) -> Plot {
    let [mut x, mut y] = figure.extents();
    let numbers = Axis::vertical(y.0, y.1, Spacing::Linear, TALLEST, sizes.tick).depth_beside(sizes.tick);
    let left = BORDER + axis::label_depth(sizes.body) + numbers;
    let room = sizes.width - left - BORDER - beside.max(sizes.tick);
    let scale = (room / (x.1 - x.0)).min(TALLEST / (y.1 - y.0));
    (x, y) = (axis::widened_to(x, SHORTEST / scale), axis::widened_to(y, SHORTEST / scale));
    let (width, height) = (scale * (x.1 - x.0), scale * (y.1 - y.0));
    let rect = Rect { x: left + ((room - width) / 2.0).max(0.0), y: top, width, height };
    Plot {
        rect,
        x: Axis::horizontal(x.0, x.1, Spacing::Linear, width, sizes.tick),
        y: Axis::vertical(y.0, y.1, Spacing::Linear, height, sizes.tick),
    }
}

/// Draws a shape, and marks its line as occupied for labels.
fn draw_shape(drawing: &mut Drawing, plot: &Plot, shape: &PlanShape, occupied: &mut Occupied) {
    let points: Vec<Point> = shape.points.iter().map(|(x, y)| plot.page_point(*x, *y)).collect();
    if points.is_empty() {
        return;
    }
    let line = |colour, width, dash| Stroke { colour, width, dash };
    match shape.look {
        Look::Part => {
            drawing.convex(points.clone(), PART[1]);
            drawing.outline(&points, line(PART[0], 6.0, &[]));
        }
        Look::Room => {
            drawing.convex(points.clone(), ROOM[1]);
            drawing.outline(&points, line(ROOM[0], 5.0, &[]));
        }
        Look::Ghost => drawing.outline(&points, line(HATCH, 4.0, &[16.0, 12.0])),
        Look::Place => {
            points.iter().for_each(|at| draw_cross(drawing, *at));
        }
        Look::Obstacle => {
            for piece in hatching_lines(&points, PITCH) {
                drawing.line(piece.to_vec(), line(OBSTACLE, 2.5, &[]));
            }
            drawing.outline(&points, line(OBSTACLE, 5.0, &[]));
        }
        Look::Body => drawing.outline(&points, line(OBSTACLE, 3.5, &[])),
        Look::Path | Look::TargetPath | Look::Before | Look::After | Look::Nearest => {
            shape.look.stroke().into_iter().for_each(|stroke| drawing.line(points.clone(), stroke));
        }
    }
    occupied.add_line(&points, 10.0);
}

/// Draws the cross of a place.
fn draw_cross(drawing: &mut Drawing, [x, y]: Point) {
    for way in [1.0, -1.0] {
        let arm = [[x - CROSS, y - way * CROSS], [x + CROSS, y + way * CROSS]];
        for (colour, width) in [(WHITE, 9.0), (INK, 4.0)] {
            drawing.line(arm.to_vec(), Stroke { colour, width, dash: &[] });
        }
    }
}

/// Draws a line in the colours of its values, with a dark border that pale colours need.
fn draw_coloured(
    drawing: &mut Drawing,
    plot: &Plot,
    piece: &[(f64, f64, f64)],
    scale: Option<Scale>,
    occupied: &mut Occupied,
) {
    let points: Vec<Point> = piece.iter().map(|(x, y, _)| plot.page_point(*x, *y)).collect();
    drawing.line(points.clone(), Stroke { colour: INK, width: 14.0, dash: &[] });
    occupied.add_line(&points, 14.0);
    let Some(scale) = scale else { return };
    let colour = |k: usize| {
        let value = scale.level_centre(0.5 * (piece[k].2 + piece[k + 1].2), LEVELS);
        let [r, g, b, _] = scale.colour(value);
        [r, g, b]
    };
    let mut start = 0;
    for k in 0..points.len().saturating_sub(1) {
        let is_last = k + 2 == points.len();
        if is_last || colour(k + 1) != colour(k) {
            drawing.line(points[start..=k + 1].to_vec(), Stroke { colour: colour(k), width: 10.0, dash: &[] });
            start = k + 1;
        }
    }
}

/// Draws rings at the marks, then labels of marks and of shapes.
fn draw_labels(drawing: &mut Drawing, plot: &Plot, figure: &PlanFigure, mut occupied: Occupied, sizes: Sizes) {
    let points_of_marks: Vec<Point> = figure.marks.iter().map(|(x, y, _)| plot.page_point(*x, *y)).collect();
    for at in &points_of_marks {
        drawing.circle(*at, MARK, Stroke { colour: WHITE, width: 8.0, dash: &[] });
        drawing.circle(*at, MARK, Stroke { colour: INK, width: 4.0, dash: &[] });
        occupied.marks.push(rect_around(*at, [MARK + 2.0; 2]));
    }
    for (at, (_, _, label)) in points_of_marks.into_iter().zip(&figure.marks).filter(|(_, mark)| !mark.2.is_empty()) {
        let label = Label { at, reach: MARK, words: label, colour: INK, weight: Weight::Bold };
        label.draw(drawing, &mut occupied, plot.rect);
    }
    // Where there is little room, the legend says what crosses are.
    let is_left_out = |shape: &&PlanShape| shape.label.is_empty() || sizes.is_portrait() && shape.look == Look::Place;
    for shape in figure.shapes.iter().filter(|shape| !(shape.points.is_empty() || is_left_out(shape))) {
        let points: Vec<Point> = shape.points.iter().map(|(x, y)| plot.page_point(*x, *y)).collect();
        let colour = match shape.look {
            Look::Part | Look::Path => PART[0],
            Look::Room => ROOM[0],
            Look::Obstacle | Look::Body => OBSTACLE,
            Look::Nearest => NEAREST.colour,
            Look::Ghost | Look::Place => MUTED,
            Look::TargetPath | Look::Before | Look::After => INK,
        };
        // The highest corner.
        let top = points.iter().copied().reduce(|a, b| if b[1] < a[1] { b } else { a }).unwrap_or_default();
        let (weight, reach) = if shape.look == Look::Place { (Weight::Regular, CROSS) } else { (Weight::Bold, 4.0) };
        Label { at: top, reach, words: &shape.label, colour, weight }.draw(drawing, &mut occupied, plot.rect);
    }
}

/// A label of one or several lines for what reaches `reach` pixels around the point `at`.
struct Label<'a> {
    at: Point,
    reach: f64,
    words: &'a str,
    colour: Rgb,
    weight: Weight,
}

impl Label<'_> {
    /// Places the label and draws it.
    fn draw(&self, drawing: &mut Drawing, occupied: &mut Occupied, bounds: Rect) {
        let Self { at, reach, words, colour, weight } = *self;
        let size = Sizes::FIGURE.tick;
        let lines: Vec<&str> = words.lines().collect();
        let widest = lines.iter().map(|line| text::width(line, size, weight)).fold(0.0, f64::max);
        let height = text::capital_height(size) + lines.len().saturating_sub(1) as f64 * 1.15 * size;
        let half = [widest / 2.0 + 6.0, height / 2.0 + 7.0];
        let Spot { rect, leader } = occupied.place_label(at, reach, half, bounds);
        if let Some(leader) = leader {
            drawing.line(leader.to_vec(), Stroke { colour: MUTED, width: 2.5, dash: &[] });
        }
        for (row, line) in lines.into_iter().enumerate() {
            let baseline = rect.y + 7.0 + text::capital_height(size) + row as f64 * 1.15 * size;
            let text = Text::new(line, size, [rect.centre()[0], baseline], Anchor::Middle);
            drawing.text(Text { weight, ..text }.coloured(colour).with_halo());
        }
    }
}
