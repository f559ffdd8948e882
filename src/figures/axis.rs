//! One axis of a plot: from numbers to places, with ticks that fit.

use super::scene::{Anchor, Point, Rect, Scene, Stroke, Text};
use super::style::{INK, outline};
use super::text::{self, Weight};
use super::ticks::{self, Ticks};

/// Length of tick strokes in pixels.
const TICK: f64 = 9.0;
/// Distance between tick stroke and tick label.
const GAP: f64 = 8.0;
/// Most ticks on an axis.
const MOST_TICKS: usize = 7;

/// Whether equal distances mean equal differences or equal ratios.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Spacing {
    Linear,
    Logarithmic,
    /// Linear, in degrees.
    Angular,
}

impl Spacing {
    /// Of a quantity that is not logarithmic; an angle if its label says so.
    pub fn of(label: &str) -> Self {
        if label.ends_with("[°]") { Spacing::Angular } else { Spacing::Linear }
    }
}

#[derive(Debug, Clone, PartialEq)]
pub(super) struct Axis {
    pub low: f64,
    pub high: f64,
    pub spacing: Spacing,
    pub ticks: Ticks,
}

impl Axis {
    /// An axis `length` pixels long whose labels do not run into each other, labels side by side.
    pub(crate) fn horizontal(low: f64, high: f64, spacing: Spacing, length: f64, size: f64) -> Self {
        Self::fitted(low, high, spacing, |axis| axis.pitch() * length >= label_width(&axis.ticks, size) + 0.9 * size)
    }

    /// As [`Axis::horizontal`], labels one above the other.
    pub(crate) fn vertical(low: f64, high: f64, spacing: Spacing, length: f64, size: f64) -> Self {
        Self::fitted(low, high, spacing, |axis| axis.pitch() * length >= 2.0 * size)
    }

    /// As [`Axis::horizontal`], for a linear axis that spans `[width, height]` pixels on the page.
    pub(crate) fn slanted(low: f64, high: f64, [width, height]: Point, size: f64) -> Self {
        Self::fitted(low, high, Spacing::Linear, |axis| {
            let pitch = axis.pitch();
            pitch * width >= label_width(&axis.ticks, size) + 0.3 * size || pitch * height >= 1.6 * size
        })
    }

    fn fitted(low: f64, high: f64, spacing: Spacing, fits: impl Fn(&Self) -> bool) -> Self {
        let (low, high) = if low < high { (low, high) } else { ticks::widened(low, high) };
        let axis = |target| {
            let ticks = match spacing {
                Spacing::Linear => ticks::linear(low, high, target),
                Spacing::Angular => ticks::degrees(low, high, target),
                Spacing::Logarithmic => ticks::logarithmic(low, high, target),
            };
            Self { low, high, spacing, ticks }
        };
        let mut candidates = (2..=MOST_TICKS).rev().map(axis);
        candidates.find(fits).unwrap_or_else(|| axis(1))
    }

    /// Smallest distance between neighbouring ticks as a fraction of the axis.
    fn pitch(&self) -> f64 {
        let places: Vec<f64> = self.ticks.values.iter().map(|v| self.fraction(*v)).collect();
        places.windows(2).map(|pair| pair[1] - pair[0]).fold(1.0, f64::min)
    }

    /// Where `value` lies: 0 at the low end, 1 at the high end.
    pub fn fraction(&self, value: f64) -> f64 {
        match self.spacing {
            Spacing::Linear | Spacing::Angular => (value - self.low) / (self.high - self.low),
            Spacing::Logarithmic => (value / self.low).log10() / (self.high / self.low).log10(),
        }
    }

    /// Room needed beside a vertical axis for ticks and tick labels.
    pub(crate) fn depth_beside(&self, size: f64) -> f64 {
        TICK + GAP + label_width(&self.ticks, size)
    }
}

/// Width of the widest tick label.
pub(super) fn label_width(ticks: &Ticks, size: f64) -> f64 {
    ticks.labels.iter().map(|l| text::width(l, size, Weight::Regular)).fold(0.0, f64::max)
}

/// Room needed below a horizontal axis for ticks and tick labels.
pub(super) fn depth_below(size: f64) -> f64 {
    TICK + GAP + size
}

/// A frame on the page with its two axes.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Plot {
    pub rect: Rect,
    pub x: Axis,
    pub y: Axis,
}

impl Plot {
    /// The place of a pair of numbers.
    pub fn place(&self, x: f64, y: f64) -> Point {
        [self.rect.x + self.rect.width * self.x.fraction(x), self.rect.bottom() - self.rect.height * self.y.fraction(y)]
    }

    pub(crate) fn draw_frame(&self, scene: &mut Scene) {
        scene.outline(&self.rect.corners(), outline());
    }

    /// Thin lines through the ticks.
    pub(crate) fn draw_grid(&self, scene: &mut Scene, stroke: Stroke) {
        for value in &self.x.ticks.values {
            let x = self.place(*value, self.y.low)[0];
            scene.line(vec![[x, self.rect.y], [x, self.rect.bottom()]], stroke);
        }
        for value in &self.y.ticks.values {
            let y = self.place(self.x.low, *value)[1];
            scene.line(vec![[self.rect.x, y], [self.rect.right(), y]], stroke);
        }
    }

    /// Ticks, tick labels and axis label below the frame.
    pub(crate) fn draw_below(&self, scene: &mut Scene, label: &str, size: f64, tick_size: f64) {
        let bottom = self.rect.bottom();
        for (value, tick) in labelled(&self.x.ticks) {
            let x = self.place(value, self.y.low)[0];
            scene.line(vec![[x, bottom], [x, bottom + stroke_length(tick)]], tick_stroke());
            let at = [x, bottom + TICK + GAP + text::capital_height(tick_size)];
            scene.text(Text::new(tick, tick_size, at, Anchor::Middle));
        }
        let label = ticks::label_with_power(label, self.x.ticks.exponent);
        let at = [self.rect.centre()[0], bottom + depth_below(tick_size) + 1.1 * size];
        scene.text(Text::new(label, size, at, Anchor::Middle));
    }

    /// Ticks, tick labels and axis label left of the frame.
    pub(crate) fn draw_beside(&self, scene: &mut Scene, label: &str, size: f64, tick_size: f64) {
        for (value, tick) in labelled(&self.y.ticks) {
            let y = self.place(self.x.low, value)[1];
            scene.line(vec![[self.rect.x - stroke_length(tick), y], [self.rect.x, y]], tick_stroke());
            let at = [self.rect.x - TICK - GAP, y + text::capital_height(tick_size) / 2.0];
            scene.text(Text::new(tick, tick_size, at, Anchor::End));
        }
        let label = ticks::label_with_power(label, self.y.ticks.exponent);
        let at = [self.rect.x - self.y.depth_beside(tick_size) - 0.6 * size, self.rect.centre()[1]];
        scene.text(Text::new(label, size, at, Anchor::Middle).upward());
    }
}

/// Room for the axis label next to the tick labels.
pub(super) fn label_depth(size: f64) -> f64 {
    1.6 * size
}

/// Ticks with their labels, then the minor ones with none.
fn labelled(ticks: &Ticks) -> impl Iterator<Item = (f64, &str)> {
    let major = ticks.values.iter().copied().zip(ticks.labels.iter().map(String::as_str));
    major.chain(ticks.minor.iter().map(|v| (*v, "")))
}

fn stroke_length(label: &str) -> f64 {
    if label.is_empty() { 0.6 * TICK } else { TICK }
}

pub(super) fn tick_stroke() -> Stroke {
    Stroke { colour: INK, width: 2.0, dash: &[] }
}
