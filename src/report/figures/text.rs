//! The embedded font: how wide a text is, where its lines break, which pixels it covers.

use std::sync::LazyLock;

use ab_glyph::{Font, FontRef, Glyph, PxScale, ScaleFont, point};

/// Family names for viewers; the embedded font first, then one of the same proportions.
pub(super) const FAMILY: &str = "DejaVu Sans, Verdana, sans-serif";

/// Height of a capital letter over the type size.
const CAPITAL: f64 = 0.73;
/// Distance of baselines over the type size.
pub(super) const LINE_PITCH: f64 = 1.3;

static REGULAR: LazyLock<FontRef<'static>> = LazyLock::new(|| embedded(include_bytes!("fonts/DejaVuSans.ttf")));
static BOLD: LazyLock<FontRef<'static>> = LazyLock::new(|| embedded(include_bytes!("fonts/DejaVuSans-Bold.ttf")));

fn embedded(bytes: &'static [u8]) -> FontRef<'static> {
    FontRef::try_from_slice(bytes).expect("the font embedded at compile time is valid")
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Weight {
    Regular,
    Bold,
}

impl Weight {
    fn font(self) -> &'static FontRef<'static> {
        match self {
            Self::Regular => &REGULAR,
            Self::Bold => &BOLD,
        }
    }
}

/// Pixel scale at which one em measures `size` pixels.
fn scale(font: &FontRef<'_>, size: f64) -> PxScale {
    let em = f64::from(font.units_per_em().unwrap_or(2048.0));
    PxScale::from((size * f64::from(font.height_unscaled()) / em) as f32)
}

/// Glyphs of one line from x = 0 on the baseline y = 0, and the width of the line.
fn layout(content: &str, size: f64, weight: Weight) -> (Vec<Glyph>, f64) {
    let font = weight.font();
    let scaled = font.as_scaled(scale(font, size));
    let mut x = 0.0;
    let mut glyphs: Vec<Glyph> = Vec::new();
    for character in content.chars() {
        let id = scaled.glyph_id(character);
        if let Some(last) = glyphs.last() {
            x += scaled.kern(last.id, id);
        }
        glyphs.push(id.with_scale_and_position(scaled.scale(), point(x, 0.0)));
        x += scaled.h_advance(id);
    }
    (glyphs, f64::from(x))
}

/// Width of one line in pixels.
pub(super) fn width(content: &str, size: f64, weight: Weight) -> f64 {
    layout(content, size, weight).1
}

/// Height of capitals and digits in pixels.
pub(super) fn capital_height(size: f64) -> f64 {
    CAPITAL * size
}

/// Calls `paint(x, y, coverage)` for each pixel of one line whose baseline starts at (0, 0).
pub(super) fn cover(content: &str, size: f64, weight: Weight, mut paint: impl FnMut(i32, i32, f32)) {
    for glyph in layout(content, size, weight).0 {
        if let Some(outline) = weight.font().outline_glyph(glyph) {
            let corner = outline.px_bounds().min;
            outline.draw(|x, y, coverage| paint(corner.x as i32 + x as i32, corner.y as i32 + y as i32, coverage));
        }
    }
}

/// The content in lines no wider than `limit`, broken at spaces; a single longer word keeps its own line.
pub(super) fn wrap(content: &str, size: f64, weight: Weight, limit: f64) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in content.split_whitespace() {
        match lines.last_mut() {
            Some(line) if width(&format!("{line} {word}"), size, weight) <= limit => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

/// As [`wrap`], in as many lines, but of nearly equal width.
pub(super) fn balanced(content: &str, size: f64, weight: Weight, limit: f64) -> Vec<String> {
    let greedy = wrap(content, size, weight, limit);
    let shares = (50..100).map(|percent| wrap(content, size, weight, limit * f64::from(percent) / 100.0));
    shares.into_iter().find(|lines| lines.len() == greedy.len()).unwrap_or(greedy)
}

/// `size`, or less if the line would be wider than `limit`.
pub(super) fn fitting_size(content: &str, size: f64, weight: Weight, limit: f64) -> f64 {
    let natural = width(content, size, weight);
    if natural > limit { size * limit.max(1.0) / natural } else { size }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wrapped_lines_keep_every_word_and_the_limit() {
        let lines = wrap("errors of the worst point over the workspace", 20.0, Weight::Regular, 200.0);
        assert!(lines.len() > 1);
        assert!(lines.iter().all(|line| width(line, 20.0, Weight::Regular) <= 200.0));
        assert_eq!(lines.join(" "), "errors of the worst point over the workspace");
    }

    #[test]
    fn width_grows_with_size_and_shrinks_to_fit() {
        let natural = width("workspace", 20.0, Weight::Regular);
        assert!((width("workspace", 40.0, Weight::Regular) - 2.0 * natural).abs() < 1e-3);
        let size = fitting_size("workspace", 20.0, Weight::Bold, 50.0);
        assert!(width("workspace", size, Weight::Bold) <= 50.01);
    }
}
