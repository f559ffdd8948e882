//! Axes of plots: from values to points on the page, and the ticks of an axis or colour bar with their labels.

use super::drawing::{Anchor, Drawing, Point, Rect, Stroke, Text};
use super::style::{INK, outline};
use super::text::{self, Weight};

/// Length of tick strokes in pixels.
const TICK: f64 = 9.0;
/// Distance between tick stroke and tick label.
const GAP: f64 = 8.0;
/// Most ticks on an axis.
const MAX_TICKS: usize = 7;

/// How the values of an axis are spaced and its ticks chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Spacing {
    /// Equal distances are equal differences.
    Linear,
    /// Equal distances are equal ratios.
    Logarithmic,
    /// Linear, with ticks at round angles in degrees.
    Angular,
}

impl Spacing {
    /// Returns the spacing for a linear quantity with this axis label: angular if its unit is °.
    pub fn for_label(label: &str) -> Self {
        if label.ends_with("[°]") { Spacing::Angular } else { Spacing::Linear }
    }
}

/// One axis of a plot: its range of values, their spacing and its ticks.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Axis {
    pub low: f64,
    pub high: f64,
    pub spacing: Spacing,
    pub ticks: Ticks,
}

impl Axis {
    /// Returns an axis `length` pixels long with as many ticks as labels of type size `size` fit side by side.
    pub(crate) fn horizontal(low: f64, high: f64, spacing: Spacing, length: f64, size: f64) -> Self {
        Self::fit_ticks(low, high, spacing, |axis| axis.pitch() * length >= label_width(&axis.ticks, size) + 0.9 * size)
    }

    /// Returns an axis `length` pixels long with as many ticks as labels of type size `size` fit one above the other.
    pub(crate) fn vertical(low: f64, high: f64, spacing: Spacing, length: f64, size: f64) -> Self {
        Self::fit_ticks(low, high, spacing, |axis| axis.pitch() * length >= 2.0 * size)
    }

    /// Returns a linear axis along a slanted line that spans `[width, height]` pixels, with as many ticks as labels fit.
    pub(crate) fn slanted(low: f64, high: f64, [width, height]: Point, size: f64) -> Self {
        Self::fit_ticks(low, high, Spacing::Linear, |axis| {
            let pitch = axis.pitch();
            pitch * width >= label_width(&axis.ticks, size) + 0.3 * size || pitch * height >= 1.6 * size
        })
    }

    /// Returns an axis from `low` to `high` with as many ticks as `fits` accepts, one at least.
    fn fit_ticks(low: f64, high: f64, spacing: Spacing, fits: impl Fn(&Self) -> bool) -> Self {
        let (low, high) = if low < high { (low, high) } else { widened(low, high) };
        let axis = |target| {
            let ticks = match spacing {
                Spacing::Linear => linear_ticks(low, high, target),
                Spacing::Angular => degree_ticks(low, high, target),
                Spacing::Logarithmic => logarithmic_ticks(low, high, target),
            };
            Self { low, high, spacing, ticks }
        };
        let mut candidates = (2..=MAX_TICKS).rev().map(axis);
        candidates.find(fits).unwrap_or_else(|| axis(1))
    }

    /// Returns the smallest distance between neighbouring ticks as a fraction of the axis.
    fn pitch(&self) -> f64 {
        let fractions: Vec<f64> = self.ticks.values.iter().map(|v| self.fraction(*v)).collect();
        fractions.windows(2).map(|pair| pair[1] - pair[0]).fold(1.0, f64::min)
    }

    /// Returns where `value` lies along the axis: 0 at the low end, 1 at the high end.
    pub fn fraction(&self, value: f64) -> f64 {
        match self.spacing {
            Spacing::Linear | Spacing::Angular => (value - self.low) / (self.high - self.low),
            Spacing::Logarithmic => libm::log10(value / self.low) / libm::log10(self.high / self.low),
        }
    }

    /// Returns the width in pixels that ticks and tick labels take beside a vertical axis.
    pub(crate) fn depth_beside(&self, size: f64) -> f64 {
        TICK + GAP + label_width(&self.ticks, size)
    }
}

