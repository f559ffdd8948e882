//! Drawings on the first screen of a comparison, as SVG without scripts: which result is best where.

use std::fmt::Write;

use minijinja::HtmlEscape;
use serde::Serialize;

use super::{
    aligned::{Aligned, label_with_unit},
    description::{Column, Shape},
    sentences::three_digits,
    table::format_number,
    winners::{NodeWinner, Winners},
};
use crate::files::{visible::visible, words::with_unit};

/// Leads from which colours become stronger, as shares of the next best value.
pub(super) const LEADS: [f64; 2] = [0.05, 0.25];
/// Most points drawn of a curve.
const MAX_POINTS: usize = 300;

/// Drawings side by side, with a title.
#[derive(Debug, Serialize)]
pub(super) struct Picture {
    pub title: String,
    /// Whether places have the colours of their winners, which need a key.
    has_key: bool,
    panels: Vec<Panel>,
}

/// One drawing with its title.
#[derive(Debug, Serialize)]
struct Panel {
    title: String,
    svg: String,
}

/// Draws which result is best where, over a grid or along curves, or bars where one is best everywhere in a grid; `None` if there is nothing to draw.
pub(super) fn winner_picture(aligned: &Aligned, quantity: usize, winners: &Winners) -> Option<Picture> {
    let shared = &aligned.shared;
    let label = &shared.quantities[quantity].label;
    let group = aligned.group_name(0);
    let of = if group.is_empty() { String::new() } else { format!(", {group}") };
    let is_by_place = shared.shape != Shape::Curve || aligned.has_same_nodes();
    if let (Shape::Grid, Some(extremes)) = (shared.shape, aligned.extremes(quantity, 0))
        && winners.win_share(winners.order_by_wins()[0]) == 1.0
    {
        let (title, quantity) = (format!("{label}, each at its worst{of}"), &shared.quantities[quantity]);
        let worst: Vec<f64> = extremes.iter().map(|own| own.worst_and_best(quantity.better)[0].0).collect();
        return bar_picture(title, &quantity.unit, &worst, &aligned.letters);
    }
    let mut title = if is_by_place { format!("Who is best where: {label}{of}") } else { format!("{label}{of}") };
    let panels = match shared.shape {
        Shape::Grid => {
            let (panels, count) = slice_panels(aligned, winners)?;
            if panels.len() < count {
                title += &format!("; {} of {count} slices", panels.len());
            }
            panels
        }
        Shape::Curve => vec![curve_panel(aligned, quantity, winners)?],
        Shape::Names => return None,
    };
    Some(Picture { title, has_key: is_by_place, panels })
}

/// Draws a bar for each result; `None` if a value is missing or negative, or all are 0.
pub(super) fn bar_picture(title: String, unit: &str, values: &[f64], letters: &[char]) -> Option<Picture> {
    let most = values.iter().copied().fold(0.0, f64::max);
    if most <= 0.0 || values.iter().any(|value| !value.is_finite() || *value < 0.0) {
        return None;
    }
    let (step, room) = (34.0, WIDE - LEFT - 90.0);
    let height = step * values.len() as f64 + EDGE;
    let mut svg = format!("<svg viewBox=\"0 0 {WIDE:.0} {height:.0}\" role=\"img\" aria-labelledby=\"hero-title\">");
    for (who, (value, letter)) in values.iter().zip(letters).enumerate() {
        let (top, width) = (EDGE + step * who as f64, room * value / most);
        let (middle, right) = (top + 0.5 * step, LEFT + width + 6.0);
        let text = escape_html(&with_unit(&three_digits(*value), unit));
        // Writing to a string cannot fail.
        let _ = write!(
            svg,
            "<text x=\"{:.1}\" y=\"{middle:.1}\" text-anchor=\"end\">{letter}</text>\
             <rect class=\"win w{who}\" x=\"{LEFT}\" y=\"{top:.1}\" width=\"{width:.1}\" height=\"24\"/>\
             <text x=\"{right:.1}\" y=\"{middle:.1}\">{text}</text>",
            LEFT - 6.0
        );
    }
    svg += "</svg>";
    Some(Picture { title, has_key: false, panels: vec![Panel { title: String::new(), svg }] })
}

/// Returns the CSS classes of a place: colour of its winner and strength of the lead; `None` without a winner.
fn winner_class(at: NodeWinner) -> Option<String> {
    match at {
        NodeWinner::Nothing => None,
        NodeWinner::Same => Some("same".into()),
        NodeWinner::Best { who, lead } => {
            Some(format!("win w{who} l{}", 1 + LEADS.iter().filter(|least| lead >= **least).count()))
        }
    }
}

