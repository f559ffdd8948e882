//! The points of curves as a table.

use super::Figure;
use crate::files::exchange::{Column, Row, Table, counts, numbers, texts};

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
