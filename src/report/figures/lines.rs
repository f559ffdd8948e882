//! Curves over two axes.

use super::axis::{self, Axis, Plot, Spacing};
use super::error::{FigureError, check_drawable};
use super::scene::{Anchor, Point, Rect, Rgb, Scene, Stroke, Text};
use super::style::{self, BORDER, CURVES, DASHES, GRID, PAGE_WIDTH, Sizes, WHITE};
use super::text::{self, LINE_PITCH, Weight};
use super::ticks;

const SIZES: Sizes = Sizes::COLUMN;
/// Height of the frame when the axes are free, and the most when they are equal.
const FRAME_HEIGHT: f64 = 860.0;
const TALLEST_EQUAL: f64 = 1000.0;
/// Shortest side of the frame when the axes are equal.
const SHORTEST: f64 = 300.0;
/// Share of the range left blank on each side.
const MARGIN: f64 = 0.04;
/// Width over height from which a frame with equal axes has its legend below.
const WIDE: f64 = 1.6;
/// Widest legend beside the frame.
const SIDE_LEGEND: f64 = 600.0;
/// Space between frame and legend.
const LEGEND_GAP: f64 = 44.0;
/// Length of a legend's sample line.
const SAMPLE: f64 = 92.0;
const SAMPLE_GAP: f64 = 16.0;
const CURVE_WIDTH: f64 = 5.0;
const MARKER: f64 = 9.0;
/// Up to this many points each gets a marker; longer solid curves get this many over their length.
const EVERY_POINT: usize = 30;
const SPARSE: usize = 8;

/// One curve.
#[derive(Debug, Clone, PartialEq)]
pub struct LineSeries {
    /// Its name in the legend; empty leaves it out.
    pub label: String,
    /// Points joined in order.
    pub points: Vec<(f64, f64)>,
    /// Dashed, each dashed curve in its own pattern; otherwise solid.
    pub dashed: bool,
}

/// Curves over two axes. Curves differ in colour, and in dash pattern or marker, so that a grey print keeps them apart.
#[derive(Debug, Clone, PartialEq)]
pub struct LineFigure {
    /// The question.
    pub title: String,
    /// The setting.
    pub subtitle: String,
    /// For example "x \[mm\]".
    pub x_label: String,
    /// For example "y \[mm\]".
    pub y_label: String,
    /// The curves, the first one black.
    pub series: Vec<LineSeries>,
    /// One unit is equally long on both axes.
    pub equal_axes: bool,
    /// Logarithmic x axis.
    pub log_x: bool,
    /// Logarithmic y axis.
    pub log_y: bool,
    /// A remark a reader must not miss, for example "errors amplified 20x".
    pub closed_note: Option<String>,
}

impl LineFigure {
    fn check(&self) -> Result<(), FigureError> {
        if self.series.iter().all(|s| s.points.is_empty()) {
            return Err(FigureError::Empty { what: "line figure".into() });
        }
        if self.equal_axes && (self.log_x || self.log_y) {
            return Err(FigureError::EqualAxesWithLog);
        }
        self.series.iter().try_for_each(|series| {
            let name = || format!("series \"{}\"", series.label);
            check_drawable(series.points.iter().flat_map(|p| [p.0, p.1]), name)?;
            let on_log = |p: &(f64, f64)| [(self.log_x, p.0), (self.log_y, p.1)];
            // Below 1e-100 the ratio of the ends overflows.
            let wrong = series.points.iter().flat_map(on_log).find(|(log, v)| *log && *v < 1e-100);
            wrong.map_or(Ok(()), |(_, value)| Err(FigureError::NotPositive { what: name(), value }))
        })
    }

    /// The legend stands beside the frame if equal axes leave room there.
    fn legend_beside(&self) -> bool {
        let length = |(low, high): (f64, f64)| high - low;
        self.equal_axes && length(self.ends(|p| p.0, false)) < WIDE * length(self.ends(|p| p.1, false))
    }

    fn ends(&self, pick: impl Fn(&(f64, f64)) -> f64, log: bool) -> (f64, f64) {
        let values = || self.series.iter().flat_map(|s| &s.points).map(&pick);
        let low = values().fold(f64::INFINITY, f64::min);
        let high = values().fold(f64::NEG_INFINITY, f64::max);
        if log {
            let (low, high) = ticks::widened(low.log10(), high.log10());
            let margin = MARGIN * (high - low);
            return (10_f64.powf(low - margin), 10_f64.powf(high + margin));
        }
        let (low, high) = ticks::widened(low, high);
        let margin = MARGIN * (high - low);
        (low - margin, high + margin)
    }
}