/// Returns the width in pixels of the widest tick label at type size `size`.
pub(super) fn label_width(ticks: &Ticks, size: f64) -> f64 {
    ticks.labels.iter().map(|l| text::width(l, size, Weight::Regular)).fold(0.0, f64::max)
}

/// Returns the height in pixels that ticks and tick labels take below a horizontal axis.
pub(super) fn depth_below(size: f64) -> f64 {
    TICK + GAP + size
}

/// A rectangle on the page with its horizontal and vertical axis.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Plot {
    pub rect: Rect,
    pub x: Axis,
    pub y: Axis,
}

impl Plot {
    /// Returns the point on the page at the values (`x`, `y`).
    pub fn page_point(&self, x: f64, y: f64) -> Point {
        [self.rect.x + self.rect.width * self.x.fraction(x), self.rect.bottom() - self.rect.height * self.y.fraction(y)]
    }

    /// Returns the rectangle on the page that the cells between the given edges cover.
    pub fn cell_rect(&self, column_edges: &[f64], row_edges: &[f64]) -> Rect {
        let ends = |edges: &[f64]| (edges[0], edges[edges.len() - 1]);
        let ((x0, x1), (y0, y1)) = (ends(column_edges), ends(row_edges));
        let ([left, bottom], [right, top]) = (self.page_point(x0, y0), self.page_point(x1, y1));
        Rect { x: left, y: top, width: right - left, height: bottom - top }
    }

    /// Draws the border of the plot.
    pub(crate) fn draw_frame(&self, drawing: &mut Drawing) {
        drawing.outline(&self.rect.corners(), outline());
    }

    /// Draws lines through the labelled ticks of both axes.
    pub(crate) fn draw_grid(&self, drawing: &mut Drawing, stroke: Stroke) {
        for value in &self.x.ticks.values {
            let x = self.page_point(*value, self.y.low)[0];
            drawing.line(vec![[x, self.rect.y], [x, self.rect.bottom()]], stroke);
        }
        for value in &self.y.ticks.values {
            let y = self.page_point(self.x.low, *value)[1];
            drawing.line(vec![[self.rect.x, y], [self.rect.right(), y]], stroke);
        }
    }

    /// Draws ticks, tick labels and axis label below the plot.
    pub(crate) fn draw_x_axis(&self, drawing: &mut Drawing, label: &str, size: f64, tick_size: f64) {
        let bottom = self.rect.bottom();
        for (value, tick) in ticks_with_labels(&self.x.ticks) {
            let x = self.page_point(value, self.y.low)[0];
            drawing.line(vec![[x, bottom], [x, bottom + tick_length(tick)]], tick_stroke());
            let at = [x, bottom + TICK + GAP + text::capital_height(tick_size)];
            drawing.text(Text::new(tick, tick_size, at, Anchor::Middle));
        }
        let label = label_with_power(label, self.x.ticks.exponent);
        let at = [self.rect.centre()[0], bottom + depth_below(tick_size) + 1.1 * size];
        drawing.text(Text::new(label, size, at, Anchor::Middle));
    }

    /// Draws ticks, tick labels and axis label left of the plot.
    pub(crate) fn draw_y_axis(&self, drawing: &mut Drawing, label: &str, size: f64, tick_size: f64) {
        for (value, tick) in ticks_with_labels(&self.y.ticks) {
            let y = self.page_point(self.x.low, value)[1];
            drawing.line(vec![[self.rect.x - tick_length(tick), y], [self.rect.x, y]], tick_stroke());
            let at = [self.rect.x - TICK - GAP, y + text::capital_height(tick_size) / 2.0];
            drawing.text(Text::new(tick, tick_size, at, Anchor::End));
        }
        let label = label_with_power(label, self.y.ticks.exponent);
        let at = [self.rect.x - self.y.depth_beside(tick_size) - 0.6 * size, self.rect.centre()[1]];
        drawing.text(Text::new(label, size, at, Anchor::Middle).upward());
    }
}

