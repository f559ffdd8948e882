//! The picture of a comparison's first screen: who is best where, as drawings that need no script.

use std::fmt::Write;

use minijinja::HtmlEscape;
use serde::Serialize;

use super::{
    aligned::{Aligned, in_unit},
    description::{Column, Shape},
    sentences::three,
    table::number,
    winners::{At, Winners},
};
use crate::files::{visible::visible, words::with_unit};

/// Leads at which colours become stronger.
const LEADS: [f64; 2] = [0.05, 0.25];
/// Most points of a curve that are drawn.
const MOST_POINTS: usize = 300;

/// Drawings, and what they show.
#[derive(Debug, Serialize)]
pub(super) struct Picture {
    /// In a line.
    pub title: String,
    /// Whether places have the colours of their winners.
    has_key: bool,
    panels: Vec<Panel>,
}

#[derive(Debug, Serialize)]
struct Panel {
    title: String,
    svg: String,
}

/// Who is best where; `None` if there is nothing to draw.
pub(super) fn picture(aligned: &Aligned, quantity: usize, winners: &Winners) -> Option<Picture> {
    let shared = &aligned.shared;
    let label = &shared.quantities[quantity].label;
    let group = aligned.group_name(0);
    let of = if group.is_empty() { String::new() } else { format!(", {group}") };
    let is_by_place = shared.shape != Shape::Curve || aligned.is_whole();
    let title = if is_by_place { format!("Who is best where: {label}{of}") } else { format!("{label}{of}") };
    let panels = match shared.shape {
        Shape::Grid => slices(aligned, winners)?,
        Shape::Curve => vec![curves(aligned, quantity, winners)?],
        Shape::Names => return None,
    };
    Some(Picture { title, has_key: is_by_place, panels })
}

/// One bar for each result; `None` if a value is missing.
pub(super) fn bars(title: String, unit: &str, values: &[f64], letters: &[char]) -> Option<Picture> {
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
        let words = escaped(&with_unit(&three(*value), unit));
        // Writing to a string cannot fail.
        let _ = write!(
            svg,
            "<text x=\"{:.1}\" y=\"{middle:.1}\" text-anchor=\"end\">{letter}</text>\
             <rect class=\"win w{who}\" x=\"{LEFT}\" y=\"{top:.1}\" width=\"{width:.1}\" height=\"24\"/>\
             <text x=\"{right:.1}\" y=\"{middle:.1}\">{words}</text>",
            LEFT - 6.0
        );
    }
    svg += "</svg>";
    Some(Picture { title, has_key: false, panels: vec![Panel { title: String::new(), svg }] })
}

/// Class of a place: whose colour, how strong.
fn class(at: At) -> Option<String> {
    match at {
        At::Nothing => None,
        At::Same => Some("same".into()),
        At::Best { who, lead } => {
            Some(format!("win w{who} l{}", 1 + LEADS.iter().filter(|least| lead >= **least).count()))
        }
    }
}

/// The lowest, the middle and the highest slice of a grid.
fn slices(aligned: &Aligned, winners: &Winners) -> Option<Vec<Panel>> {
    let data = aligned.parts.first()?;
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
        let words = |axis: usize| {
            let here = number(data.axes[axis][at[axis]]);
            format!("{} = {}", coordinates[axis].label, with_unit(&here, &coordinates[axis].unit))
        };
        let fixed: Vec<usize> = (0..data.axes.len()).filter(|axis| *axis != columns && *axis != rows).collect();
        let title =
            fixed.into_iter().filter(|axis| data.axes[*axis].len() > 1).map(words).collect::<Vec<_>>().join(", ");
        let (x, y) = (&data.axes[columns], &data.axes[rows]);
        let frame = Frame::new([ends(x), ends(y)], coordinates[columns].unit == coordinates[rows].unit);
        let mut svg = frame.begin();
        for (r, [low, high]) in cells(y).into_iter().enumerate() {
            let class_of = |c: usize| {
                let mut here = at.clone();
                (here[columns], here[rows]) = (c, r);
                let node = here.iter().zip(&data.axes).rev().fold(0, |node, (i, axis)| node * axis.len() + i);
                class(winners.at[node])
            };
            let sides = cells(x);
            let mut begin = 0;
            while begin < x.len() {
                let own = class_of(begin);
                let end = (begin + 1..x.len()).find(|c| class_of(*c) != own).unwrap_or(x.len());
                if let Some(class) = own {
                    frame.cell(&mut svg, &class, [sides[begin][0], sides[end - 1][1]], [low, high]);
                }
                begin = end;
            }
        }
        frame.end(&mut svg, [&coordinates[columns], &coordinates[rows]]);
        Panel { title, svg }
    };
    Some(levels.into_iter().map(panel).collect())
}

