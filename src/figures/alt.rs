//! What a figure shows: its caption, a text for readers who do not see it, and the points of its curves as a table.

use super::{AgreementFigure, Figure, LineFigure, PanelFigure, PlanFigure, PoseFigure, SliceFigure, VolumeFigure};
use crate::files::exchange::{Column, Row, Table, counts, numbers, texts};

impl Figure {
    /// Title and setting.
    pub fn caption(&self) -> String {
        let (title, subtitle) = match self {
            Self::Slices(figure) => (&figure.title, &figure.subtitle),
            Self::Volume(figure) => (&figure.title, &figure.subtitle),
            Self::Lines(figure) => (&figure.title, &figure.subtitle),
            Self::Panels(figure) => (&figure.title, &figure.subtitle),
            Self::Plan(figure) => (&figure.title, &figure.subtitle),
            Self::Agreement(figure) => (&figure.title, &figure.subtitle),
            Self::Pose(figure) => (&figure.title, &figure.subtitle),
        };
        let remark = if let Self::Slices(figure) = self { figure.remark.as_str() } else { "" };
        let parts = [title, subtitle.as_str(), remark].into_iter().filter(|part| !part.is_empty());
        parts.collect::<Vec<_>>().join(". ")
    }

    /// The kind of figure, what is drawn, and its range.
    pub fn alternative(&self) -> String {
        match self {
            Self::Slices(figure) => slices(figure),
            Self::Volume(figure) => volume(figure),
            Self::Lines(figure) => lines(figure),
            Self::Panels(figure) => panels(figure),
            Self::Plan(figure) => plan(figure),
            Self::Agreement(figure) => agreement(figure),
            Self::Pose(figure) => pose(figure),
        }
    }
}

/// Smallest and largest of the values, in words.
fn range(values: impl Iterator<Item = f64>) -> String {
    let ends = values.fold(None, |ends: Option<(f64, f64)>, value| {
        Some(ends.map_or((value, value), |(low, high)| (low.min(value), high.max(value))))
    });
    ends.map_or_else(|| "without values".into(), |(low, high)| format!("from {} to {}", number(low), number(high)))
}

/// Four significant digits.
fn number(value: f64) -> String {
    let digits = if value == 0.0 { 0 } else { (3.0 - value.abs().log10().floor()).clamp(0.0, 12.0) as usize };
    let text = format!("{value:.digits$}");
    text.replace('-', "\u{2212}")
}

fn slices(figure: &SliceFigure) -> String {
    let titles: Vec<&str> = figure.panels.iter().map(|panel| panel.title.as_str()).collect();
    let values = figure.panels.iter().flat_map(|panel| panel.values.iter().flatten().copied());
    format!(
        "Colour maps of {} over {} and {}, {}; values {}.",
        figure.quantity,
        figure.x_label,
        figure.y_label,
        titles.join("; "),
        range(values)
    )
}

fn volume(figure: &VolumeFigure) -> String {
    format!(
        "Three outer faces of the workspace box coloured by {}; values in the box {}.",
        figure.quantity,
        range(figure.values.iter().flatten().copied())
    )
}

fn lines(figure: &LineFigure) -> String {
    let curves: Vec<String> = figure
        .series
        .iter()
        .filter(|series| !series.points.is_empty())
        .map(|series| {
            let values = range(series.points.iter().map(|point| point.1));
            if series.label.is_empty() { values } else { format!("{} ({values})", series.label) }
        })
        .collect();
    let note = figure.closed_note.as_ref().map_or_else(String::new, |note| format!(" {note}."));
    format!("Curves of {} over {}: {}.{note}", figure.y_label, figure.x_label, curves.join(", "))
}

fn panels(figure: &PanelFigure) -> String {
    let names: Vec<&str> = figure.curves.iter().map(|(name, _)| name.as_str()).collect();
    let panels: Vec<String> = figure
        .panels
        .iter()
        .map(|panel| {
            let values = panel.curves.iter().flat_map(|curve| curve.pieces.iter().flatten()).map(|point| point.1);
            format!("{} ({})", panel.title, range(values))
        })
        .collect();
    let note = if figure.note.is_empty() { String::new() } else { format!(" {}.", figure.note) };
    format!(
        "Curves of {} over {}, {}, in frames side by side: {}.{note}",
        figure.y_label,
        figure.x_label,
        names.join(", "),
        panels.join("; ")
    )
}