/// Draws the winners in the lowest, the middle and the highest slice of a grid, and returns of how many; `None` with fewer than two long axes.
fn slice_panels(aligned: &Aligned, winners: &Winners) -> Option<(Vec<Panel>, usize)> {
    let data = aligned.common.first()?;
    let coordinates = &aligned.shared.coordinates;
    let long: Vec<usize> = (0..data.axes.len()).filter(|axis| data.axes[*axis].len() > 1).collect();
    let [columns, rows] = *long.get(..2)? else { return None };
    let across = long.get(2).copied();
    let levels = across.map_or(vec![0], |axis| {
        let count = data.axes[axis].len();
        let mut levels = vec![0, count / 2, count - 1];
        levels.dedup();
        levels
    });
    let panel = |level: usize| {
        let mut at: Vec<usize> = data.axes.iter().map(|axis| axis.len() / 2).collect();
        if let Some(axis) = across {
            at[axis] = level;
        }
        let text = |axis: usize| {
            let node_indices = format_number(data.axes[axis][at[axis]]);
            format!("{} = {}", coordinates[axis].label, with_unit(&node_indices, &coordinates[axis].unit))
        };
        let fixed: Vec<usize> = (0..data.axes.len()).filter(|axis| *axis != columns && *axis != rows).collect();
        let title =
            fixed.into_iter().filter(|axis| data.axes[*axis].len() > 1).map(text).collect::<Vec<_>>().join(", ");
        let (x, y) = (&data.axes[columns], &data.axes[rows]);
        let frame = Frame::new([axis_ends(x), axis_ends(y)], coordinates[columns].unit == coordinates[rows].unit);
        let mut svg = frame.opening_tag();
        for (r, [low, high]) in cell_ranges(y).into_iter().enumerate() {
            let class_of = |c: usize| {
                let mut node_indices = at.clone();
                (node_indices[columns], node_indices[rows]) = (c, r);
                let node = node_indices.iter().zip(&data.axes).rev().fold(0, |node, (i, axis)| node * axis.len() + i);
                winner_class(winners.at[node])
            };
            let sides = cell_ranges(x);
            let mut begin = 0;
            while begin < x.len() {
                let class_here = class_of(begin);
                let end = (begin + 1..x.len()).find(|c| class_of(*c) != class_here).unwrap_or(x.len());
                if let Some(class) = class_here {
                    frame.draw_cell(&mut svg, &class, [sides[begin][0], sides[end - 1][1]], [low, high]);
                }
                begin = end;
            }
        }
        frame.finish(&mut svg, [&coordinates[columns], &coordinates[rows]]);
        Panel { title, svg }
    };
    let count = across.map_or(1, |axis| data.axes[axis].len());
    Some((levels.into_iter().map(panel).collect(), count))
}

/// Draws the curves of all results, and below them a strip in the colours of the winners; `None` without a number.
fn curve_panel(aligned: &Aligned, quantity: usize, winners: &Winners) -> Option<Panel> {
    let shared = &aligned.shared;
    let q = &shared.quantities[quantity];
    let curve_of = |who: usize| (&aligned.data[who].axes[0], &aligned.data[who].values[quantity][0]);
    let all = (0..aligned.letters.len()).flat_map(|who| curve_of(who).1).copied().filter(|value| value.is_finite());
    let high = all.clone().reduce(f64::max)?;
    let low = all.reduce(f64::min)?.min(0.0);
    let long = (0..aligned.letters.len()).filter_map(|who| curve_of(who).0.last()).copied().fold(0.0, f64::max);
    let frame = Frame::new([[0.0, long.max(1e-9)], [low, if high > low { high } else { low + 1.0 }]], false);
    let mut svg = frame.opening_tag();
    let common = aligned.common.first().filter(|_| aligned.has_same_nodes());
    let axis = common.and_then(|part| part.axes.first());
    for (node, [begin, end]) in axis.map(|axis| cell_ranges(axis)).unwrap_or_default().into_iter().enumerate() {
        if let Some(class) = winner_class(winners.at[node]) {
            frame.draw_band(&mut svg, &class, [begin.max(0.0), end.min(long)]);
        }
    }
    for who in 0..aligned.letters.len() {
        let (x, y) = curve_of(who);
        let step = x.len().div_ceil(MAX_POINTS).max(1);
        let points = (0..x.len()).filter(|i| i % step == 0 || i + 1 == x.len()).filter(|i| y[*i].is_finite());
        let points: Vec<String> = points.map(|i| format!("{:.1},{:.1}", frame.x(x[i]), frame.y(y[i]))).collect();
        // Writing to a string cannot fail.
        let _ = write!(svg, "<polyline class=\"line w{who}\" points=\"{}\"/>", points.join(" "));
    }
    frame.finish(&mut svg, [&shared.coordinates[0], &Column::new("", "", "")]);
    Some(Panel { title: label_with_unit(&q.label, &q.unit), svg })
}

/// Returns the ends of the cells along an axis; 0 and 1 for an empty one.
fn axis_ends(axis: &[f64]) -> [f64; 2] {
    cell_ranges(axis).first().zip(cell_ranges(axis).last()).map_or([0.0, 1.0], |(first, last)| [first[0], last[1]])
}

