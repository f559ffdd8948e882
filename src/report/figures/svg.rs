//! A scene as an SVG document.

use std::fmt::Write;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

use super::error::FigureError;
use super::png;
use super::scene::{Anchor, Item, Picture, Point, Rgb, Scene, Stroke, Text};
use super::text::{FAMILY, Weight};

/// Writes the document; pictures are embedded as PNG, so that no seams show between their cells.
pub(super) fn document(scene: &Scene) -> Result<String, FigureError> {
    let (width, height) = (number(scene.width), number(scene.height));
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
         viewBox=\"0 0 {width} {height}\" font-family=\"{FAMILY}\" fill=\"none\" stroke-linecap=\"round\" \
         stroke-linejoin=\"round\">\n<title>{}</title>\n\
         <rect width=\"{width}\" height=\"{height}\" fill=\"#ffffff\"/>\n",
        escape(&scene.title)
    );
    for item in &scene.items {
        let element = match item {
            Item::Line { points, closed, stroke } => line(points, *closed, stroke),
            Item::Circle { centre, radius, stroke } => {
                let (x, y) = (number(centre[0]), number(centre[1]));
                format!("<circle cx=\"{x}\" cy=\"{y}\" r=\"{}\"{}/>", number(*radius), stroke_attributes(stroke))
            }
            Item::Convex { corners, fill } => {
                format!("<path d=\"{}\" fill=\"{}\"/>", path(corners, true), hex(*fill))
            }
            Item::Text(text) => text_element(text),
            Item::Picture(picture) => image(picture)?,
        };
        out.push_str(&element);
        out.push('\n');
    }
    out.push_str("</svg>\n");
    Ok(out)
}

fn line(points: &[Point], closed: bool, stroke: &Stroke) -> String {
    format!("<path d=\"{}\"{}/>", path(points, closed), stroke_attributes(stroke))
}

fn path(points: &[Point], closed: bool) -> String {
    let places: Vec<String> = points.iter().map(|p| format!("{} {}", number(p[0]), number(p[1]))).collect();
    format!("M{}{}", places.join("L"), if closed { "Z" } else { "" })
}

fn stroke_attributes(stroke: &Stroke) -> String {
    let mut out = format!(" stroke=\"{}\" stroke-width=\"{}\"", hex(stroke.colour), number(stroke.width));
    if !stroke.dash.is_empty() {
        let dash: Vec<String> = stroke.dash.iter().map(|length| number(*length)).collect();
        let _ = write!(out, " stroke-dasharray=\"{}\"", dash.join(" "));
    }
    out
}

fn text_element(text: &Text) -> String {
    let (x, y) = (number(text.at[0]), number(text.at[1]));
    let mut attributes = format!("x=\"{x}\" y=\"{y}\" font-size=\"{}\"", number(text.size));
    let _ = write!(attributes, " fill=\"{}\"", hex(text.colour));
    match text.anchor {
        Anchor::Start => {}
        Anchor::Middle => attributes.push_str(" text-anchor=\"middle\""),
        Anchor::End => attributes.push_str(" text-anchor=\"end\""),
    }
    if text.weight == Weight::Bold {
        attributes.push_str(" font-weight=\"bold\"");
    }
    if text.upward {
        let _ = write!(attributes, " transform=\"rotate(-90 {x} {y})\"");
    }
    if text.halo {
        let width = number(2.0 * png::halo_radius(text.size));
        let _ = write!(attributes, " stroke=\"#ffffff\" stroke-width=\"{width}\" paint-order=\"stroke\"");
    }
    format!("<text {attributes}>{}</text>", escape(&text.content))
}

fn image(picture: &Picture) -> Result<String, FigureError> {
    let bytes = png::encode(picture.columns, picture.rows, &picture.pixels.concat())?;
    let [a, b] = picture.across;
    let [c, d] = picture.down;
    let [e, f] = picture.origin;
    let matrix = [a, b, c, d, e, f].map(number).join(" ");
    Ok(format!(
        "<image width=\"1\" height=\"1\" preserveAspectRatio=\"none\" transform=\"matrix({matrix})\" \
         href=\"data:image/png;base64,{}\"/>",
        STANDARD.encode(bytes)
    ))
}

/// Two decimals at most, no trailing zeros, no negative zero.
fn number(value: f64) -> String {
    let rounded = (100.0 * value).round() / 100.0 + 0.0;
    format!("{rounded}")
}

fn hex([r, g, b]: Rgb) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

fn escape(content: &str) -> String {
    let mut out = String::with_capacity(content.len());
    for character in content.chars() {
        match character {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            c if c.is_control() => out.push(' '),
            c => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_escaped() {
        assert_eq!(escape("a<b & c\u{1}"), "a&lt;b &amp; c ");
    }

    #[test]
    fn numbers_are_short() {
        assert_eq!(number(-0.001), "0");
        assert_eq!(number(12.5), "12.5");
        assert_eq!(number(1.0 / 3.0), "0.33");
    }
}
