//! Figure of colour maps over planes, side by side on one colour scale.

use super::axis::{self, Axis, Plot, Spacing};
use super::colour_bar::{ColourBar, Scale};
use super::colours::{Colours, Shading};
use super::drawing::{Anchor, Drawing, Point, Rect, Stroke, Text};
use super::error::{FigureError, check_ascending, check_drawable, check_grid};
use super::field::{self, Picture};
use super::labels::{self, PlacedMark};
use super::shapes::{contour, hatching_beyond};
use super::style::{self, BORDER, INK, Sizes, WHITE};
use super::text::{self, LINE_PITCH, Weight};

/// Most panels in one figure.
const MAX_PANELS: usize = 6;
/// Highest panel in a figure of one row or column, and of more, in pixels.
const TALLEST: [f64; 2] = [1050.0, 640.0];
/// Smallest side of a panel in pixels.
const SMALLEST: f64 = 60.0;
/// Lowest colour bar that still has room for its ticks, in pixels.
const LOWEST_BAR: f64 = 320.0;
/// Assumed ratio of the final legend height to the first guess of it.
const SETTLED: f64 = 0.94;
/// Space between the panels and the colour bar.
const BAR_GAP: f64 = 34.0;
/// Distance of the hatching lines beyond a limit, along the sides of the map, in pixels.
const HATCH_PITCH: f64 = 52.0;

/// A labelled point of a map.
#[derive(Debug, Clone, PartialEq)]
pub struct PlaneMark {
    /// Text beside the ring.
    pub label: String,
    /// First coordinate, mm.
    pub x: f64,
    /// Second coordinate, mm.
    pub y: f64,
}

/// One map. Each value colours a cell around its node that ends half-way to the neighbours; cells end where the grid ends.
#[derive(Debug, Clone, PartialEq)]
pub struct SlicePanel {
    /// Title above the map, for example "z = 126.35 mm".
    pub title: String,
    /// Node coordinates along the horizontal axis, ascending, mm.
    pub x: Vec<f64>,
    /// Node coordinates along the vertical axis, ascending, mm.
    pub y: Vec<f64>,
    /// Values in rows, y outer, x inner; `None` where there is no solution (drawn hatched).
    pub values: Vec<Option<f64>>,
    /// Points marked with a ring; the map's axes grow to include them.
    pub marks: Vec<PlaneMark>,
}

/// A limit of the values of a map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Limit {
    /// No value may be above it.
    Most(f64),
    /// No value may be below it.
    Least(f64),
}

/// Up to six maps of one quantity with one colour scale and one scale of length.
#[derive(Debug, Clone, PartialEq)]
pub struct SliceFigure {
    /// Question that the figure answers.
    pub title: String,
    /// Conditions of the computation.
    pub subtitle: String,
    /// Label of the horizontal axes, for example "x \[mm\]".
    pub x_label: String,
    /// Label of the vertical axes, for example "y \[mm\]".
    pub y_label: String,
    /// Label of the colour bar, for example "worst tool deflection \[mm\]".
    pub quantity: String,
    /// One to six maps, two in a row, or one on a telephone.
    pub panels: Vec<SlicePanel>,
    /// Ends of the colour scale; `None` takes the smallest and largest value of all panels.
    pub range: Option<(f64, f64)>,
    /// What values are held to: a line where they reach it, interpolated between the nodes, and hatching beyond it.
    pub limit: Option<Limit>,
    /// How values become colours.
    pub shading: Shading,
    /// Remark in the caption on a page, not in the figure itself: what its marks are.
    pub remark: String,
    /// Meaning of a hatched cell, for example "no solution".
    pub missing: String,
}

impl SlicePanel {
    /// Checks that nodes increase, values fill the grid, and every number can be drawn.
    fn check(&self) -> Result<(), FigureError> {
        let name = |part: &str| format!("panel \"{}\", {part}", self.title);
        check_ascending(&self.x, || name("x"))?;
        check_ascending(&self.y, || name("y"))?;
        check_grid(&self.values, self.x.len() * self.y.len(), || name("values"))?;
        check_drawable(self.marks.iter().flat_map(|m| [m.x, m.y]), || name("marks"))
    }

    /// Whether the label of `mark` stands above the map, where it hides nothing: that of the only one.
    fn is_titled_by(&self, mark: &PlaneMark) -> bool {
        matches!(self.marks.as_slice(), [only] if only == mark)
    }

    /// Returns the cell edges along x and y, mm.
    fn edges(&self) -> [Vec<f64>; 2] {
        field::edges([&self.x, &self.y])
    }