/// Returns both ends of the range that is nearest to each value of an axis.
fn cell_ranges(axis: &[f64]) -> Vec<[f64; 2]> {
    let middle = |i: usize| 0.5 * (axis[i] + axis[i + 1]);
    let last = axis.len().saturating_sub(1);
    (0..axis.len())
        .map(|i| {
            let begin = if i == 0 { axis[0] } else { middle(i - 1) };
            let end = if i == last { axis[last] } else { middle(i) };
            [begin, end]
        })
        .collect()
}

/// Width of a drawing to scale, in units of the SVG.
const WIDTH: f64 = 260.0;
/// Width of a drawing that is not to scale.
const WIDE: f64 = 460.0;
const HEIGHT: f64 = 220.0;
/// Space for the axes and at the edges.
const LEFT: f64 = 46.0;
const BOTTOM: f64 = 34.0;
const EDGE: f64 = 6.0;
/// Axes of a drawing: range of values and size in SVG units, horizontal first.
struct Frame {
    ends: [[f64; 2]; 2],
    size: [f64; 2],
    width: f64,
}

impl Frame {
    /// Returns the axes over `ends`, with one scale for both if `is_to_scale`.
    fn new(ends: [[f64; 2]; 2], is_to_scale: bool) -> Self {
        let all = if is_to_scale { WIDTH } else { WIDE };
        let (width, height) = (all - LEFT - EDGE, HEIGHT - BOTTOM - EDGE);
        let [x, y] = ends.map(|[low, high]| high - low);
        let scale = (width / x).min(height / y);
        let size = if is_to_scale { [x * scale, y * scale] } else { [width, height] };
        Self { ends, size, width: all }
    }

    /// Returns the horizontal coordinate of a value.
    fn x(&self, value: f64) -> f64 {
        let [low, high] = self.ends[0];
        LEFT + (value - low) / (high - low) * self.size[0]
    }

    /// Returns the vertical coordinate of a value.
    fn y(&self, value: f64) -> f64 {
        let [low, high] = self.ends[1];
        EDGE + (high - value) / (high - low) * self.size[1]
    }

    /// Returns the opening tag of the drawing.
    fn opening_tag(&self) -> String {
        let height = self.size[1] + BOTTOM + EDGE;
        // In the middle above its caption.
        let left = 0.5 * (LEFT + self.size[0] + EDGE - self.width);
        format!(
            "<svg viewBox=\"{left:.0} 0 {:.0} {height:.0}\" role=\"img\" aria-labelledby=\"hero-title\">",
            self.width
        )
    }

    /// Draws a rectangle between the values `x` and `y`.
    fn draw_cell(&self, svg: &mut String, class: &str, x: [f64; 2], y: [f64; 2]) {
        let (left, top) = (self.x(x[0]), self.y(y[1]));
        let (width, height) = (self.x(x[1]) - left, self.y(y[0]) - top);
        let _ = write!(
            svg,
            "<rect class=\"{class}\" x=\"{left:.1}\" y=\"{top:.1}\" width=\"{width:.1}\" height=\"{height:.1}\"/>"
        );
    }

    /// Draws a piece of the strip along the lower edge.
    fn draw_band(&self, svg: &mut String, class: &str, [begin, end]: [f64; 2]) {
        let (left, top) = (self.x(begin), EDGE + self.size[1] - 8.0);
        let width = (self.x(end) - left).max(0.0);
        let _ =
            write!(svg, "<rect class=\"{class}\" x=\"{left:.1}\" y=\"{top:.1}\" width=\"{width:.1}\" height=\"8\"/>");
    }

    /// Draws frame, axis labels and end values, and closes the drawing.
    fn finish(&self, svg: &mut String, [across, up]: [&Column; 2]) {
        let [width, height] = self.size;
        let (right, low) = (LEFT + width, EDGE + height);
        let _ = write!(
            svg,
            "<rect class=\"frame\" x=\"{LEFT}\" y=\"{EDGE}\" width=\"{width:.1}\" height=\"{height:.1}\"/>"
        );
        let mut text = |x: f64, y: f64, anchor: &str, words: String| {
            let words = escape_html(&words);
            let _ = write!(svg, "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\">{words}</text>");
        };
        let [[x0, x1], [y0, y1]] = self.ends;
        text(LEFT, low + 12.0, "start", three_digits(x0));
        text(right, low + 12.0, "end", three_digits(x1));
        text(LEFT + 0.5 * width, low + 26.0, "middle", label_with_unit(&across.label, &across.unit));
        text(LEFT - 4.0, low, "end", three_digits(y0));
        text(LEFT - 4.0, EDGE + 8.0, "end", three_digits(y1));
        let words = escape_html(&label_with_unit(&up.label, &up.unit));
        let middle = EDGE + 0.5 * height;
        let _ = write!(
            svg,
            "<text transform=\"translate(12 {middle:.1}) rotate(-90)\" text-anchor=\"middle\">{words}</text></svg>"
        );
    }
}

/// Escapes a text for use in a drawing.
fn escape_html(text: &str) -> String {
    HtmlEscape(&visible(text)).to_string()
}
