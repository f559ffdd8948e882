//! Captions of figures, their descriptions for readers who cannot see them, and the points of their curves as tables.

use super::{
    AgreementFigure, BudgetBar, BudgetFigure, FaceValue, Figure, LineFigure, PanelFigure, PartFigure, PlanFigure,
    PoseFigure, SliceFigure, VolumeFigure,
};
use crate::files::exchange::{Column, Row, Table, counts, numbers, texts};

impl Figure {
    /// Returns the remark that is not drawn; empty where all is.
    pub fn caption(&self) -> String {
        if let Self::Slices(figure) = self { figure.remark.clone() } else { String::new() }
    }

    /// Describes in words the kind of figure, what it shows and the range of its values.
    pub fn alternative_text(&self) -> String {
        match self {
            Self::Slices(figure) => describe_slices(figure),
            Self::Volume(figure) => describe_volume(figure),
            Self::Lines(figure) => describe_lines(figure),
            Self::Panels(figure) => describe_panels(figure),
            Self::Plan(figure) => describe_plan(figure),
            Self::Agreement(figure) => describe_agreement(figure),
            Self::Budget(figure) => describe_budget(figure),
            Self::Pose(figure) => describe_pose(figure),
            Self::Part(figure) => describe_part(figure),
        }
    }
}

/// Describes a part in words.
fn describe_part(figure: &PartFigure) -> String {
    let view = |(title, values): &(String, Vec<FaceValue>)| {
        let values =
            values.iter().filter_map(|face| if let FaceValue::Value(value) = face { Some(*value) } else { None });
        format!("{title} {}", range_in_text(values))
    };
    let views: Vec<String> = figure.views.iter().map(view).collect();
    format!("The part seen obliquely from above, coloured by {}: {}.", figure.quantity, views.join("; "))
}

/// Returns the smallest and largest of `values` as "from … to …"; "without values" if there are none.
fn range_in_text(values: impl Iterator<Item = f64>) -> String {
    let ends = values.fold(None, |ends: Option<(f64, f64)>, value| {
        Some(ends.map_or((value, value), |(low, high)| (low.min(value), high.max(value))))
    });
    ends.map_or_else(|| "without values".into(), |(low, high)| format!("from {} to {}", rounded(low), rounded(high)))
}

/// Returns a number as text with four significant digits and a true minus sign.
fn rounded(value: f64) -> String {
    let digits = if value == 0.0 { 0 } else { (3.0 - libm::log10(value.abs()).floor()).clamp(0.0, 12.0) as usize };
    let text = format!("{value:.digits$}");
    text.replace('-', "\u{2212}")
}

/// Describes a figure of colour maps in words.
fn describe_slices(figure: &SliceFigure) -> String {
    let titles: Vec<&str> = figure.panels.iter().map(|panel| panel.title.as_str()).collect();
    let values = figure.panels.iter().flat_map(|panel| panel.values.iter().flatten().copied());
    format!(
        "Colour maps of {} over {} and {}, {}; values {}.",
        figure.quantity,
        figure.x_label,
        figure.y_label,
        titles.join("; "),
        range_in_text(values)
    )
}

/// Describes a figure of a coloured box in words.
fn describe_volume(figure: &VolumeFigure) -> String {
    format!(
        "Three outer faces of the workspace box coloured by {}; values in the box {}.",
        figure.quantity,
        range_in_text(figure.values.iter().flatten().copied())
    )
}

/// Describes a figure of curves in words.
fn describe_lines(figure: &LineFigure) -> String {
    // Beside the largest value, rounding is none.
    let all = figure.series.iter().flat_map(|series| series.points.iter().map(|point| point.1.abs()));
    let least = if figure.log_y { 0.0 } else { 1e-8 * all.fold(0.0, f64::max) };
    let curves: Vec<String> = figure
        .series
        .iter()
        .filter(|series| !series.points.is_empty())
        .map(|series| {
            let values =
                range_in_text(series.points.iter().map(|point| if point.1.abs() < least { 0.0 } else { point.1 }));
            if series.label.is_empty() { values } else { format!("{} ({values})", series.label) }
        })
        .collect();
    let note = figure.closed_note.as_ref().map_or_else(String::new, |note| format!(" {note}."));
    format!("Curves of {} over {}: {}.{note}", figure.y_label, figure.x_label, curves.join(", "))
}