/// Returns the range of `values`, widened by the share `margin` of it on each side; without values that of 0 to 1.
pub(super) fn range(values: impl Iterator<Item = f64>, margin: f64) -> (f64, f64) {
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
    let (low, high) = if low <= high { widened(low, high) } else { (0.0, 1.0) };
    let margin = margin * (high - low);
    (low - margin, high + margin)
}

/// Returns the range of sizes that begins at 0 where they differ so much that their ratio matters; otherwise as it is.
pub(super) fn from_zero((low, high): (f64, f64)) -> (f64, f64) {
    if low > 0.0 && low < 0.5 * high { (0.0, high) } else { (low, high) }
}

/// Returns `range`, widened around its middle to `length` if it is shorter.
pub(super) fn widened_to(range: (f64, f64), length: f64) -> (f64, f64) {
    let missing = (length - (range.1 - range.0)).max(0.0) / 2.0;
    (range.0 - missing, range.1 + missing)
}

/// Returns the room in pixels for the axis label next to the tick labels, at type size `size`.
pub(super) fn label_depth(size: f64) -> f64 {
    1.6 * size
}

/// Yields value and label of each tick; minor ticks follow with an empty label.
fn ticks_with_labels(ticks: &Ticks) -> impl Iterator<Item = (f64, &str)> {
    let major = ticks.values.iter().copied().zip(ticks.labels.iter().map(String::as_str));
    major.chain(ticks.minor.iter().map(|v| (*v, "")))
}

/// Returns the length in pixels of the tick with this label: shorter for a minor tick, whose label is empty.
fn tick_length(label: &str) -> f64 {
    if label.is_empty() { 0.6 * TICK } else { TICK }
}

/// Returns the stroke of ticks.
pub(super) fn tick_stroke() -> Stroke {
    Stroke { colour: INK, width: 2.0, dash: &[] }
}

/// Values marked on an axis, and their labels.
#[derive(Debug, Clone, PartialEq)]
pub struct Ticks {
    /// Labelled values.
    pub values: Vec<f64>,
    /// Labels of `values`, in the same order.
    pub labels: Vec<String>,
    /// Values of the minor ticks, without labels.
    pub minor: Vec<f64>,
    /// Power of ten by which the values are divided in the labels.
    pub exponent: i32,
}

/// Labels with more decimals than this have a power of ten moved into the axis label.
const MAX_DECIMALS: i32 = 4;
/// Values from here on have a power of ten moved into the axis label.
const LARGE: f64 = 1e5;

/// Returns `(low, high)`, widened by 10 % of its magnitude (or by 1 around zero) if it is too narrow for an axis.
pub fn widened(low: f64, high: f64) -> (f64, f64) {
    let magnitude = low.abs().max(high.abs());
    if high - low > 1e-9 * magnitude && high - low > 1e-100 {
        return (low, high);
    }
    let half = if magnitude > 1e-100 { 0.1 * magnitude } else { 1.0 };
    (low - half, high + half)
}

/// Returns about `target` ticks at most, at steps of 1, 2 or 5 times a power of ten within `low..high` (`low < high`).
pub fn linear_ticks(low: f64, high: f64, target: usize) -> Ticks {
    ticks_at_multiples(low, high, nice_step((high - low) / target.max(1) as f64))
}

/// Returns ticks for angles in degrees: over ranges above 45° at steps of 10° to 360° that fit right angles, else as [`linear_ticks`].
pub fn degree_ticks(low: f64, high: f64, target: usize) -> Ticks {
    let raw = (high - low) / target.max(1) as f64;
    match [10.0, 15.0, 30.0, 45.0, 90.0, 180.0, 360.0].into_iter().find(|step| *step >= raw) {
        Some(step) if high - low > 45.0 => ticks_at_multiples(low, high, step),
        _ => linear_ticks(low, high, target),
    }
}

