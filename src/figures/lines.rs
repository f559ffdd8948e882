//! Figure of curves in one pair of axes.

use super::axis::{self, Axis, Plot, Spacing};
use super::curves::{CurveStyle, Legend};
use super::drawing::{Drawing, Point, Rect, Stroke};
use super::error::{FigureError, check_drawable};
use super::style::{self, BORDER, GRID, Sizes};

/// Height of the plot with free axes, and the most with equal ones, in pixels.
const FRAME_HEIGHT: f64 = 860.0;
const TALLEST_EQUAL: f64 = 1000.0;
/// Shortest side of the plot when the axes have equal scales, in pixels.
const SHORTEST: f64 = 300.0;
/// Share of the range left blank on each side.
const MARGIN: f64 = 0.04;
/// Ratio of width to height from which a plot with equal axes has its legend below.
const WIDE: f64 = 1.6;
/// Widest legend beside the plot, in pixels.
const SIDE_LEGEND: f64 = 600.0;
/// Space between plot and legend in pixels.
const LEGEND_GAP: f64 = 44.0;
/// One curve of a figure of curves.
#[derive(Debug, Clone, PartialEq)]
pub struct LineSeries {
    /// Name in the legend; empty leaves the curve out there.
    pub label: String,
    /// Points (x, y), joined in order.
    pub points: Vec<(f64, f64)>,
    /// Whether the curve is dashed, each with a pattern of its own; otherwise it is solid.
    pub dashed: bool,
    /// Band around the curve as (x, low, high) with x ascending; empty for none.
    pub band: Vec<[f64; 3]>,
}

impl LineSeries {
    /// Returns a curve without a band.
    pub fn new(label: impl Into<String>, points: Vec<(f64, f64)>, dashed: bool) -> Self {
        Self { label: label.into(), points, dashed, band: Vec::new() }
    }
}

/// Curves in one pair of axes. They differ in colour, and in dash pattern or marker, so that a grey print keeps them apart.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct LineFigure {
    /// Question that the figure answers.
    pub title: String,
    /// Conditions of the computation.
    pub subtitle: String,
    /// Label of the horizontal axis, for example "x \[mm\]".
    pub x_label: String,
    /// Label of the vertical axis, for example "y \[mm\]".
    pub y_label: String,
    /// The curves, the first one black.
    pub series: Vec<LineSeries>,
    /// Whether one unit is equally long on both axes.
    pub equal_axes: bool,
    /// Whether the x axis is logarithmic.
    pub log_x: bool,
    /// Whether the y axis is logarithmic.
    pub log_y: bool,
    /// Remark a reader must not miss, for example "errors amplified 20x".
    pub closed_note: Option<String>,
}

impl LineFigure {
    /// Returns a figure with free linear axes and these labels of x and y, without a note.
    pub(crate) fn new(
        title: impl Into<String>,
        subtitle: impl Into<String>,
        [x_label, y_label]: [&str; 2],
        series: Vec<LineSeries>,
    ) -> Self {
        let (title, subtitle) = (title.into(), subtitle.into());
        Self { title, subtitle, x_label: x_label.into(), y_label: y_label.into(), series, ..Self::default() }
    }

    /// Checks that there is a point, the axes do not contradict each other, and every value can be drawn on its axis.
    fn check(&self) -> Result<(), FigureError> {
        if self.series.iter().all(|s| s.points.is_empty()) {
            return Err(FigureError::Empty { what: "line figure".into() });
        }
        if self.equal_axes && (self.log_x || self.log_y) {
            return Err(FigureError::EqualAxesWithLog);
        }
        self.series.iter().try_for_each(|series| {
            let name = || format!("series \"{}\"", series.label);
            check_drawable(series.points.iter().flat_map(|p| [p.0, p.1]), name)?;
            check_drawable(series.band.iter().flatten().copied(), name)?;
            let on_log = |p: &(f64, f64)| [(self.log_x, p.0), (self.log_y, p.1)];
            // Below 1e-100 the ratio of the ends overflows.
            let of_band = series.band.iter().flat_map(|[x, low, high]| [(*x, *low), (*x, *high)]);
            let drawn: Vec<(f64, f64)> = series.points.iter().copied().chain(of_band).collect();
            let wrong = drawn.iter().flat_map(on_log).find(|(log, v)| *log && *v < 1e-100);
            wrong.map_or(Ok(()), |(_, value)| Err(FigureError::NotPositive { what: name(), value }))
        })
    }

    /// Returns the legend of the curves, drawn in `styles`.
    fn legend<'a>(&'a self, styles: &'a [CurveStyle], sizes: Sizes) -> Legend<'a> {
        Legend {
            entries: self.series.iter().map(|series| series.label.as_str()).zip(styles).collect(),
            note: self.closed_note.as_deref().unwrap_or(""),
            size: sizes.body,
        }
    }

    /// Returns whether the legend stands beside the plot, where equal axes leave room.
    fn legend_beside(&self) -> bool {
        let length = |(low, high): (f64, f64)| high - low;
        self.equal_axes && length(self.axis_range(|p| p.0, false)) < WIDE * length(self.axis_range(|p| p.1, false))
    }

