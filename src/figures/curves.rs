//! Curves in a plot: colours, dashes and markers that distinguish them, and their legend.

use super::drawing::{Anchor, Drawing, Point, Rect, Rgb, Stroke, Text};
use super::style::{CURVES, DASHES, WHITE};
use super::text::{self, LINE_PITCH, Weight};

/// Length of a legend's sample line in pixels.
const SAMPLE: f64 = 92.0;
const SAMPLE_GAP: f64 = 16.0;
const CURVE_WIDTH: f64 = 5.0;
/// Width of the lines around a band.
const BAND_EDGE: f64 = 2.0;
const MARKER: f64 = 9.0;
/// Most points of a curve that all get a marker; longer solid curves get `SPARSE` markers over their length.
const EVERY_POINT: usize = 30;
const SPARSE: usize = 8;
/// Most width in pixels that its note gives a legend beside a plot.
const NARROW_NOTE: f64 = 400.0;

/// Colour, dash pattern and marker that distinguish one curve from the others.
pub(super) struct CurveStyle {
    stroke: Stroke,
    /// Corners of the marker around the origin in pixels; none for dashed curves and for the first one if it has many points.
    marker: Vec<Point>,
}

impl CurveStyle {
    /// Returns a style for each curve, which is given by its number of points and whether it is dashed.
    pub fn of(curves: impl Iterator<Item = (usize, bool)>) -> Vec<Self> {
        let mut dashed = 0;
        let mut out = Vec::new();
        for (index, (points, is_dashed)) in curves.enumerate() {
            let mut dash: &[f64] = &[];
            if is_dashed {
                dash = DASHES[dashed % DASHES.len()];
                dashed += 1;
            }
            let colour: Rgb = CURVES[index % CURVES.len()];
            let has_marker = points == 1 || !is_dashed && (points <= EVERY_POINT || index > 0);
            out.push(Self {
                stroke: Stroke { colour, width: CURVE_WIDTH, dash },
                marker: if has_marker { marker(index) } else { vec![] },
            });
        }
        out
    }

    /// Draws the curve through `points`, without markers.
    pub(crate) fn draw_line(&self, drawing: &mut Drawing, points: &[Point]) {
        if points.len() > 1 {
            drawing.line(points.to_vec(), self.stroke);
        }
    }

    /// Draws a pale band between the low and the high point of each pair in `ends`, with its two edges.
    pub(crate) fn draw_band(&self, drawing: &mut Drawing, ends: &[[Point; 2]]) {
        let pale = self.stroke.colour.map(|part| 255 - (255 - part) / 5);
        for pair in ends.windows(2) {
            let ([low, high], [next_low, next_high]) = (pair[0], pair[1]);
            drawing.convex(vec![low, next_low, next_high, high], pale);
        }
        for side in 0..2 {
            let edge: Vec<Point> = ends.iter().map(|ends| ends[side]).collect();
            if edge.len() > 1 {
                drawing.line(edge, Stroke { width: BAND_EDGE, ..self.stroke });
            }
        }
    }

    /// Draws markers at `points`, the whole curve; `index` shifts sparse ones so that those of different curves do not coincide.
    pub(crate) fn draw_markers(&self, drawing: &mut Drawing, points: &[Point], index: usize) {
        if self.marker.is_empty() {
            return;
        }
        let stride = if points.len() <= EVERY_POINT { 1 } else { points.len().div_ceil(SPARSE) };
        let first = (index * stride / 3) % stride;
        for point in points.iter().skip(first).step_by(stride) {
            self.draw_marker(drawing, *point);
        }
    }

    /// Draws one marker with a white rim at the point `at`.
    fn draw_marker(&self, drawing: &mut Drawing, at: Point) {
        let corners: Vec<Point> = self.marker.iter().map(|[x, y]| [at[0] + x, at[1] + y]).collect();
        drawing.outline(&corners, Stroke { colour: WHITE, width: 3.0, dash: &[] });
        drawing.convex(corners, self.stroke.colour);
    }

