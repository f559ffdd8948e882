//! The picture of a comparison's first screen: who is best where, as drawings that need no script.

use std::fmt::Write;

use serde::Serialize;

use super::{
    aligned::Aligned,
    description::{Column, Shape},
    frame::{EDGE, Frame, LEFT, WIDE, escaped},
    sentences::three,
    table::number,
    winners::{At, Winners},
};
use crate::files::words::with_unit;

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
pub(super) fn picture(aligned: &Aligned, quantity: usize, winners: &Winners, letters: &[char]) -> Option<Picture> {
    let shared = &aligned.shared;
    let label = &shared.quantities[quantity].label;
    let group = aligned.group_name(0);
    let of = if group.is_empty() { String::new() } else { format!(", {group}") };
    let is_by_place = shared.shape != Shape::Curve || aligned.common.is_whole(&aligned.data);
    let title = if is_by_place { format!("Who is best where: {label}{of}") } else { format!("{label}{of}") };
    let panels = match shared.shape {
        Shape::Grid => slices(aligned, winners)?,
        Shape::Curve => vec![curves(aligned, quantity, winners, letters)?],
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
    let data = aligned.common.parts.first()?;
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
fn curves(aligned: &Aligned, quantity: usize, winners: &Winners, letters: &[char]) -> Option<Panel> {
    let shared = &aligned.shared;
    let q = &shared.quantities[quantity];
    let own = |who: usize| (&aligned.data[who].axes[0], &aligned.data[who].values[quantity][0]);
    let all = (0..letters.len()).flat_map(|who| own(who).1).copied().filter(|value| value.is_finite());
    let high = all.clone().reduce(f64::max)?;
    let low = all.reduce(f64::min)?.min(0.0);
    let long = (0..letters.len()).filter_map(|who| own(who).0.last()).copied().fold(0.0, f64::max);
    let frame = Frame::new([[0.0, long.max(1e-9)], [low, if high > low { high } else { low + 1.0 }]], false);
    let mut svg = frame.begin();
    let common = aligned.common.parts.first().filter(|_| aligned.common.is_whole(&aligned.data));
    let axis = common.and_then(|part| part.axes.first());
    for (node, [begin, end]) in axis.map(|axis| cells(axis)).unwrap_or_default().into_iter().enumerate() {
        if let Some(class) = class(winners.at[node]) {
            frame.band(&mut svg, &class, [begin.max(0.0), end.min(long)]);
        }
    }
    for who in 0..letters.len() {
        let (x, y) = own(who);
        let step = x.len().div_ceil(MOST_POINTS).max(1);
        let points = (0..x.len()).filter(|i| i % step == 0 || i + 1 == x.len()).filter(|i| y[*i].is_finite());
        let points: Vec<String> = points.map(|i| frame.point(x[i], y[i])).collect();
        // Writing to a string cannot fail.
        let _ = write!(svg, "<polyline class=\"line w{who}\" points=\"{}\"/>", points.join(" "));
    }
    frame.end(&mut svg, [&shared.coordinates[0], &Column::new("", "", "")]);
    Some(Panel { title: super::aligned::in_unit(&q.label, &q.unit), svg })
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
