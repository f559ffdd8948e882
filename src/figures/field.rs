//! Values on a grid, drawn as coloured cells.

use super::drawing::Point;

/// Distance between hatching lines along the sides of a picture, in pixels.
const HATCH_PITCH: f64 = 22.0;

/// A colour with its opacity, 8 bits per channel.
pub type Rgba = [u8; 4];

/// Returns the edges of the cells around `nodes`: half-way between neighbours, and at the outer nodes themselves, so that outer cells are
/// half as wide. A single node gets `lone` on both sides.
fn cell_edges(nodes: &[f64], lone: f64) -> Vec<f64> {
    match nodes {
        [] => vec![],
        [node] => vec![node - lone, node + lone],
        [first, .., last] => {
            let between = nodes.windows(2).map(|pair| 0.5 * pair[0] + 0.5 * pair[1]);
            std::iter::once(*first).chain(between).chain(std::iter::once(*last)).collect()
        }
    }
}

/// Returns the half-width of a cell around a single node: one twentieth of the longest axis, or 0.5 if every axis has a single node.
fn lone_half_width(axes: &[&[f64]]) -> f64 {
    let lengths = axes.iter().map(|nodes| match nodes {
        [first, .., last] => last - first,
        _ => 0.0,
    });
    let longest = lengths.fold(0.0, f64::max);
    if longest > 0.0 { 0.05 * longest } else { 0.5 }
}

/// Returns the edges of the cells around the nodes of each axis, in the unit of the nodes; see [`Picture`].
pub fn edges<const N: usize>(axes: [&[f64]; N]) -> [Vec<f64>; N] {
    let lone = lone_half_width(&axes);
    axes.map(|nodes| cell_edges(nodes, lone))
}

/// A grid of coloured cells, stretched over the parallelogram `origin`, `origin + across`, `origin + down`.
#[derive(Debug, Clone, PartialEq)]
pub struct Picture {
    /// Its corner on the page.
    pub origin: Point,
    /// Side along the columns, as a vector from `origin`.
    pub across: Point,
    /// Side along the rows, as a vector from `origin`.
    pub down: Point,
    /// Edges of the columns and of the rows as fractions of `across` and `down`, from 0 to 1.
    borders: [Vec<f64>; 2],
    /// Colours of the cells, row by row from the top; cells without a colour are hatched.
    colours: Vec<Option<Rgba>>,
}

impl Picture {
    /// Returns the cells between the edges, columns to the right and rows upward, with the colours `colour(column, row)`; `None`: hatched.
    pub fn new(
        [origin, across, down]: [Point; 3],
        column_edges: &[f64],
        row_edges: &[f64],
        colour: impl Fn(usize, usize) -> Option<Rgba>,
    ) -> Self {
        let fractions = |edges: &[f64]| -> Vec<f64> {
            let (first, last) = (edges[0], edges[edges.len() - 1]);
            edges.iter().map(|edge| (edge - first) / (last - first)).collect()
        };
        let rows = fractions(row_edges).iter().rev().map(|upward| 1.0 - upward).collect();
        let columns = column_edges.len() - 1;
        let places = (0..row_edges.len() - 1).rev().flat_map(|row| (0..columns).map(move |column| (column, row)));
        let colours = places.map(|(column, row)| colour(column, row)).collect();
        Self { origin, across, down, borders: [fractions(column_edges), rows], colours }
    }

    /// Returns the lengths of `across` and `down` in pixels.
    pub fn lengths(&self) -> [f64; 2] {
        [self.across, self.down].map(|side| libm::hypot(side[0], side[1]))
    }

    /// Returns the point on the page at fractions (u, v) of `across` and `down`.
    pub fn page_point(&self, [u, v]: [f64; 2]) -> Point {
        [0, 1].map(|axis| self.origin[axis] + u * self.across[axis] + v * self.down[axis])
    }

    /// Yields each cell: its ends along `across` and along `down` as fractions, and its colour.
    pub fn cells(&self) -> impl Iterator<Item = ([f64; 2], [f64; 2], Option<Rgba>)> {
        let [columns, rows] = &self.borders;
        let cells = rows.windows(2).flat_map(|v| columns.windows(2).map(move |u| ([u[0], u[1]], [v[0], v[1]])));
        cells.zip(&self.colours).map(|((u, v), colour)| (u, v, *colour))
    }

    /// Returns the fewest equal parts of both sides such that cell edges lie between parts, or a large number if there are none.
    pub(crate) fn pixel_counts(&self) -> [u32; 2] {
        [0, 1].map(|side| {
            let borders = &self.borders[side];
            let most = 2 * borders.len() as u32;
            let lies_between = |parts: &u32| {
                borders.iter().all(|border| {
                    let at = border * f64::from(*parts);
                    (at - at.round()).abs() < 1e-6
                })
            };
            (1..=most).find(lies_between).unwrap_or(8 * most)
        })
    }

    /// Returns the slanted lines over the cells without a colour.
    pub fn hatching(&self) -> Vec<[Point; 2]> {
        let mut out = Vec::new();
        if self.colours.iter().all(Option::is_some) {
            return out;
        }
        let [width, height] = self.lengths();
        let [columns, rows] = &self.borders;
        let index = |borders: &[f64], at: f64| borders.partition_point(|b| *b <= at).clamp(1, borders.len() - 1) - 1;
        for line in 1..=((width + height) / HATCH_PITCH) as usize {
            // The line on which the distances from the left and from the top add up to `sum`.
            let sum = line as f64 * HATCH_PITCH;
            let at = |x: f64| [x / width, (sum - x) / height];
            let ends = (sum - height).max(0.0)..=sum.min(width);
            let crossings = columns.iter().map(|u| u * width).chain(rows.iter().map(|v| sum - v * height));
            let mut stops: Vec<f64> = crossings.filter(|x| ends.contains(x)).collect();
            stops.sort_by(f64::total_cmp);
            let mut start = None;
            for pair in stops.windows(2) {
                let [u, v] = at((pair[0] + pair[1]) / 2.0);
                let missing = self.colours[index(rows, v) * (columns.len() - 1) + index(columns, u)].is_none();
                match start {
                    None if missing => start = Some(pair[0]),
                    Some(from) if !missing => {
                        out.push([from, pair[0]].map(|x| self.page_point(at(x))));
                        start = None;
                    }
                    _ => {}
                }
            }
            out.extend(start.zip(stops.last()).map(|(from, to)| [from, *to].map(|x| self.page_point(at(x)))));
        }
        out
    }
}
