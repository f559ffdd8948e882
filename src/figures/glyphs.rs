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
        let em = scale * text.size;
        let [x, y] = text.at.map(|place| decimals(scale * place));
        let turn = if text.upward { " rotate(-90)" } else { "" };
        let size = em / GRID;
        let label = escaped(&text.content);
        lines += &format!(
            "<g role=\"img\" aria-label=\"{label}\" fill=\"{}\" \
             transform=\"translate({x} {y}){turn} scale({size:.4} -{size:.4})\">",
            super::svg::hex(text.colour)
        );
        for (letter, pen) in text::pens(&text.content, em, text.weight) {
            let id = id(letter, text.weight);
            if let Some(path) = outline(letter, text.weight) {
                outlines.entry(id.clone()).or_insert(path);
                lines += &format!("<use href=\"#{id}\" x=\"{}\"/>", ((scale * text.start() + pen) / size).round());
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

/// Parts of the type size between which the points of outlines lie: finer than a screen shows.
const GRID: f64 = 256.0;

/// The outline of a letter on the grid, y upward, as relative path data; `None` for a blank.
fn outline(letter: char, weight: Weight) -> Option<String> {
    let font = weight.font();
    let curves = font.outline(font.glyph_id(letter))?.curves;
    let unit = GRID / text::units_per_em(weight);
    let on_grid = |p: Corner| [p.x, p.y].map(|v| (f64::from(v) * unit).round() as i64);
    let mut path = String::new();
    let mut at: Option<Corner> = None;
    let mut pen = [0, 0];
    let mut last = ' ';
    let mut command = |path: &mut String, letter: char, places: &[Corner]| {
        if letter != last || letter == 'm' {
            path.push(letter);
            last = letter;
        } else if !path.ends_with(' ') {
            path.push(' ');
        }
        let numbers: Vec<String> = places
            .iter()
            .flat_map(|place| {
                let [x, y] = on_grid(*place);
                [x - pen[0], y - pen[1]]
            })
            .map(|number| number.to_string())
            .collect();
        *path += &numbers.join(" ");
        pen = places.last().map_or(pen, |place| on_grid(*place));
    };
    for curve in curves {
        let from = match curve {
            OutlineCurve::Line(from, _) | OutlineCurve::Quad(from, ..) | OutlineCurve::Cubic(from, ..) => from,
        };
        if at != Some(from) {
            command(&mut path, 'm', &[from]);
        }
        let to = match curve {
            OutlineCurve::Line(_, to) => {
                command(&mut path, 'l', &[to]);
                to
            }
            OutlineCurve::Quad(_, c, to) => {
                command(&mut path, 'q', &[c, to]);
                to
            }
            OutlineCurve::Cubic(_, c, d, to) => {
                command(&mut path, 'c', &[c, d, to]);
                to
            }
        };
        at = Some(to);
    }
    (!path.is_empty()).then(|| path.replace(" -", "-"))
}