    /// Returns the padded range of the coordinate `pick` over all curves and bands; padded in logarithms if `log`.
    fn axis_range(&self, pick: impl Fn(&(f64, f64)) -> f64, log: bool) -> (f64, f64) {
        let of_band = |s: &LineSeries| -> Vec<(f64, f64)> {
            s.band.iter().flat_map(|[x, low, high]| [(*x, *low), (*x, *high)]).collect()
        };
        let values = self.series.iter().flat_map(|s| s.points.iter().copied().chain(of_band(s))).map(|p| pick(&p));
        if log {
            let (low, high) = axis::range(values.map(libm::log10), MARGIN);
            return (libm::pow(10.0, low), libm::pow(10_f64, high));
        }
        axis::range(values, MARGIN)
    }

    /// Returns the range of y: from 0 where lengths, angles, forces or shares are all positive and differ much.
    fn y_range(&self) -> (f64, f64) {
        let (low, high) = self.axis_range(|p| p.1, self.log_y);
        let least = low + MARGIN / (1.0 + 2.0 * MARGIN) * (high - low);
        match axis::from_zero((least, high)).0 < least && !self.log_y && !self.equal_axes {
            true => (0.0, high),
            false => (low, high),
        }
    }
}

/// Lays the figure out; `Err` when its data cannot be drawn.
pub(super) fn drawing(figure: &LineFigure, sizes: Sizes) -> Result<Drawing, FigureError> {
    figure.check()?;
    let (mut drawing, top) = style::page_with_heading(&figure.title, &figure.subtitle, sizes);
    let styles = CurveStyle::of(figure.series.iter().map(|s| (s.points.len(), s.dashed)));
    let plot = plot(figure, &styles, top + 0.3 * sizes.body, sizes);
    plot.draw_grid(&mut drawing, Stroke { colour: GRID, width: 1.5, dash: &[] });
    plot.draw_x_axis(&mut drawing, &figure.x_label, sizes.body, sizes.tick);
    plot.draw_y_axis(&mut drawing, &figure.y_label, sizes.body, sizes.tick);
    for (series, style) in figure.series.iter().zip(&styles) {
        let of_band: Vec<[Point; 2]> =
            series.band.iter().map(|[x, low, high]| [plot.page_point(*x, *low), plot.page_point(*x, *high)]).collect();
        style.draw_band(&mut drawing, &of_band);
    }
    for (index, (series, style)) in figure.series.iter().zip(&styles).enumerate() {
        let points: Vec<Point> = series.points.iter().map(|(x, y)| plot.page_point(*x, *y)).collect();
        style.draw_line(&mut drawing, &points);
        style.draw_markers(&mut drawing, &points, index);
    }
    plot.draw_frame(&mut drawing);
    let below = plot.rect.bottom() + axis::depth_below(sizes.tick) + axis::label_depth(sizes.body);
    let room = if figure.legend_beside() {
        let x = plot.rect.right() + LEGEND_GAP;
        Rect { x, y: plot.rect.y, width: sizes.width - BORDER - x, height: 0.0 }
    } else {
        let y = below + 0.3 * sizes.body;
        Rect { x: plot.rect.x, y, width: plot.rect.width, height: 0.0 }
    };
    let legend_bottom = figure.legend(&styles, sizes).draw(&mut drawing, room);
    drawing.height = legend_bottom.max(below) + BORDER;
    Ok(drawing)
}

/// Returns the plot with its axes, its upper side at `top` pixels.
fn plot(figure: &LineFigure, styles: &[CurveStyle], top: f64, sizes: Sizes) -> Plot {
    let mut x = figure.axis_range(|p| p.0, figure.log_x);
    let mut y = figure.y_range();
    let spacing = |log, label: &str| if log { Spacing::Logarithmic } else { Spacing::for_label(label) };
    let y_axis = |ends: (f64, f64), height| {
        Axis::vertical(ends.0, ends.1, spacing(figure.log_y, &figure.y_label), height, sizes.tick)
    };
    let nominal = y_axis(y, FRAME_HEIGHT).depth_beside(sizes.tick);
    let left = BORDER + axis::label_depth(sizes.body) + nominal;
    let mut rect = Rect { x: left, y: top, width: sizes.width - left - 2.0 * BORDER, height: FRAME_HEIGHT };
    if figure.equal_axes {
        let room = rect.width - if figure.legend_beside() { legend_width(figure, styles, sizes) } else { 0.0 };
        let scale = (room / (x.1 - x.0)).min(TALLEST_EQUAL / (y.1 - y.0));
        x = axis::widened_to(x, SHORTEST / scale);
        y = axis::widened_to(y, SHORTEST / scale);
        rect.width = scale * (x.1 - x.0);
        rect.height = scale * (y.1 - y.0);
    }
    Plot {
        rect,
        x: Axis::horizontal(x.0, x.1, spacing(figure.log_x, &figure.x_label), rect.width, sizes.tick),
        y: y_axis(y, rect.height),
    }
}

/// Returns the width in pixels that the legend takes beside the plot, with the gap.
fn legend_width(figure: &LineFigure, styles: &[CurveStyle], sizes: Sizes) -> f64 {
    figure.legend(styles, sizes).width().min(SIDE_LEGEND) + LEGEND_GAP
}
