//! The embedded font: widths of texts, positions of letters, and line breaks. plotters (as of 0.3.7) measures text in whole units only,
//! and sets the letters of a bitmap without the blank at their left.

use std::sync::LazyLock;

use ab_glyph::{Font, FontRef, PxScale, ScaleFont};
use plotters::style::{FontDesc, FontFamily, FontStyle, register_font};

use crate::files::visible::visible;

/// Name under which plotters knows the embedded font.
const FAMILY: &str = "DejaVu Sans";

/// Height of a capital letter as a multiple of the type size.
const CAPITAL: f64 = 0.73;
/// Distance of baselines as a multiple of the type size.
pub(super) const LINE_PITCH: f64 = 1.3;

static REGULAR: LazyLock<FontRef<'static>> =
    LazyLock::new(|| embedded_font(FontStyle::Normal, include_bytes!("fonts/DejaVuSans.ttf")));
static BOLD: LazyLock<FontRef<'static>> =
    LazyLock::new(|| embedded_font(FontStyle::Bold, include_bytes!("fonts/DejaVuSans-Bold.ttf")));

/// Returns an embedded font for measuring, and registers it with plotters for drawing.
fn embedded_font(style: FontStyle, bytes: &'static [u8]) -> FontRef<'static> {
    let registered = register_font(FAMILY, style, bytes).is_ok();
    FontRef::try_from_slice(bytes).ok().filter(|_| registered).expect("the font embedded at compile time is valid")
}

/// Thickness of letters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Weight {
    /// Used for most texts.
    Regular,
    /// Used for titles, marks and remarks.
    Bold,
}

impl Weight {
    /// Returns the embedded font of this weight.
    pub(crate) fn font(self) -> &'static FontRef<'static> {
        match self {
            Self::Regular => &REGULAR,
            Self::Bold => &BOLD,
        }
    }
}

/// Returns the height of ascenders and descenders together at a type size; ab_glyph and plotters scale fonts by it.
fn font_height(font: &FontRef<'_>, size: f64) -> f64 {
    let em = f64::from(font.units_per_em().unwrap_or(2048.0));
    size * f64::from(font.height_unscaled()) / em
}

/// A letter of a line, with the x of its pen position and of the left end of its ink.
pub(super) struct Letter {
    pub letter: char,
    pub pen: f64,
    pub ink: f64,
}

/// Returns the letters of one line that starts at x = 0, and the width of the line in pixels.
pub(super) fn layout(content: &str, size: f64, weight: Weight) -> (Vec<Letter>, f64) {
    layout_within(content, size, weight, f64::INFINITY)
}

/// Returns the letters of a line that are within `limit` pixels, at least the first, and their width in pixels.
fn layout_within(content: &str, size: f64, weight: Weight, limit: f64) -> (Vec<Letter>, f64) {
    let font = weight.font();
    let font = font.as_scaled(PxScale::from(font_height(font, size) as f32));
    let mut x = 0.0;
    let mut previous = None;
    let mut letters = Vec::new();
    for letter in content.chars() {
        let id = font.glyph_id(letter);
        let pen = x + previous.map_or(0.0, |previous| font.kern(previous, id));
        if !letters.is_empty() && f64::from(pen + font.h_advance(id)) > limit {
            break;
        }
        letters.push(Letter { letter, pen: f64::from(pen), ink: f64::from(pen + font.h_side_bearing(id).floor()) });
        x = pen + font.h_advance(id);
        previous = Some(id);
    }
    (letters, f64::from(x))
}

/// Returns the font units per type size.
pub(super) fn units_per_em(weight: Weight) -> f64 {
    f64::from(weight.font().units_per_em().unwrap_or(2048.0))
}

/// Returns the font for plotters, scaled to this height of ascenders and descenders.
pub(super) fn font(height: f64, weight: Weight) -> FontDesc<'static> {
    let style = match weight {
        Weight::Regular => FontStyle::Normal,
        Weight::Bold => FontStyle::Bold,
    };
    LazyLock::force(&REGULAR);
    LazyLock::force(&BOLD);
    FontDesc::new(FontFamily::Name(FAMILY), height, style)
}

/// Returns the even whole number nearest to the font's height at type size `size`: plotters puts the baseline at half of it.
pub(super) fn even_height(size: f64) -> f64 {
    2.0 * (font_height(&REGULAR, size) / 2.0).round()
}

/// Returns the text with blanks for control characters, which SVG does not allow, and with invisible format characters written out.
pub(super) fn printable(content: &str) -> String {
    visible(&content.replace(char::is_control, " ")).into_owned()
}

/// Returns the width of one line of text in pixels, at type size `size`.
pub fn width(content: &str, size: f64, weight: Weight) -> f64 {
    layout(content, size, weight).1
}

/// Returns the height of capitals and digits in pixels.
pub(super) fn capital_height(size: f64) -> f64 {
    CAPITAL * size
}

/// Breaks a text into lines no wider than `limit` pixels: at spaces, and within words longer than a line.
pub fn wrap(content: &str, size: f64, weight: Weight, limit: f64) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    let fits = |line: &str| width(line, size, weight) <= limit;
    // No-break spaces hold words together.
    for word in content.split([' ', '\n', '\t']).filter(|word| !word.is_empty()) {
        match lines.last_mut() {
            Some(line) if fits(&format!("{line} {word}")) => {
                line.push(' ');
                line.push_str(word);
            }
            _ if fits(word) => lines.push(word.to_owned()),
            _ => {
                let mut rest = word;
                while !rest.is_empty() {
                    let (letters, _) = layout_within(rest, size, weight, limit);
                    let (line, behind) = rest.split_at(letters.iter().map(|own| own.letter.len_utf8()).sum());
                    lines.push(line.to_owned());
                    rest = behind;
                }
            }
        }
    }
    lines
}

/// Breaks a text into as few lines as [`wrap`] does, but of nearly equal width.
pub(super) fn wrap_balanced(content: &str, size: f64, weight: Weight, limit: f64) -> Vec<String> {
    let greedy = wrap(content, size, weight, limit);
    let shares = (50..100).map(|percent| wrap(content, size, weight, limit * f64::from(percent) / 100.0));
    shares.into_iter().find(|lines| lines.len() == greedy.len()).unwrap_or(greedy)
}
