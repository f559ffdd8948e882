//! Values on a grid as coloured cells.

use super::colour_bar::Scale;
use super::scene::{Picture, Point, Rect, Rgb};
use super::style::{HATCH, MISSING};

/// Picture pixels per page pixel.
const DENSITY: f64 = 2.0;
/// Period and thickness of the hatching in picture pixels.
const HATCHING: (usize, usize) = (20, 5);

/// Borders of the cells around `nodes`: half-way between neighbours and at the outer nodes themselves, so that the
/// cells end where the grid ends and the outer cells are half as wide. A lone node gets `lone` on both sides.
pub(super) fn cell_edges(nodes: &[f64], lone: f64) -> Vec<f64> {
    match nodes {
        [] => vec![],
        [node] => vec![node - lone, node + lone],
        [first, .., last] => {
            let between = nodes.windows(2).map(|pair| 0.5 * pair[0] + 0.5 * pair[1]);
            std::iter::once(*first).chain(between).chain(std::iter::once(*last)).collect()
        }
    }
}

/// Half-width of cells around lone nodes: one twentieth of the longest axis, or one half if every axis is a lone node.
pub(super) fn lone_half_width(axes: &[&[f64]]) -> f64 {
    let lengths = axes.iter().map(|nodes| match nodes {
        [first, .., last] => last - first,
        _ => 0.0,
    });
    let longest = lengths.fold(0.0, f64::max);
    if longest > 0.0 { 0.05 * longest } else { 0.5 }
}

/// Colour of a picture pixel in a cell without a value.
pub(super) fn hatched(column: usize, row: usize) -> Rgb {
    let (period, thickness) = HATCHING;
    if (column + row) % period < thickness { HATCH } else { MISSING }
}

/// Pixels over an upright rectangle; `paint` fills the given columns and rows.
pub(super) fn picture(rect: Rect, paint: impl FnOnce(usize, usize) -> Vec<Rgb>) -> Picture {
    parallelogram([rect.x, rect.y], [rect.width, 0.0], [0.0, rect.height], paint)
}

/// Pixels over a parallelogram.
pub(super) fn parallelogram(
    origin: Point,
    across: Point,
    down: Point,
    paint: impl FnOnce(usize, usize) -> Vec<Rgb>,
) -> Picture {
    let count = |side: Point| (DENSITY * side[0].hypot(side[1])).round().max(1.0) as usize;
    let (columns, rows) = (count(across), count(down));
    Picture { origin, across, down, columns, rows, pixels: paint(columns, rows) }
}

/// A plane of cells: columns to the right, rows upward.
pub(super) struct Cells<'a> {
    pub column_edges: &'a [f64],
    pub row_edges: &'a [f64],
    pub scale: Option<Scale>,
}

impl Cells<'_> {
    /// Pixels from the upper left, coloured by `value(column, row)` of the cell they lie in.
    pub fn paint(&self, columns: usize, rows: usize, value: impl Fn(usize, usize) -> Option<f64>) -> Vec<Rgb> {
        let column_cells = cells_of_pixels(self.column_edges, columns);
        let row_cells = cells_of_pixels(self.row_edges, rows);
        let mut pixels = Vec::with_capacity(columns * rows);
        for (y, row) in row_cells.iter().rev().enumerate() {
            for (x, column) in column_cells.iter().enumerate() {
                let coloured = value(*column, *row).zip(self.scale).map(|(v, scale)| scale.colour(v));
                pixels.push(coloured.unwrap_or_else(|| hatched(x, y)));
            }
        }
        pixels
    }
}

/// The cell in which the centre of each of `count` equal parts of the axis lies.
fn cells_of_pixels(edges: &[f64], count: usize) -> Vec<usize> {
    let (Some(first), Some(last)) = (edges.first(), edges.last()) else { return vec![] };
    let centre = |i: usize| first + (last - first) * (i as f64 + 0.5) / count as f64;
    let most = edges.len().saturating_sub(2);
    (0..count).map(|i| edges.partition_point(|e| *e <= centre(i)).saturating_sub(1).min(most)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_end_at_the_outer_nodes() {
        assert_eq!(cell_edges(&[0.0, 2.0, 4.0], 1.0), [0.0, 1.0, 3.0, 4.0]);
        assert_eq!(cell_edges(&[3.0], 0.5), [2.5, 3.5]);
    }

    #[test]
    fn pixels_take_the_nearest_node() {
        assert_eq!(cells_of_pixels(&[0.0, 1.0, 3.0, 4.0], 4), [0, 1, 1, 2]);
    }
}
