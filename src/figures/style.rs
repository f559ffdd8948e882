//! Style that all figures share: page, heading, type sizes and colours.

use super::drawing::{Anchor, Drawing, Rgb, Stroke, Text};
use super::text::{self, LINE_PITCH, Weight};

/// Blank border of every figure in pixels.
pub(super) const BORDER: f64 = 28.0;

pub(super) const WHITE: Rgb = [255, 255, 255];
pub(super) const INK: Rgb = [26, 26, 26];
pub(super) const MUTED: Rgb = [80, 80, 80];
pub(super) const GRID: Rgb = [226, 226, 226];
pub(super) const HATCH: Rgb = [150, 150, 150];

/// Curve colours that colour-blind readers can distinguish; yellow is left out as too pale for lines.
///
/// Source: M. Okabe, K. Ito, "Color Universal Design", 2008.
pub(super) const CURVES: [Rgb; 7] =
    [[0, 0, 0], [213, 94, 0], [0, 114, 178], [0, 158, 115], [204, 121, 167], [230, 159, 0], [86, 180, 233]];

/// Dash patterns of the dashed curves in order: lengths of dashes and gaps in pixels (round ends lengthen each dash by the line width).
pub(super) const DASHES: [&[f64]; 4] =
    [&[20.0, 14.0], &[1.0, 11.0], &[20.0, 12.0, 1.0, 12.0], &[36.0, 14.0, 10.0, 14.0]];

/// Smallest type size in pixels: 7 pt where a figure is set into a column of 85 mm.
pub(super) const LEAST: f64 = 47.0;

/// Width of a figure, how many drawings stand side by side at most, and type sizes, in pixels.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sizes {
    pub width: f64,
    pub columns: usize,
    pub title: f64,
    pub body: f64,
    pub tick: f64,
}

impl Sizes {
    /// A column of 85 mm at 480 dpi, with type of 8 pt and 7 pt.
    pub const FIGURE: Self = Self { width: 1600.0, columns: 2, title: 53.0, body: LEAST, tick: LEAST };
    /// The same type on the width of a telephone.
    pub const PORTRAIT: Self = Self { width: 1100.0, columns: 1, ..Self::FIGURE };

    /// Whether colour bars lie below their maps, which then have the whole width.
    pub fn is_portrait(self) -> bool {
        self.columns == 1
    }
}

/// Returns the thin dark stroke around plots and legends.
pub(super) fn outline() -> Stroke {
    Stroke { colour: INK, width: 2.0, dash: &[] }
}

/// Returns a page with title and subtitle only, and the y below them.
pub(super) fn page_with_heading(title: &str, subtitle: &str, sizes: Sizes) -> (Drawing, f64) {
    let mut drawing = Drawing { title: title.to_owned(), width: sizes.width, ..Drawing::default() };
    let mut y = BORDER;
    for line in page_lines(&drawing, title, sizes.title, Weight::Bold) {
        y += sizes.title;
        drawing.text(Text::new(line, sizes.title, [BORDER, y], Anchor::Start).bold());
        y += (LINE_PITCH - 1.0) * sizes.title;
    }
    y = draw_paragraph(&mut drawing, subtitle, y + 0.1 * sizes.body, sizes.body);
    (drawing, y + 0.4 * sizes.body)
}

/// Draws a muted text, wrapped to the page, from `y` on; returns the y below it.
pub(super) fn draw_paragraph(drawing: &mut Drawing, content: &str, mut y: f64, body: f64) -> f64 {
    for line in page_lines(drawing, content, body, Weight::Regular) {
        y += body;
        drawing.text(Text::new(line, body, [BORDER, y], Anchor::Start).coloured(MUTED));
        y += (LINE_PITCH - 1.0) * body;
    }
    y
}

/// Draws a remark in bold below `y`; returns its lower end.
pub(super) fn draw_note(drawing: &mut Drawing, note: &str, mut y: f64, body: f64) -> f64 {
    for line in text::wrap(note, body, Weight::Bold, drawing.width - 2.0 * BORDER) {
        y += 1.3 * body;
        drawing.text(Text::new(line, body, [BORDER, y], Anchor::Start).bold());
    }
    y
}

/// Returns a text wrapped to the width of the page, in lines of similar width.
fn page_lines(drawing: &Drawing, content: &str, size: f64, weight: Weight) -> Vec<String> {
    text::wrap_balanced(content, size, weight, drawing.width - 2.0 * BORDER)
}