/// Describes a figure of panels in words.
fn describe_panels(figure: &PanelFigure) -> String {
    let names: Vec<&str> = figure.curves.iter().map(|(name, _)| name.as_str()).collect();
    let panels: Vec<String> = figure
        .panels
        .iter()
        .map(|panel| {
            let values = panel.curves.iter().flat_map(|curve| curve.pieces.iter().flatten()).map(|point| point.1);
            format!("{} ({})", panel.title, range_in_text(values))
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

/// Describes a plan in words.
fn describe_plan(figure: &PlanFigure) -> String {
    let shapes = figure.shapes.iter().map(|shape| shape.label.as_str());
    let marks = figure.marks.iter().map(|mark| mark.2.as_str());
    let labels: Vec<String> =
        marks.chain(shapes).filter(|label| !label.is_empty()).map(|label| label.replace('\n', " ")).collect();
    let values = figure.field.iter().flat_map(|field| field.values.iter().flatten().copied());
    let values = values.chain(figure.coloured.iter().flatten().map(|point| point.2));
    let colours = match figure.quantity.as_str() {
        "" => String::new(),
        quantity => format!(", coloured by {quantity} {}", range_in_text(values)),
    };
    let note = if figure.note.is_empty() { String::new() } else { format!(" {}.", figure.note) };
    format!("Plan over {} and {}{colours}: {}.{note}", figure.x_label, figure.y_label, labels.join("; "))
}

/// Describes causes of error in words.
fn describe_budget(figure: &BudgetFigure) -> String {
    let row = |row: &super::BudgetRow| match row.bar {
        BudgetBar::Unknown => format!("{}: unknown", row.label),
        _ => format!("{}: {}", row.label, row.words),
    };
    let rows: Vec<String> = figure.rows.iter().map(row).collect();
    let tolerance = figure.tolerance_mm.map_or_else(String::new, |own| format!(", of a tolerance of {own} mm"));
    format!("Bars, one for each cause of error{tolerance}. {}.", rows.join("; "))
}

/// Describes a comparison of numbers in words.
fn describe_agreement(figure: &AgreementFigure) -> String {
    let row = |row: &super::AgreementRow| {
        format!("{}, {}: {}", row.label, row.numbers.join(", "), if row.agrees { "agrees" } else { "differs" })
    };
    let rows: Vec<String> = figure.rows.iter().map(row).collect();
    format!("Numbers, {}, each as its difference in tolerances. {}.", figure.numbers.join(", "), rows.join("; "))
}

/// Describes a drawing of a machine in words.
fn describe_pose(figure: &PoseFigure) -> String {
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

/// Returns the columns of a table of curve points: `lead`, curve, piece, both axes (units in brackets as in the figure) and note.
fn curve_columns(lead: &[&str], axes: [&str; 2]) -> Vec<Column> {
    [texts(lead.iter().copied()), texts(["curve"]), counts(["piece"]), numbers(axes), texts(["note"])].concat()
}

/// Yields a table row for each point of a piece of a curve: `lead`, number of the piece from 1, x, y, note.
fn curve_rows<'a>(
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
    /// Returns a table with a row for each point drawn: panel, curve, uninterrupted piece of the curve, coordinates and the figure's
    /// note. `None` for figures other than curves: the values of maps are in the tables of their study.
    pub fn data(&self) -> Option<Table> {
        match self {
            Figure::Slices(_) | Figure::Volume(_) | Figure::Plan(_) => None,
            Figure::Agreement(_) | Figure::Budget(_) | Figure::Pose(_) | Figure::Part(_) => None,
            Figure::Lines(figure) => {
                let mut all = Vec::new();
                for series in &figure.series {
                    let lead = vec![series.label.as_str().into()];
                    all.extend(curve_rows(&lead, 0, &series.points, figure.closed_note.as_deref()));
                }
                Some(Table::new(curve_columns(&[], [&figure.x_label, &figure.y_label]), all))
            }
            Figure::Panels(figure) => {
                let mut all = Vec::new();
                for panel in &figure.panels {
                    for ((label, _), curve) in figure.curves.iter().zip(&panel.curves) {
                        let lead = vec![panel.title.as_str().into(), label.as_str().into()];
                        for (piece, points) in curve.pieces.iter().enumerate() {
                            all.extend(curve_rows(&lead, piece, points, Some(&figure.note)));
                        }
                    }
                }
                Some(Table::new(curve_columns(&["panel"], [&figure.x_label, &figure.y_label]), all))
            }
        }
    }
}