    /// Returns the ranges of both axes, which include the cells and the marks.
    fn extents(&self) -> [(f64, f64); 2] {
        let [x, y] = self.edges();
        let ends = |edges: &[f64], marks: &[f64]| {
            let all = || edges.iter().chain(marks).copied();
            (all().fold(f64::INFINITY, f64::min), all().fold(f64::NEG_INFINITY, f64::max))
        };
        let xs: Vec<f64> = self.marks.iter().map(|m| m.x).collect();
        let ys: Vec<f64> = self.marks.iter().map(|m| m.y).collect();
        [ends(&x, &xs), ends(&y, &ys)]
    }
}

/// Lays the figure out, its maps in `colours`; `Err` when its data cannot be drawn.
pub(super) fn drawing(figure: &SliceFigure, colours: Colours, sizes: Sizes) -> Result<Drawing, FigureError> {
    if figure.panels.is_empty() {
        return Err(FigureError::Empty { what: "slice figure".into() });
    }
    if figure.panels.len() > MAX_PANELS {
        return Err(FigureError::TooManyPanels { found: figure.panels.len(), most: MAX_PANELS });
    }
    figure.panels.iter().try_for_each(SlicePanel::check)?;
    let values = || figure.panels.iter().flat_map(|p| &p.values);
    let scale = Scale::new(values().copied().flatten(), figure.range, colours, figure.shading)?;
    let bar = ColourBar {
        scale,
        quantity: &figure.quantity,
        missing: values().any(Option::is_none).then_some(figure.missing.as_str()),
        size: sizes.body,
        tick_size: sizes.tick,
    };
    let (mut drawing, top) = style::page_with_heading(&figure.title, &figure.subtitle, sizes);
    let legend_height = |maps: Rect| maps.height.max(LOWEST_BAR);
    let bar_width = if sizes.is_portrait() {
        0.0
    } else {
        // The legend is as high as the maps, whose height depends on the legend's width.
        let guess = Layout::new(figure, sizes, top, bar.width(LOWEST_BAR));
        bar.width(SETTLED * legend_height(guess.maps))
    };
    let layout = Layout::new(figure, sizes, top, bar_width);
    for (panel, place) in figure.panels.iter().zip(&layout.places) {
        draw_panel(&mut drawing, figure, panel, place, scale, sizes);
    }
    let maps = layout.maps;
    if sizes.is_portrait() {
        drawing.height = bar.draw_across(&mut drawing, maps.x, layout.bottom, maps.width) + BORDER;
        return Ok(drawing);
    }
    let height = legend_height(maps);
    bar.draw(&mut drawing, maps.right() + BAR_GAP, maps.y, height);
    drawing.height = layout.bottom.max(maps.y + height + BORDER);
    Ok(drawing)
}

/// Position of one panel on the page, with the width for its title in pixels, and which of its axes are labelled.
struct PanelPlace {
    plot: Plot,
    slot_width: f64,
    labelled_x: bool,
    labelled_y: bool,
}

/// Positions of all panels on the page, in pixels.
struct Layout {
    places: Vec<PanelPlace>,
    /// Rectangle around all maps, without their labels.
    maps: Rect,
    bottom: f64,
}

/// Rows and columns of panels, and the room for titles and axis labels beside, below and above them, in pixels.
struct Table {
    count: usize,
    columns: usize,
    rows: usize,
    /// Whether all panels have the same axes: then only the outer ones are labelled.
    shared: bool,
    left: f64,
    below: f64,
    title: f64,
    gap: f64,
    slot_width: f64,
}

impl Table {
    /// Returns the distances for the panels of `figure` beside a legend of `bar_width` pixels.
    fn new(figure: &SliceFigure, sizes: Sizes, bar_width: f64) -> Self {
        let count = figure.panels.len();
        let columns = count.min(sizes.columns);
        let rows = count.div_ceil(columns);
        let extents: Vec<_> = figure.panels.iter().map(SlicePanel::extents).collect();
        let shared = extents.windows(2).all(|pair| pair[0] == pair[1]);
        let nominal = 0.6 * sizes.width / columns as f64;
        let x_axes = extents.iter().map(|e| map_axis(e[0], nominal, sizes.tick));
        let y_axes = extents.iter().map(|e| map_axis(e[1], nominal, sizes.tick));
        let left = y_axes.map(|a| a.depth_beside(sizes.tick)).fold(0.0, f64::max) + axis::label_depth(sizes.body);
        let overhang = 0.5 * x_axes.map(|a| axis::label_width(&a.ticks, sizes.tick)).fold(0.0, f64::max);
        let gap = if shared { overhang + 0.6 * sizes.body } else { left + 0.6 * sizes.body };
        let bar = if bar_width > 0.0 { bar_width + BAR_GAP } else { 0.0 };
        let room = sizes.width - 2.0 * BORDER - left - bar.max(overhang) - gap * (columns - 1) as f64;
        let slot_width = (room / columns as f64).max(SMALLEST);
        let title_lines = figure.panels.iter().map(|p| title_lines(p, slot_width, sizes).len()).max().unwrap_or(0);
        Self {
            count,
            columns,
            rows,
            shared,
            left,
            below: axis::depth_below(sizes.tick) + axis::label_depth(sizes.body),
            title: title_lines as f64 * LINE_PITCH * sizes.body + 0.2 * sizes.body,
            gap,
            slot_width,
        }
    }