fn plan(figure: &PlanFigure) -> String {
    let shapes = figure.shapes.iter().map(|shape| shape.label.as_str());
    let marks = figure.marks.iter().map(|mark| mark.2.as_str());
    let labels: Vec<String> =
        marks.chain(shapes).filter(|label| !label.is_empty()).map(|label| label.replace('\n', " ")).collect();
    let values = figure.field.iter().flat_map(|field| field.values.iter().flatten().copied());
    let values = values.chain(figure.coloured.iter().flatten().map(|point| point.2));
    let colours = match figure.quantity.as_str() {
        "" => String::new(),
        quantity => format!(", coloured by {quantity} {}", range(values)),
    };
    let note = if figure.note.is_empty() { String::new() } else { format!(" {}.", figure.note) };
    format!("Plan over {} and {}{colours}: {}.{note}", figure.x_label, figure.y_label, labels.join("; "))
}

fn agreement(figure: &AgreementFigure) -> String {
    let row = |row: &super::AgreementRow| {
        format!("{}, {}: {}", row.label, row.numbers, if row.agrees { "agrees" } else { "differs" })
    };
    let rows: Vec<String> = figure.rows.iter().map(row).collect();
    format!("Numbers, {}, each as its difference in tolerances. {}.", figure.numbers, rows.join("; "))
}

fn pose(figure: &PoseFigure) -> String {
    let chains: Vec<&str> = figure.pose.chains.iter().map(|chain| chain.name.as_str()).collect();
    let drawn = if figure.displaced.is_some() { ", as commanded and in equilibrium" } else { "" };
    let note = figure.note.as_ref().map_or_else(String::new, |note| format!(" {note}."));
    let springs = if figure.pose.springs().next().is_some() { ", springs" } else { "" };
    let masses = if figure.pose.masses().next().is_some() { ", masses" } else { "" };
    format!(
        "Line drawing of the machine with chains {}{drawn}, its joints{springs}{masses}, tool and workspace box.{note}",
        chains.join(", ")
    )
}

/// Columns of curves; the axes have their units in brackets, as in the figure.
fn columns(lead: &[&str], axes: [&str; 2]) -> Vec<Column> {
    [texts(lead.iter().copied()), texts(["curve"]), counts(["piece"]), numbers(axes), texts(["note"])].concat()
}

fn rows<'a>(
    lead: &'a Row,
    piece: usize,
    points: &'a [(f64, f64)],
    note: Option<&'a str>,
) -> impl Iterator<Item = Row> + 'a {
    points.iter().map(move |(x, y)| {
        let mut row = lead.clone();
        row.extend([(piece + 1).into(), (*x).into(), (*y).into(), note.into()]);
        row
    })
}

impl Figure {
    /// The points drawn: a row per point with panel, curve and uninterrupted piece of the curve, and what a reader must not
    /// miss, such as amplified errors. `None` for maps, whose values are in the tables of their study, and for drawings of the
    /// machine.
    pub fn data(&self) -> Option<Table> {
        match self {
            Figure::Slices(_) | Figure::Volume(_) | Figure::Plan(_) | Figure::Agreement(_) | Figure::Pose(_) => None,
            Figure::Lines(figure) => {
                let mut all = Vec::new();
                for series in &figure.series {
                    let lead = vec![series.label.as_str().into()];
                    all.extend(rows(&lead, 0, &series.points, figure.closed_note.as_deref()));
                }
                Some(Table::new(columns(&[], [&figure.x_label, &figure.y_label]), all))
            }
            Figure::Panels(figure) => {
                let mut all = Vec::new();
                for panel in &figure.panels {
                    for ((label, _), curve) in figure.curves.iter().zip(&panel.curves) {
                        let lead = vec![panel.title.as_str().into(), label.as_str().into()];
                        for (piece, points) in curve.pieces.iter().enumerate() {
                            all.extend(rows(&lead, piece, points, Some(&figure.note)));
                        }
                    }
                }
                Some(Table::new(columns(&["panel"], [&figure.x_label, &figure.y_label]), all))
            }
        }
    }
}
