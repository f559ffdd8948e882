//! Text of an SVG as outlines, so that it looks the same wherever it is opened; the words stay as labels. plotters (as of
//! 0.3.7) writes text with the name of its font, and a viewer without that font sets other widths than were laid out.

use std::collections::BTreeMap;

use ab_glyph::{Font, OutlineCurve, Point as Corner};

use super::scene::Text;
use super::text::{self, Weight};

/// `texts` as SVG elements, in units of `scale` to the page pixel: each letter's outline once, then where it is used.
pub(super) fn svg(texts: &[&Text], scale: f64) -> String {
    let mut outlines = BTreeMap::new();
    let mut lines = String::new();
    for text in texts {
        let (em, unit) = (scale * text.size, text::units_per_em(text.weight));
        let [x, y] = text.at.map(|place| decimals(scale * place));
        let turn = if text.upward { " rotate(-90)" } else { "" };
        let size = em / unit;
        let [r, g, b] = text.colour;
        let label = escaped(&text.content);
        lines += &format!(
            "<g role=\"img\" aria-label=\"{label}\" fill=\"#{r:02X}{g:02X}{b:02X}\" \
             transform=\"translate({x} {y}){turn} scale({size:.5} -{size:.5})\">"
        );
        for (letter, pen) in text::pens(&text.content, em, text.weight) {
            let id = id(letter, text.weight);
            if let Some(path) = outline(letter, text.weight) {
                outlines.entry(id.clone()).or_insert(path);
                lines += &format!("<use href=\"#{id}\" x=\"{}\"/>", decimals((scale * text.start() + pen) / size));
            }
        }
        lines += "</g>\n";
    }
    let defined = outlines.iter().map(|(id, path)| format!("<path id=\"{id}\" d=\"{path}\"/>\n"));
    format!("<defs>\n{}</defs>\n{lines}", defined.collect::<String>())
}

fn id(letter: char, weight: Weight) -> String {
    let prefix = if weight == Weight::Bold { 'b' } else { 'r' };
    format!("{prefix}{:x}", letter as u32)
}

fn escaped(content: &str) -> String {
    content.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;")
}

/// A tenth of a unit is less than any screen shows.
fn decimals(value: f64) -> String {
    let text = format!("{value:.1}");
    text.strip_suffix(".0").map_or(text.clone(), String::from)
}

/// The outline of a letter in font units, y upward; `None` for a blank.
fn outline(letter: char, weight: Weight) -> Option<String> {
    let font = weight.font();
    let curves = font.outline(font.glyph_id(letter))?.curves;
    let mut path = String::new();
    let mut at: Option<Corner> = None;
    for curve in curves {
        let (from, to, command) = match curve {
            OutlineCurve::Line(from, to) => (from, to, format!("L{} {}", to.x, to.y)),
            OutlineCurve::Quad(from, c, to) => (from, to, format!("Q{} {} {} {}", c.x, c.y, to.x, to.y)),
            OutlineCurve::Cubic(from, c, d, to) => {
                (from, to, format!("C{} {} {} {} {} {}", c.x, c.y, d.x, d.y, to.x, to.y))
            }
        };
        if at != Some(from) {
            path += &format!("M{} {}", from.x, from.y);
        }
        path += &command;
        at = Some(to);
    }
    (!path.is_empty()).then_some(path)
}
