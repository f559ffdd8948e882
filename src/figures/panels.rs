//! Figure of the same curves in several situations, in panels side by side.

use super::axis::{self, Axis, Plot, Spacing};
use super::curves::{CurveStyle, Legend};
use super::drawing::{Anchor, Drawing, Point, Rect, Stroke, Text};
use super::error::{FigureError, check_drawable};
use super::style::{self, BORDER, GRID, Sizes};
use super::text::{self, LINE_PITCH, Weight};

/// Most panels in one figure.
const MAX_PANELS: usize = 6;
/// Height of a panel with free axes, and the most with equal ones, in pixels.
const FRAME_HEIGHT: f64 = 560.0;
const TALLEST_EQUAL: f64 = 760.0;
/// Space between the columns.
const GAP: f64 = 36.0;
/// Share of the range left blank on each side.
const MARGIN: f64 = 0.04;

/// One curve of a panel, in separate pieces that are not joined.
#[derive(Debug, Clone, PartialEq)]
pub struct PanelCurve {
    /// Points (x, y) of each piece, joined in order.
    pub pieces: Vec<Vec<(f64, f64)>>,
}

/// One panel: a plot with its own title and curves.
#[derive(Debug, Clone, PartialEq)]
pub struct CurvePanel {
    /// Title above the panel.
    pub title: String,
    /// Its curves, in the order of [`PanelFigure::curves`]; a curve may be empty.
    pub curves: Vec<PanelCurve>,
}

/// Up to six panels with the same curves.
#[derive(Debug, Clone, PartialEq)]
pub struct PanelFigure {
    /// Question that the figure answers.
    pub title: String,
    /// Conditions of the computation.
    pub subtitle: String,
    /// Label of the horizontal axes, for example "x \[mm\]".
    pub x_label: String,
    /// Label of the vertical axes, for example "y \[mm\]".
    pub y_label: String,
    /// Names of the curves in the legend, and whether they are dashed; the first one is black.
    pub curves: Vec<(String, bool)>,
    /// The panels, two in a row, or one on a telephone.
    pub panels: Vec<CurvePanel>,
    /// Whether one unit is equally long on both axes and in all panels. Otherwise all panels have the same axes.
    pub equal_axes: bool,
    /// Remark a reader must not miss.
    pub note: String,
}

impl CurvePanel {
    /// Yields all points of the panel's curves.
    fn points(&self) -> impl Iterator<Item = &(f64, f64)> {
        self.curves.iter().flat_map(|curve| curve.pieces.iter().flatten())
    }
}

impl PanelFigure {
    /// Checks that there is a point, there are not too many panels, and every point can be drawn.
    fn check(&self) -> Result<(), FigureError> {
        if self.panels.iter().all(|panel| panel.points().next().is_none()) {
            return Err(FigureError::Empty { what: "figure of panels".into() });
        }
        if self.panels.len() > MAX_PANELS {
            return Err(FigureError::TooManyPanels { found: self.panels.len(), most: MAX_PANELS });
        }
        self.panels.iter().try_for_each(|panel| {
            check_drawable(panel.points().flat_map(|p| [p.0, p.1]), || format!("panel \"{}\"", panel.title))
        })
    }

    /// Returns the ranges of x and y of each panel: the same for all, or with equal axes of equal length around each panel's own middle.
    fn ranges(&self) -> Vec<[(f64, f64); 2]> {
        if !self.equal_axes {
            let all = || self.panels.iter().flat_map(CurvePanel::points);
            let shared = [axis::range(all().map(|p| p.0), MARGIN), axis::range(all().map(|p| p.1), MARGIN)];
            return vec![shared; self.panels.len()];
        }
        let panel_ranges = |panel: &CurvePanel| {
            [axis::range(panel.points().map(|p| p.0), MARGIN), axis::range(panel.points().map(|p| p.1), MARGIN)]
        };
        let panel_ranges: Vec<_> = self.panels.iter().map(panel_ranges).collect();
        let longest = |i: usize| panel_ranges.iter().map(|r: &[(f64, f64); 2]| r[i].1 - r[i].0).fold(0.0, f64::max);
        let lengths = [longest(0), longest(1)];
        panel_ranges.iter().map(|range| [0, 1].map(|i| centred_range(range[i], lengths[i]))).collect()
    }
}

/// Returns the range of this length around the middle of `range`.
fn centred_range(range: (f64, f64), length: f64) -> (f64, f64) {
    let middle = f64::midpoint(range.0, range.1);
    (middle - length / 2.0, middle + length / 2.0)
}