    /// Draws the curve's sample in the legend, to the right from the point `left`.
    fn draw_sample(&self, drawing: &mut Drawing, left: Point) {
        drawing.line(vec![left, [left[0] + SAMPLE, left[1]]], self.stroke);
        if !self.marker.is_empty() {
            self.draw_marker(drawing, [left[0] + SAMPLE / 2.0, left[1]]);
        }
    }
}

/// Returns the corners of the marker of the curve `index` around the origin; five shapes (circle, square, …) follow in turn.
fn marker(index: usize) -> Vec<Point> {
    let (corners, turn, radius) =
        [(24, 0.0, 1.0), (4, 0.125, 1.2), (3, 0.25, 1.35), (4, 0.0, 1.3), (3, 0.75, 1.35)][index % 5];
    let angle = |k: usize| std::f64::consts::TAU * (turn + k as f64 / corners as f64);
    let radius = MARKER * radius;
    (0..corners).map(|k| [radius * libm::cos(angle(k)), -radius * libm::sin(angle(k))]).collect()
}

/// Names and samples of the curves, and a note.
pub(super) struct Legend<'a> {
    /// Names and styles; curves with an empty name are left out.
    pub entries: Vec<(&'a str, &'a CurveStyle)>,
    pub note: &'a str,
    pub size: f64,
}

impl Legend<'_> {
    /// Returns the width in pixels of the legend beside a plot, without the gap between them.
    pub fn width(&self) -> f64 {
        let names = self.entries.iter().map(|(name, _)| name).filter(|name| !name.is_empty());
        let entry = |name: &&str| SAMPLE + SAMPLE_GAP + text::width(name, self.size, Weight::Regular);
        let widest = names.map(entry).fold(0.0, f64::max);
        widest.max(text::width(self.note, self.size, Weight::Bold).min(NARROW_NOTE))
    }

    /// Draws the entries side by side in rows as wide as `room`, then the note; returns the y below them.
    pub fn draw(&self, drawing: &mut Drawing, room: Rect) -> f64 {
        let [mut x, mut y, mut row_height] = [room.x, room.y, 0.0];
        for (name, style) in self.entries.iter().filter(|(name, _)| !name.is_empty()) {
            let entry = Paragraph::new(name, self.size, Weight::Regular, room.width - SAMPLE - SAMPLE_GAP);
            let width = SAMPLE + SAMPLE_GAP + entry.width;
            if x > room.x && x + width > room.right() {
                x = room.x;
                y += row_height;
                row_height = 0.0;
            }
            style.draw_sample(drawing, [x, y + 0.65 * self.size]);
            entry.draw(drawing, [x + SAMPLE + SAMPLE_GAP, y]);
            x += width + 1.2 * self.size;
            row_height = entry.height().max(row_height);
        }
        y += row_height + 0.3 * self.size;
        let note = Paragraph::new(self.note, self.size, Weight::Bold, room.width);
        note.draw(drawing, [room.x, y]);
        y + note.height()
    }
}

/// A text of the legend, wrapped into lines.
struct Paragraph {
    lines: Vec<String>,
    size: f64,
    weight: Weight,
    width: f64,
}

impl Paragraph {
    /// Wraps `content` into lines no wider than `limit` pixels.
    fn new(content: &str, size: f64, weight: Weight, limit: f64) -> Self {
        let lines = text::wrap(content, size, weight, limit);
        let widest = lines.iter().map(|l| text::width(l, size, weight)).fold(0.0, f64::max);
        Self { lines, size, weight, width: widest.min(limit) }
    }

    /// Returns the height of all lines in pixels.
    fn height(&self) -> f64 {
        self.lines.len() as f64 * LINE_PITCH * self.size
    }

    /// Draws the lines with the upper left corner of the text at `corner`.
    fn draw(&self, drawing: &mut Drawing, corner: Point) {
        for (row, line) in self.lines.iter().enumerate() {
            let baseline = corner[1] + row as f64 * LINE_PITCH * self.size + self.size;
            let text = Text::new(line, self.size, [corner[0], baseline], Anchor::Start);
            drawing.text(Text { weight: self.weight, ..text });
        }
    }
}