pub(super) fn scene(figure: &LineFigure) -> Result<Scene, FigureError> {
    figure.check()?;
    let (mut scene, top) = style::page(&figure.title, &figure.subtitle, SIZES);
    let styles = CurveStyle::of(&figure.series);
    let plot = plot(figure, top + 0.3 * SIZES.body);
    plot.draw_grid(&mut scene, Stroke { colour: GRID, width: 1.5, dash: &[] });
    plot.draw_below(&mut scene, &figure.x_label, SIZES.body, SIZES.tick);
    plot.draw_beside(&mut scene, &figure.y_label, SIZES.body, SIZES.tick);
    for (index, (series, style)) in figure.series.iter().zip(&styles).enumerate() {
        let points: Vec<Point> = series.points.iter().map(|(x, y)| plot.place(*x, *y)).collect();
        style.draw(&mut scene, &points, index);
    }
    plot.draw_frame(&mut scene);
    let below = plot.rect.bottom() + axis::depth_below(SIZES.tick) + axis::label_depth(SIZES.body);
    let room = if figure.legend_beside() {
        let x = plot.rect.right() + LEGEND_GAP;
        Rect { x, y: plot.rect.y, width: PAGE_WIDTH - BORDER - x, height: 0.0 }
    } else {
        let y = below + 0.3 * SIZES.body;
        Rect { x: plot.rect.x, y, width: plot.rect.width, height: 0.0 }
    };
    let legend_bottom = draw_legend(&mut scene, figure, &styles, room);
    scene.height = legend_bottom.max(below) + BORDER;
    Ok(scene)
}

/// The frame with its axes.
fn plot(figure: &LineFigure, top: f64) -> Plot {
    let mut x = figure.ends(|p| p.0, figure.log_x);
    let mut y = figure.ends(|p| p.1, figure.log_y);
    let spacing = |log| if log { Spacing::Logarithmic } else { Spacing::Linear };
    let y_axis = |ends: (f64, f64), height| Axis::vertical(ends.0, ends.1, spacing(figure.log_y), height, SIZES.tick);
    let nominal = y_axis(y, FRAME_HEIGHT).depth_beside(SIZES.tick);
    let left = BORDER + axis::label_depth(SIZES.body) + nominal;
    let mut rect = Rect { x: left, y: top, width: PAGE_WIDTH - left - 2.0 * BORDER, height: FRAME_HEIGHT };
    if figure.equal_axes {
        let room = rect.width - if figure.legend_beside() { legend_width(figure) } else { 0.0 };
        let scale = (room / (x.1 - x.0)).min(TALLEST_EQUAL / (y.1 - y.0));
        x = at_least(x, SHORTEST / scale);
        y = at_least(y, SHORTEST / scale);
        rect.width = scale * (x.1 - x.0);
        rect.height = scale * (y.1 - y.0);
    }
    Plot {
        rect,
        x: Axis::horizontal(x.0, x.1, spacing(figure.log_x), rect.width, SIZES.tick),
        y: y_axis(y, rect.height),
    }
}

/// Width of the legend beside the frame.
fn legend_width(figure: &LineFigure) -> f64 {
    let labels = figure.series.iter().map(|s| &s.label).filter(|label| !label.is_empty());
    let entry = |label: &String| SAMPLE + SAMPLE_GAP + text::width(label, SIZES.body, Weight::Regular);
    let widest = labels.map(entry).fold(0.0, f64::max);
    let note = figure.closed_note.as_deref().map_or(0.0, |n| text::width(n, SIZES.body, Weight::Bold).min(400.0));
    widest.max(note).min(SIDE_LEGEND) + LEGEND_GAP
}

/// The range, widened around its middle to `length` if shorter.
fn at_least(range: (f64, f64), length: f64) -> (f64, f64) {
    let missing = (length - (range.1 - range.0)).max(0.0) / 2.0;
    (range.0 - missing, range.1 + missing)
}

/// How one curve is told from the others.
struct CurveStyle {
    stroke: Stroke,
    /// Corners of the marker around the origin; none for dashed curves and a long first one.
    marker: Vec<Point>,
}

impl CurveStyle {
    fn of(series: &[LineSeries]) -> Vec<Self> {
        let mut dashed = 0;
        let mut out = Vec::with_capacity(series.len());
        for (index, one) in series.iter().enumerate() {
            let mut dash: &[f64] = &[];
            if one.dashed {
                dash = DASHES[dashed % DASHES.len()];
                dashed += 1;
            }
            let colour: Rgb = CURVES[index % CURVES.len()];
            let few = one.points.len() <= EVERY_POINT;
            let marked = one.points.len() == 1 || !one.dashed && (few || index > 0);
            out.push(Self {
                stroke: Stroke { colour, width: CURVE_WIDTH, dash },
                marker: if marked { marker(index) } else { vec![] },
            });
        }
        out
    }