/// Returns ticks at all multiples of `step` from `low` to `high`.
fn ticks_at_multiples(low: f64, high: f64, step: f64) -> Ticks {
    let first = (low / step - 1e-9).ceil() as i64;
    let last = (high / step + 1e-9).floor() as i64;
    let values: Vec<f64> = (first..=last).map(|k| k as f64 * step).collect();
    let largest = values.iter().fold(0.0_f64, |a, v| a.max(v.abs()));
    let decimals = -(libm::log10(step) + 1e-9).floor() as i32;
    let exponent = if largest > 0.0 && (decimals > MAX_DECIMALS || largest >= LARGE) {
        3 * (libm::log10(largest) / 3.0).floor() as i32
    } else {
        0
    };
    let decimals = (decimals + exponent).max(0) as usize;
    let labels = values.iter().map(|v| format_number(v / 10_f64.powi(exponent), decimals)).collect();
    Ticks { values, labels, minor: Vec::new(), exponent }
}

/// Returns the smallest of 1, 2 and 5 times a power of ten that is not below `raw`.
fn nice_step(raw: f64) -> f64 {
    let power = 10_f64.powi(libm::log10(raw).floor() as i32);
    let factor = [1.0, 2.0, 5.0].into_iter().find(|f| f * power >= raw * (1.0 - 1e-9)).unwrap_or(10.0);
    factor * power
}

/// Returns about `target` ticks at most, at powers of ten within `low..high` (both positive); over few decades at closer steps.
pub fn logarithmic_ticks(low: f64, high: f64, target: usize) -> Ticks {
    let first = (libm::log10(low) - 1e-9).ceil() as i32;
    let last = (libm::log10(high) + 1e-9).floor() as i32;
    let between = decade_multiples(low, high, &[2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0]);
    if last - first >= 1 {
        let stride = ((last - first) as usize / target.max(1) + 1) as i32;
        let (powers, others): (Vec<i32>, Vec<i32>) = (first..=last).partition(|k| k.rem_euclid(stride) == 0);
        let decades = |powers: &[i32]| powers.iter().map(|k| 10_f64.powi(*k)).collect();
        let minor = if stride == 1 { between } else { decades(&others) };
        let labels = powers.iter().map(|k| power_of_ten(*k)).collect();
        return Ticks { values: decades(&powers), labels, minor, exponent: 0 };
    }
    let values = decade_multiples(low, high, &[1.0, 2.0, 5.0]);
    if values.len() < 2 {
        return linear_ticks(low, high, target);
    }
    let labels = values.iter().map(|v| format_number(*v, (-libm::log10(*v).floor()).max(0.0) as usize)).collect();
    Ticks { values, labels, minor: between, exponent: 0 }
}

/// Returns `factors` times each power of ten, as far as they lie within `low..high`.
fn decade_multiples(low: f64, high: f64, factors: &[f64]) -> Vec<f64> {
    let decades = libm::log10(low).floor() as i32..=libm::log10(high).floor() as i32;
    let all = decades.flat_map(|k| factors.iter().map(move |f| f * 10_f64.powi(k)));
    all.filter(|v| (low * (1.0 - 1e-9)..=high * (1.0 + 1e-9)).contains(v)).collect()
}

/// Returns a number as text with `decimals` decimals, a true minus sign and never a negative zero.
fn format_number(value: f64, decimals: usize) -> String {
    let digits = format!("{:.decimals$}", value.abs());
    let zero = digits.bytes().all(|b| b == b'0' || b == b'.');
    if value < 0.0 && !zero { format!("\u{2212}{digits}") } else { digits }
}

/// Returns a power of ten with a superscript exponent, such as "10⁻³".
pub(super) fn power_of_ten(exponent: i32) -> String {
    let raise = |character: char| match character {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        digit => char::from_u32('⁰' as u32 + digit.to_digit(10).unwrap_or(0)).unwrap_or(digit),
    };
    format!("10{}", exponent.to_string().chars().map(raise).collect::<String>())
}

/// Returns the axis label with the power of ten before its unit: `error [mm]` becomes `error [10⁻³ mm]`.
pub fn label_with_power(label: &str, exponent: i32) -> String {
    if exponent == 0 {
        return label.to_owned();
    }
    let power = power_of_ten(exponent);
    match label.rsplit_once('[') {
        Some((name, unit)) => format!("{name}[{power} {unit}"),
        None => format!("{label} [{power}]"),
    }
}
