//! A drawing in a page: from numbers to places, axes and cells.

use std::fmt::Write;

use minijinja::HtmlEscape;

use super::{description::Column, sentences::three};
use crate::files::visible::visible;

/// Width of a drawing, its own units.
pub(super) const WIDTH: f64 = 260.0;
/// Width of one that is not to scale.
pub(super) const WIDE: f64 = 460.0;
pub(super) const HEIGHT: f64 = 220.0;
/// Room for the axes.
pub(super) const LEFT: f64 = 46.0;
pub(super) const BOTTOM: f64 = 34.0;
pub(super) const EDGE: f64 = 6.0;
/// From numbers to a drawing.
pub(super) struct Frame {
    ends: [[f64; 2]; 2],
    size: [f64; 2],
    width: f64,
}

impl Frame {
    pub fn new(ends: [[f64; 2]; 2], is_to_scale: bool) -> Self {
        let all = if is_to_scale { WIDTH } else { WIDE };
        let (width, height) = (all - LEFT - EDGE, HEIGHT - BOTTOM - EDGE);
        let [x, y] = ends.map(|[low, high]| high - low);
        let scale = (width / x).min(height / y);
        let size = if is_to_scale { [x * scale, y * scale] } else { [width, height] };
        Self { ends, size, width: all }
    }

    fn x(&self, value: f64) -> f64 {
        let [low, high] = self.ends[0];
        LEFT + (value - low) / (high - low) * self.size[0]
    }

    fn y(&self, value: f64) -> f64 {
        let [low, high] = self.ends[1];
        EDGE + (high - value) / (high - low) * self.size[1]
    }

    pub fn point(&self, x: f64, y: f64) -> String {
        format!("{:.1},{:.1}", self.x(x), self.y(y))
    }

    pub fn begin(&self) -> String {
        let height = self.size[1] + BOTTOM + EDGE;
        format!("<svg viewBox=\"0 0 {:.0} {height:.0}\" role=\"img\" aria-labelledby=\"hero-title\">", self.width)
    }

    pub fn cell(&self, svg: &mut String, class: &str, x: [f64; 2], y: [f64; 2]) {
        let (left, top) = (self.x(x[0]), self.y(y[1]));
        let (width, height) = (self.x(x[1]) - left, self.y(y[0]) - top);
        let _ = write!(
            svg,
            "<rect class=\"{class}\" x=\"{left:.1}\" y=\"{top:.1}\" width=\"{width:.1}\" height=\"{height:.1}\"/>"
        );
    }

    /// A piece of the strip along the lower edge.
    pub fn band(&self, svg: &mut String, class: &str, [begin, end]: [f64; 2]) {
        let (left, top) = (self.x(begin), EDGE + self.size[1] - 8.0);
        let width = (self.x(end) - left).max(0.0);
        let _ =
            write!(svg, "<rect class=\"{class}\" x=\"{left:.1}\" y=\"{top:.1}\" width=\"{width:.1}\" height=\"8\"/>");
    }

    pub fn end(&self, svg: &mut String, [across, up]: [&Column; 2]) {
        let [width, height] = self.size;
        let (right, low) = (LEFT + width, EDGE + height);
        let _ = write!(
            svg,
            "<rect class=\"frame\" x=\"{LEFT}\" y=\"{EDGE}\" width=\"{width:.1}\" height=\"{height:.1}\"/>"
        );
        let mut text = |x: f64, y: f64, anchor: &str, words: String| {
            let words = escaped(&words);
            let _ = write!(svg, "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\">{words}</text>");
        };
        let [[x0, x1], [y0, y1]] = self.ends;
        text(LEFT, low + 12.0, "start", three(x0));
        text(right, low + 12.0, "end", three(x1));
        text(LEFT + 0.5 * width, low + 26.0, "middle", in_unit(across));
        text(LEFT - 4.0, low, "end", three(y0));
        text(LEFT - 4.0, EDGE + 8.0, "end", three(y1));
        let words = escaped(&in_unit(up));
        let middle = EDGE + 0.5 * height;
        let _ = write!(
            svg,
            "<text transform=\"translate(12 {middle:.1}) rotate(-90)\" text-anchor=\"middle\">{words}</text></svg>"
        );
    }
}

/// Words in a drawing.
pub(super) fn escaped(text: &str) -> String {
    HtmlEscape(&visible(text)).to_string()
}

fn in_unit(column: &Column) -> String {
    super::aligned::in_unit(&column.label, &column.unit)
}
