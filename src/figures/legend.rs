//! Legends below drawings: samples of lines and symbols with their meanings.

use super::drawing::{Anchor, Drawing, Point, Rgb, Stroke, Text};
use super::style::{BORDER, CURVES, MUTED};
use super::text::{self, Weight};

/// Stroke of the tool's path without compensation.
pub(super) const BEFORE: Stroke = Stroke { colour: BEFORE_COLOUR, width: 6.0, dash: &[] };
pub(super) const AFTER: Stroke = Stroke { colour: AFTER_COLOUR, width: 6.0, dash: &[16.0, 12.0] };
pub(super) const BEFORE_COLOUR: Rgb = CURVES[4];
pub(super) const AFTER_COLOUR: Rgb = CURVES[3];
pub(super) const BEFORE_WORDS: &str = "before compensation";
pub(super) const AFTER_WORDS: &str = "after";

/// Width of a sample in pixels.
pub(super) const WIDTH: f64 = 70.0;
const GAP: f64 = 16.0;

/// Draws a sample whose left end is at the given point.
type Draw<'a> = Box<dyn Fn(&mut Drawing, Point) + 'a>;
/// One entry of a legend: a function that draws the sample, and its text.
pub(super) type Sample<'a> = (Draw<'a>, &'static str);

/// Returns a function that draws a sample line with this stroke.
pub(super) fn line_sample(stroke: Stroke) -> Draw<'static> {
    Box::new(move |drawing: &mut Drawing, [x, y]: Point| drawing.line(vec![[x, y], [x + WIDTH, y]], stroke))
}

/// Draws the entries in rows, the first with its baseline at `top`; returns the lower end of the legend.
pub(super) fn draw(drawing: &mut Drawing, samples: Vec<Sample<'_>>, size: f64, top: f64) -> f64 {
    let (mut x, mut y) = (BORDER, top);
    for (draw, words) in samples {
        let width = WIDTH + GAP + text::width(words, size, Weight::Regular);
        if x > BORDER && x + width > drawing.width - BORDER {
            x = BORDER;
            y += 1.5 * size;
        }
        draw(drawing, [x, y - text::capital_height(size) / 2.0]);
        drawing.text(Text::new(words, size, [x + WIDTH + GAP, y], Anchor::Start).coloured(MUTED));
        x += width + 1.1 * size;
    }
    y + 0.4 * size
}