    /// Returns the width of each column: that of its widest map or title, in pixels.
    fn column_widths(&self, figure: &SliceFigure, lengths: &[[f64; 2]], sizes: Sizes) -> Vec<f64> {
        let of_panel =
            |(panel, length): (&SlicePanel, &[f64; 2])| length[0].max(widest_line(panel, self.slot_width, sizes));
        let widths: Vec<f64> = figure.panels.iter().zip(lengths).map(of_panel).collect();
        let column = |column| widths.iter().skip(column).step_by(self.columns).copied().fold(0.0, f64::max);
        (0..self.columns).map(column).collect()
    }

    /// Returns the position of the panel `index`, whose map covers `rect` with axes over `ends`.
    fn panel_at(&self, rect: Rect, ends: [(f64, f64); 2], index: usize, slot_width: f64, sizes: Sizes) -> PanelPlace {
        let is_above_another = index + self.columns < self.count;
        PanelPlace {
            plot: Plot {
                rect,
                x: map_axis(ends[0], rect.width, sizes.tick),
                y: Axis::vertical(ends[1].0, ends[1].1, Spacing::Linear, rect.height, sizes.tick),
            },
            slot_width,
            labelled_x: !self.shared || !is_above_another,
            labelled_y: !self.shared || index.is_multiple_of(self.columns),
        }
    }

    /// Returns the pixels per mm at which every panel fits.
    fn scale(&self, extents: &[[(f64, f64); 2]]) -> f64 {
        let tallest = TALLEST[self.rows.min(self.columns).min(2) - 1];
        let fit = |[x, y]: &[(f64, f64); 2]| (self.slot_width / (x.1 - x.0)).min(tallest / (y.1 - y.0));
        extents.iter().map(fit).fold(f64::INFINITY, f64::min)
    }
}

impl Layout {
    /// Lays out the panels below `top`, centred together with a legend of `bar_width` pixels.
    fn new(figure: &SliceFigure, sizes: Sizes, top: f64, bar_width: f64) -> Self {
        let table = Table::new(figure, sizes, bar_width);
        let extents: Vec<_> = figure.panels.iter().map(SlicePanel::extents).collect();
        let scale = table.scale(&extents);
        let lengths: Vec<[f64; 2]> =
            extents.iter().map(|ends| ends.map(|(low, high)| (scale * (high - low)).max(SMALLEST))).collect();
        let column_widths = table.column_widths(figure, &lengths, sizes);
        let used = table.left + column_widths.iter().sum::<f64>() + table.gap * (table.columns - 1) as f64;
        let bar = if bar_width > 0.0 { BAR_GAP + bar_width } else { 0.0 };
        let left = ((sizes.width - used - bar) / 2.0).max(BORDER) + table.left;

        let mut places = Vec::with_capacity(extents.len());
        let mut y = top;
        let mut maps_bottom = top;
        for (row, chunk) in lengths.chunks(table.columns).enumerate() {
            y += table.title;
            maps_bottom = y + chunk.iter().map(|l| l[1]).fold(0.0, f64::max);
            let mut x = left;
            for (column, [width, height]) in chunk.iter().copied().enumerate() {
                let index = row * table.columns + column;
                let slot = column_widths[column];
                let rect = Rect { x: x + (slot - width) / 2.0, y: maps_bottom - height, width, height };
                places.push(table.panel_at(rect, extents[index], index, slot, sizes));
                x += slot + table.gap;
            }
            let last = row + 1 == table.rows;
            y = maps_bottom + if last || !table.shared { table.below } else { 0.35 * sizes.body };
        }
        let maps_top = top + table.title;
        let maps = Rect { x: left, y: maps_top, width: used - table.left, height: maps_bottom - maps_top };
        Self { places, maps, bottom: y + BORDER }
    }
}

/// Returns a linear axis over `ends`, `length` pixels long, with tick labels side by side.
fn map_axis(ends: (f64, f64), length: f64, size: f64) -> Axis {
    Axis::horizontal(ends.0, ends.1, Spacing::Linear, length, size)
}