/// Lays the figure out; `Err` when its data cannot be drawn.
pub(super) fn drawing(figure: &PanelFigure, sizes: Sizes) -> Result<Drawing, FigureError> {
    figure.check()?;
    let (mut drawing, top) = style::page_with_heading(&figure.title, &figure.subtitle, sizes);
    let longest = |index: usize| {
        let count = |panel: &CurvePanel| panel.curves.get(index).map_or(0, |c| c.pieces.iter().map(Vec::len).sum());
        figure.panels.iter().map(count).max().unwrap_or(0)
    };
    let styles = CurveStyle::of(figure.curves.iter().enumerate().map(|(index, (_, dashed))| (longest(index), *dashed)));
    let grid = Layout::new(figure, sizes, top);
    for (index, panel) in figure.panels.iter().enumerate() {
        let plot = grid.plot(index);
        for (above, line) in title_lines(panel, plot.rect.width, sizes).into_iter().rev().enumerate() {
            let title_at = [plot.rect.x, plot.rect.y - (0.45 + above as f64 * LINE_PITCH) * sizes.body];
            drawing.text(Text::new(line, sizes.body, title_at, Anchor::Start).bold());
        }
        plot.draw_grid(&mut drawing, Stroke { colour: GRID, width: 1.5, dash: &[] });
        let is_lowest = index / grid.columns + 1 == figure.panels.len().div_ceil(grid.columns);
        plot.draw_x_axis(&mut drawing, if is_lowest { &figure.x_label } else { "" }, sizes.body, sizes.tick);
        let is_first = index.is_multiple_of(grid.columns);
        plot.draw_y_axis(&mut drawing, if is_first { &figure.y_label } else { "" }, sizes.body, sizes.tick);
        for (curve_index, (curve, style)) in panel.curves.iter().zip(&styles).enumerate() {
            let placed = |piece: &Vec<(f64, f64)>| piece.iter().map(|(x, y)| plot.page_point(*x, *y)).collect();
            let pieces: Vec<Vec<Point>> = curve.pieces.iter().map(placed).collect();
            pieces.iter().for_each(|piece| style.draw_line(&mut drawing, piece));
            style.draw_markers(&mut drawing, &pieces.concat(), curve_index);
        }
        plot.draw_frame(&mut drawing);
    }
    let legend = Legend {
        entries: figure.curves.iter().map(|(name, _)| name.as_str()).zip(&styles).collect(),
        note: &figure.note,
        size: sizes.body,
    };
    let room = Rect { x: grid.left, y: grid.bottom(figure), width: sizes.width - BORDER - grid.left, height: 0.0 };
    drawing.height = legend.draw(&mut drawing, room) + BORDER;
    Ok(drawing)
}

/// Returns the title of a panel, wrapped to `width` pixels.
fn title_lines(panel: &CurvePanel, width: f64, sizes: Sizes) -> Vec<String> {
    text::wrap(&panel.title, sizes.body, Weight::Bold, width)
}

/// Positions and sizes of the panels on the page, in pixels, with room beside plots for tick labels and above them for titles.
struct Layout {
    sizes: Sizes,
    columns: usize,
    left: f64,
    top: f64,
    width: f64,
    height: f64,
    ranges: Vec<[(f64, f64); 2]>,
    x_spacing: Spacing,
    beside: f64,
    title: f64,
}

impl Layout {
    /// Lays out the panels of `figure` below `top`.
    fn new(figure: &PanelFigure, sizes: Sizes, top: f64) -> Self {
        let (columns, ranges) = (figure.panels.len().min(sizes.columns), figure.ranges());
        let beside = |[_, (low, high)]: &[(f64, f64); 2]| {
            Axis::vertical(*low, *high, Spacing::Linear, FRAME_HEIGHT, sizes.tick).depth_beside(sizes.tick)
        };
        let beside = ranges.iter().map(beside).fold(0.0, f64::max);
        let left = BORDER + axis::label_depth(sizes.body) + beside;
        let gaps = (columns - 1) as f64 * (GAP + beside);
        let mut width = (sizes.width - left - 2.0 * BORDER - gaps) / columns as f64;
        let mut height = FRAME_HEIGHT;
        if let (true, Some([x, y])) = (figure.equal_axes, ranges.first()) {
            let scale = (width / (x.1 - x.0)).min(TALLEST_EQUAL / (y.1 - y.0));
            (width, height) = (scale * (x.1 - x.0), scale * (y.1 - y.0));
        }
        let title_rows = figure.panels.iter().map(|panel| title_lines(panel, width, sizes).len()).max().unwrap_or(1);
        let title = (0.2 + LINE_PITCH * title_rows as f64) * sizes.body;
        Self {
            sizes,
            columns,
            left,
            top: top + title,
            width,
            height,
            ranges,
            x_spacing: Spacing::for_label(&figure.x_label),
            beside,
            title,
        }
    }

    /// Returns the distance from one row of panels to the next, in pixels.
    fn pitch(&self) -> f64 {
        self.height + axis::depth_below(self.sizes.tick) + self.title
    }

    /// Returns the plot of the panel `index`.
    fn plot(&self, index: usize) -> Plot {
        let (row, column) = (index / self.columns, index % self.columns);
        let rect = Rect {
            x: self.left + column as f64 * (self.width + GAP + self.beside),
            y: self.top + row as f64 * self.pitch(),
            width: self.width,
            height: self.height,
        };
        let [x, y] = self.ranges[index];
        Plot {
            rect,
            x: Axis::horizontal(x.0, x.1, self.x_spacing, rect.width, self.sizes.tick),
            y: Axis::vertical(y.0, y.1, Spacing::Linear, rect.height, self.sizes.tick),
        }
    }

    /// Returns the y below the panels and their axis labels.
    fn bottom(&self, figure: &PanelFigure) -> f64 {
        self.top + figure.panels.len().div_ceil(self.columns) as f64 * self.pitch() - self.title
            + axis::label_depth(self.sizes.body)
            + 0.5 * self.sizes.body
    }
}