/// The curves of all results, and below them whose is best.
fn curves(aligned: &Aligned, quantity: usize, winners: &Winners) -> Option<Panel> {
    let shared = &aligned.shared;
    let q = &shared.quantities[quantity];
    let own = |who: usize| (&aligned.data[who].axes[0], &aligned.data[who].values[quantity][0]);
    let all = (0..aligned.letters.len()).flat_map(|who| own(who).1).copied().filter(|value| value.is_finite());
    let high = all.clone().reduce(f64::max)?;
    let low = all.reduce(f64::min)?.min(0.0);
    let long = (0..aligned.letters.len()).filter_map(|who| own(who).0.last()).copied().fold(0.0, f64::max);
    let frame = Frame::new([[0.0, long.max(1e-9)], [low, if high > low { high } else { low + 1.0 }]], false);
    let mut svg = frame.begin();
    let common = aligned.parts.first().filter(|_| aligned.is_whole());
    let axis = common.and_then(|part| part.axes.first());
    for (node, [begin, end]) in axis.map(|axis| cells(axis)).unwrap_or_default().into_iter().enumerate() {
        if let Some(class) = class(winners.at[node]) {
            frame.band(&mut svg, &class, [begin.max(0.0), end.min(long)]);
        }
    }
    for who in 0..aligned.letters.len() {
        let (x, y) = own(who);
        let step = x.len().div_ceil(MOST_POINTS).max(1);
        let points = (0..x.len()).filter(|i| i % step == 0 || i + 1 == x.len()).filter(|i| y[*i].is_finite());
        let points: Vec<String> = points.map(|i| frame.point(x[i], y[i])).collect();
        // Writing to a string cannot fail.
        let _ = write!(svg, "<polyline class=\"line w{who}\" points=\"{}\"/>", points.join(" "));
    }
    frame.end(&mut svg, [&shared.coordinates[0], &Column::new("", "", "")]);
    Some(Panel { title: in_unit(&q.label, &q.unit), svg })
}

fn ends(axis: &[f64]) -> [f64; 2] {
    cells(axis).first().zip(cells(axis).last()).map_or([0.0, 1.0], |(first, last)| [first[0], last[1]])
}

/// Begin and end of what is nearest to each value of an axis.
fn cells(axis: &[f64]) -> Vec<[f64; 2]> {
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

/// Width of a drawing, its own units.
const WIDTH: f64 = 260.0;
/// Width of one that is not to scale.
const WIDE: f64 = 460.0;
const HEIGHT: f64 = 220.0;
/// Room for the axes.
const LEFT: f64 = 46.0;
const BOTTOM: f64 = 34.0;
const EDGE: f64 = 6.0;
/// From numbers to a drawing.
struct Frame {
    ends: [[f64; 2]; 2],
    size: [f64; 2],
    width: f64,
}

impl Frame {
    fn new(ends: [[f64; 2]; 2], is_to_scale: bool) -> Self {
        let all = if is_to_scale { WIDTH } else { WIDE };
        let (width, height) = (all - LEFT - EDGE, HEIGHT - BOTTOM - EDGE);
        let [x, y] = ends.map(|[low, high]| high - low);
        let scale = (width / x).min(height / y);
        let size = if is_to_scale { [x * scale, y * scale] } else { [width, height] };
        Self { ends, size, width: all }
    }

    fn x(&self, value: f64) -> f64 {
        let [low, high] = self.ends[0];
        LEFT + (value - low) / (high - low) * self.size[0]
    }

    fn y(&self, value: f64) -> f64 {
        let [low, high] = self.ends[1];
        EDGE + (high - value) / (high - low) * self.size[1]
    }

    fn point(&self, x: f64, y: f64) -> String {
        format!("{:.1},{:.1}", self.x(x), self.y(y))
    }

    fn begin(&self) -> String {
        let height = self.size[1] + BOTTOM + EDGE;
        format!("<svg viewBox=\"0 0 {:.0} {height:.0}\" role=\"img\" aria-labelledby=\"hero-title\">", self.width)
    }

    fn cell(&self, svg: &mut String, class: &str, x: [f64; 2], y: [f64; 2]) {
        let (left, top) = (self.x(x[0]), self.y(y[1]));
        let (width, height) = (self.x(x[1]) - left, self.y(y[0]) - top);
        let _ = write!(
            svg,
            "<rect class=\"{class}\" x=\"{left:.1}\" y=\"{top:.1}\" width=\"{width:.1}\" height=\"{height:.1}\"/>"
        );
    }

    /// A piece of the strip along the lower edge.
    fn band(&self, svg: &mut String, class: &str, [begin, end]: [f64; 2]) {
        let (left, top) = (self.x(begin), EDGE + self.size[1] - 8.0);
        let width = (self.x(end) - left).max(0.0);
        let _ =
            write!(svg, "<rect class=\"{class}\" x=\"{left:.1}\" y=\"{top:.1}\" width=\"{width:.1}\" height=\"8\"/>");
    }

    fn end(&self, svg: &mut String, [across, up]: [&Column; 2]) {
        let [width, height] = self.size;
        let (right, low) = (LEFT + width, EDGE + height);
        let _ = write!(
            svg,
            "<rect class=\"frame\" x=\"{LEFT}\" y=\"{EDGE}\" width=\"{width:.1}\" height=\"{height:.1}\"/>"
        );
        let mut text = |x: f64, y: f64, anchor: &str, words: String| {
            let words = escaped(&words);
            let _ = write!(svg, "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\">{words}</text>");
        };
        let [[x0, x1], [y0, y1]] = self.ends;
        text(LEFT, low + 12.0, "start", three(x0));
        text(right, low + 12.0, "end", three(x1));
        text(LEFT + 0.5 * width, low + 26.0, "middle", in_unit(&across.label, &across.unit));
        text(LEFT - 4.0, low, "end", three(y0));
        text(LEFT - 4.0, EDGE + 8.0, "end", three(y1));
        let words = escaped(&in_unit(&up.label, &up.unit));
        let middle = EDGE + 0.5 * height;
        let _ = write!(
            svg,
            "<text transform=\"translate(12 {middle:.1}) rotate(-90)\" text-anchor=\"middle\">{words}</text></svg>"
        );
    }
}

/// Words in a drawing.
fn escaped(text: &str) -> String {
    HtmlEscape(&visible(text)).to_string()
}