/// Returns the title of a panel and the label of its only mark, wrapped to `width` pixels.
fn title_lines(panel: &SlicePanel, width: f64, sizes: Sizes) -> Vec<String> {
    let label = panel.marks.iter().filter(|mark| panel.is_titled_by(mark)).map(|mark| &mark.label);
    let parts = std::iter::once(&panel.title).chain(label).filter(|part| !part.is_empty());
    parts.flat_map(|part| text::wrap(part, sizes.body, Weight::Regular, width)).collect()
}

/// Returns the width in pixels of the widest line of a panel's title, `width` at most.
fn widest_line(panel: &SlicePanel, width: f64, sizes: Sizes) -> f64 {
    let lines = title_lines(panel, width, sizes);
    lines.iter().map(|l| text::width(l, sizes.body, Weight::Regular)).fold(0.0, f64::max).min(width)
}

/// Draws one panel: cells, level line, axes, title and marks.
fn draw_panel(
    drawing: &mut Drawing,
    figure: &SliceFigure,
    panel: &SlicePanel,
    place: &PanelPlace,
    scale: Option<Scale>,
    sizes: Sizes,
) {
    let plot = &place.plot;
    let [column_edges, row_edges] = panel.edges();
    let colour = |column, row| {
        let value: Option<f64> = panel.values[row * panel.x.len() + column];
        value.zip(scale).map(|(value, scale)| scale.colour(value))
    };
    let rect = plot.cell_rect(&column_edges, &row_edges);
    drawing.picture(Picture::new(rect.frame(), &column_edges, &row_edges, colour));
    let lines = figure.limit.map_or_else(Vec::new, |limit| draw_limit(drawing, panel, plot, limit));
    plot.draw_frame(drawing);
    draw_title(drawing, panel, place, sizes);
    if place.labelled_x {
        plot.draw_x_axis(drawing, &figure.x_label, sizes.body, sizes.tick);
    }
    if place.labelled_y {
        plot.draw_y_axis(drawing, &figure.y_label, sizes.body, sizes.tick);
    }
    let label = |mark| if panel.is_titled_by(mark) { "" } else { &mark.label };
    let placed: Vec<PlacedMark<'_>> = panel
        .marks
        .iter()
        .map(|mark| PlacedMark { at: plot.page_point(mark.x, mark.y), label: label(mark), hidden: false })
        .collect();
    labels::draw_marks(drawing, &placed, &lines, plot.rect, sizes.tick);
}

/// Hatches the map beyond its limit and draws the line between, dark with a light rim so that both show on every colour; returns the line's
/// segments on the page.
fn draw_limit(drawing: &mut Drawing, panel: &SlicePanel, plot: &Plot, limit: Limit) -> Vec<[Point; 2]> {
    let (Limit::Most(level) | Limit::Least(level)) = limit;
    let [x, y] = panel.edges();
    let [corner, opposite] =
        [(x.first(), y.last()), (x.last(), y.first())].map(|(x, y)| Some(plot.page_point(*x?, *y?)));
    if let Some((from, to)) = corner.zip(opposite) {
        let sign = if matches!(limit, Limit::Most(_)) { 1.0 } else { -1.0 };
        let beyond: Vec<Option<f64>> =
            panel.values.iter().map(|value| value.map(|value| sign * (value - level))).collect();
        for [a, b] in hatching_beyond(&panel.x, &panel.y, &beyond, [from, to], HATCH_PITCH) {
            for (colour, aside) in [(WHITE, 1.5), (INK, 0.0)] {
                let line = [a, b].map(|[x, y]| [x + aside, y + aside]);
                drawing.line(line.to_vec(), Stroke { colour, width: 1.5, dash: &[] });
            }
        }
    }
    let pieces = contour(&panel.x, &panel.y, &panel.values, level);
    let lines: Vec<[Point; 2]> = pieces.iter().map(|piece| piece.map(|(x, y)| plot.page_point(x, y))).collect();
    for (colour, width) in [(WHITE, 9.0), (INK, 4.5)] {
        for line in &lines {
            drawing.line(line.to_vec(), Stroke { colour, width, dash: &[] });
        }
    }
    lines
}

/// Draws the title of a panel above its map.
fn draw_title(drawing: &mut Drawing, panel: &SlicePanel, place: &PanelPlace, sizes: Sizes) {
    let lines = title_lines(panel, place.slot_width, sizes);
    for (above, line) in lines.iter().rev().enumerate() {
        let at = [
            place.plot.rect.centre()[0],
            place.plot.rect.y - 0.45 * sizes.body - above as f64 * LINE_PITCH * sizes.body,
        ];
        drawing.text(Text::new(line, sizes.body, at, Anchor::Middle));
    }
}