    /// Draws the curve; `index` shifts sparse markers so that those of different curves do not coincide.
    fn draw(&self, scene: &mut Scene, points: &[Point], index: usize) {
        if points.len() > 1 {
            scene.line(points.to_vec(), self.stroke);
        }
        if self.marker.is_empty() {
            return;
        }
        let stride = if points.len() <= EVERY_POINT { 1 } else { points.len().div_ceil(SPARSE) };
        let first = (index * stride / 3) % stride;
        for point in points.iter().skip(first).step_by(stride) {
            self.draw_marker(scene, *point);
        }
    }

    fn draw_marker(&self, scene: &mut Scene, at: Point) {
        let corners: Vec<Point> = self.marker.iter().map(|[x, y]| [at[0] + x, at[1] + y]).collect();
        scene.outline(&corners, Stroke { colour: WHITE, width: 3.0, dash: &[] });
        scene.convex(corners, self.stroke.colour);
    }

    fn draw_sample(&self, scene: &mut Scene, left: Point) {
        scene.line(vec![left, [left[0] + SAMPLE, left[1]]], self.stroke);
        if !self.marker.is_empty() {
            self.draw_marker(scene, [left[0] + SAMPLE / 2.0, left[1]]);
        }
    }
}

/// Circle, square, triangle, diamond, triangle on its tip, in turn.
fn marker(index: usize) -> Vec<Point> {
    let (corners, turn, radius) =
        [(24, 0.0, 1.0), (4, 0.125, 1.2), (3, 0.25, 1.35), (4, 0.0, 1.3), (3, 0.75, 1.35)][index % 5];
    let angle = |k: usize| std::f64::consts::TAU * (turn + k as f64 / corners as f64);
    let radius = MARKER * radius;
    (0..corners).map(|k| [radius * angle(k).cos(), -radius * angle(k).sin()]).collect()
}

/// Entries side by side while they fit into the width of `room`, then the note; returns the y below.
fn draw_legend(scene: &mut Scene, figure: &LineFigure, styles: &[CurveStyle], room: Rect) -> f64 {
    let [mut x, mut y, mut row_height] = [room.x, room.y, 0.0];
    let named = figure.series.iter().zip(styles).filter(|(series, _)| !series.label.is_empty());
    for (series, style) in named {
        let entry = Paragraph::new(&series.label, Weight::Regular, room.width - SAMPLE - SAMPLE_GAP);
        let width = SAMPLE + SAMPLE_GAP + entry.width;
        if x > room.x && x + width > room.right() {
            x = room.x;
            y += row_height;
            row_height = 0.0;
        }
        style.draw_sample(scene, [x, y + 0.65 * SIZES.body]);
        entry.draw(scene, [x + SAMPLE + SAMPLE_GAP, y]);
        x += width + 1.2 * SIZES.body;
        row_height = entry.height().max(row_height);
    }
    y += row_height;
    let note = Paragraph::new(figure.closed_note.as_deref().unwrap_or(""), Weight::Bold, room.width);
    note.draw(scene, [room.x, y + 0.3 * SIZES.body]);
    y + 0.3 * SIZES.body + note.height()
}

/// Wrapped text of the legend.
struct Paragraph {
    lines: Vec<String>,
    weight: Weight,
    limit: f64,
    width: f64,
}

impl Paragraph {
    fn new(content: &str, weight: Weight, limit: f64) -> Self {
        let lines = text::wrap(content, SIZES.body, weight, limit);
        let widest = lines.iter().map(|l| text::width(l, SIZES.body, weight)).fold(0.0, f64::max);
        Self { lines, weight, limit, width: widest.min(limit) }
    }

    fn height(&self) -> f64 {
        self.lines.len() as f64 * LINE_PITCH * SIZES.body
    }

    fn draw(&self, scene: &mut Scene, corner: Point) {
        for (row, line) in self.lines.iter().enumerate() {
            let size = text::fitting_size(line, SIZES.body, self.weight, self.limit);
            let baseline = corner[1] + row as f64 * LINE_PITCH * SIZES.body + SIZES.body;
            let text = Text::new(line, size, [corner[0], baseline], Anchor::Start);
            scene.text(Text { weight: self.weight, ..text });
        }
    }
}
