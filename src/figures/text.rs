//! The embedded font: how wide a text is, where its letters stand and its lines break. plotters (as of 0.3.7) measures text
//! in whole units only, and sets the letters of a bitmap without the blank at their left.

use std::sync::LazyLock;

use ab_glyph::{Font, FontRef, PxScale, ScaleFont};
use plotters::style::{FontDesc, FontFamily, FontStyle, register_font};

use crate::files::visible::visible;

/// The name plotters knows the embedded font by.
const FAMILY: &str = "DejaVu Sans";

/// Height of a capital letter over the type size.
const CAPITAL: f64 = 0.73;
/// Distance of baselines over the type size.
pub(super) const LINE_PITCH: f64 = 1.3;

static REGULAR: LazyLock<FontRef<'static>> =
    LazyLock::new(|| embedded(FontStyle::Normal, include_bytes!("fonts/DejaVuSans.ttf")));
static BOLD: LazyLock<FontRef<'static>> =
    LazyLock::new(|| embedded(FontStyle::Bold, include_bytes!("fonts/DejaVuSans-Bold.ttf")));

/// The font for measuring, registered with plotters for drawing.
fn embedded(style: FontStyle, bytes: &'static [u8]) -> FontRef<'static> {
    let registered = register_font(FAMILY, style, bytes).is_ok();
    FontRef::try_from_slice(bytes).ok().filter(|_| registered).expect("the font embedded at compile time is valid")
}

/// How strong letters are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Weight {
    /// Of most texts.
    Regular,
    /// Of titles, marks and remarks.
    Bold,
}

impl Weight {
    pub(crate) fn font(self) -> &'static FontRef<'static> {
        match self {
            Self::Regular => &REGULAR,
            Self::Bold => &BOLD,
        }
    }
}

/// Height of ascenders and descenders, by which fonts are scaled, at a type size.
fn height(font: &FontRef<'_>, size: f64) -> f64 {
    let em = f64::from(font.units_per_em().unwrap_or(2048.0));
    size * f64::from(font.height_unscaled()) / em
}

/// A letter of a line: where its pen and its ink begin.
struct Letter {
    letter: char,
    pen: f64,
    ink: f64,
}

/// The letters of one line from x = 0 on, and the width of the line.
fn layout(content: &str, size: f64, weight: Weight) -> (Vec<Letter>, f64) {
    let font = weight.font();
    let font = font.as_scaled(PxScale::from(height(font, size) as f32));
    let mut x = 0.0;
    let mut last = None;
    let mut letters = Vec::new();
    for letter in content.chars() {
        let id = font.glyph_id(letter);
        x += last.map_or(0.0, |last| font.kern(last, id));
        letters.push(Letter { letter, pen: f64::from(x), ink: f64::from(x + font.h_side_bearing(id).floor()) });
        x += font.h_advance(id);
        last = Some(id);
    }
    (letters, f64::from(x))
}

/// The letters of one line with the left end of their ink.
pub(super) fn letters(content: &str, size: f64, weight: Weight) -> Vec<(char, f64)> {
    layout(content, size, weight).0.into_iter().map(|letter| (letter.letter, letter.ink)).collect()
}

/// The letters of one line with the place of the pen.
pub(super) fn pens(content: &str, size: f64, weight: Weight) -> Vec<(char, f64)> {
    layout(content, size, weight).0.into_iter().map(|letter| (letter.letter, letter.pen)).collect()
}

/// Font units of a type size.
pub(super) fn units_per_em(weight: Weight) -> f64 {
    f64::from(weight.font().units_per_em().unwrap_or(2048.0))
}

/// The font as plotters draws it, scaled to the height of ascenders and descenders.
pub(super) fn font(height: f64, weight: Weight) -> FontDesc<'static> {
    let style = match weight {
        Weight::Regular => FontStyle::Normal,
        Weight::Bold => FontStyle::Bold,
    };
    LazyLock::force(&REGULAR);
    LazyLock::force(&BOLD);
    FontDesc::new(FontFamily::Name(FAMILY), height, style)
}

/// The even whole number nearest to the height of the font: half of it is where plotters puts the baseline.
pub(super) fn even_height(size: f64) -> f64 {
    2.0 * (height(&REGULAR, size) / 2.0).round()
}

/// The content without control characters, which SVG does not allow, and with others that act written out.
pub(super) fn printable(content: &str) -> String {
    visible(&content.replace(char::is_control, " ")).into_owned()
}

/// Width of one line in pixels.
pub fn width(content: &str, size: f64, weight: Weight) -> f64 {
    layout(content, size, weight).1
}

/// Height of capitals and digits in pixels.
pub(super) fn capital_height(size: f64) -> f64 {
    CAPITAL * size
}

/// The content in lines no wider than `limit`, broken at spaces, and within a word that is longer than a line.
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
                lines.push(String::new());
                for letter in word.chars() {
                    match lines.last_mut() {
                        Some(line) if line.is_empty() || fits(&format!("{line}{letter}")) => line.push(letter),
                        _ => lines.push(letter.to_string()),
                    }
                }
            }
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
