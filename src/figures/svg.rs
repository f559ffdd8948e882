//! Writes a drawing as an SVG document.
//!
//! Colours stand as plain attributes, so that every viewer shows them; a page's styles may turn those of ink and paper for a dark theme.
//! Maps are small embedded images stretched over their place: an element for each cell would be several times as long.
//!
//! Texts are outlines, so that they look the same wherever they are opened; the words stay as labels. plotters (as of 0.3.7)
//! writes text with the name of its font, and a viewer without that font sets other widths than were laid out.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use ab_glyph::{Font, OutlineCurve, Point as Corner};
use base64::{Engine, engine::general_purpose::STANDARD};

use super::drawing::{Drawing, Item, Point, Rect, Rgb, Stroke, Text};
use super::error::FigureError;
use super::field::Picture;
use super::png;
use super::shapes::simplify_line;
use super::style::{HATCH, WHITE};
use super::text::{self, Letter, Weight};
use super::theme;

/// Drawing units per page pixel, along each axis.
const SCALE: f64 = 3.0;
/// Opacity of the white behind text over colours.
const BACKING: f64 = 0.8;
/// Stroke of the hatching over cells without a value.
pub(super) const HATCHING: Stroke = Stroke { colour: HATCH, width: 2.0, dash: &[] };

/// Returns the drawing as an SVG document; texts are outlines with their words as labels. `Err` when a map cannot be encoded.
pub fn svg(drawing: &Drawing) -> Result<String, FigureError> {
    let [width, height] = [drawing.width, drawing.height].map(f64::round);
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {} {}\" \
         fill=\"none\" stroke-linecap=\"round\" stroke-linejoin=\"round\">\n<title>{}</title>\n",
        SCALE * width,
        SCALE * height,
        text::printable(&drawing.title).replace('&', "&amp;").replace('<', "&lt;")
    );
    write_rectangle(&mut out, Rect { x: 0.0, y: 0.0, width, height }, WHITE, 1.0);
    let mut lines = Lines::default();
    for item in &drawing.items {
        match item {
            Item::Line { points, stroke } => {
                lines.flush_unless(*stroke, &mut out);
                lines.add(points);
            }
            Item::Convex { corners, fill } => {
                lines.flush(&mut out);
                let mut pen = Pen::default();
                pen.line(corners);
                let _ = writeln!(out, "<path fill=\"{}\" d=\"{}z\"/>", hex(*fill), pen.path);
            }
            Item::Picture(picture) => {
                lines.flush(&mut out);
                write_image(&mut out, picture)?;
                let mut hatching = Lines { stroke: Some(HATCHING), ..Lines::default() };
                picture.hatching().iter().for_each(|line| hatching.add(line));
                hatching.flush(&mut out);
            }
            Item::Text(_) => {}
        }
    }
    lines.flush(&mut out);
    let texts = || drawing.items.iter().filter_map(|item| if let Item::Text(text) = item { Some(text) } else { None });
    for text in texts().filter(|text| text.halo) {
        write_rectangle(&mut out, text.bounds(), WHITE, BACKING);
    }
    out += &text_as_glyphs(&texts().collect::<Vec<&Text>>());
    out += "</svg>\n";
    Ok(out)
}

/// Returns the document with a style for pages: dark where the reader's colour scheme is dark, light on paper. An embedded image follows
/// the colour scheme of the element that shows it (Media Queries 5).
pub fn with_dark_theme(svg: &str) -> String {
    let rule = |(light, dark): &(Rgb, Rgb)| {
        let (light, dark) = (hex(*light), hex(*dark));
        format!("[fill=\"{light}\"]{{fill:{dark}}}[stroke=\"{light}\"]{{stroke:{dark}}}")
    };
    let rules: String = theme::DARK.iter().map(rule).collect();
    let style = format!("<style>@media screen and (prefers-color-scheme:dark){{{rules}}}</style>");
    match svg.find("</title>") {
        Some(end) => [&svg[..end + "</title>".len()], &style, &svg[end + "</title>".len()..]].concat(),
        None => svg.to_owned(),
    }
}

/// Writes a filled rectangle element.
fn write_rectangle(out: &mut String, rect: Rect, fill: Rgb, opacity: f64) {
    let [x, y, width, height] = [rect.x, rect.y, rect.width, rect.height].map(to_units);
    let opacity = if opacity < 1.0 { format!(" opacity=\"{opacity}\"") } else { String::new() };
    let _ = writeln!(
        out,
        "<rect x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\" fill=\"{}\"{opacity}/>",
        hex(fill)
    );
}

/// Returns a colour as `#rrggbb`.
fn hex([r, g, b]: Rgb) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// Converts a length in page pixels to drawing units.
fn to_units(length: f64) -> i64 {
    (SCALE * length).round() as i64
}

/// Writes path data in whole drawing units, relative to the last position `at`.
#[derive(Default)]
struct Pen {
    path: String,
    at: Option<[i64; 2]>,
}

impl Pen {
    /// Appends a polyline, without points that do not show.
    fn line(&mut self, points: &[Point]) {
        let mut places: Vec<[i64; 2]> = simplify_line(points).iter().map(|p| p.map(to_units)).collect();
        places.dedup();
        for (k, [x, y]) in places.iter().copied().enumerate() {
            let [dx, dy] = self.at.map_or([x, y], |[x0, y0]| [x - x0, y - y0]);
            let _ = match k {
                0 => write!(self.path, "m{}", coordinate_pair(dx, dy)),
                1 => write!(self.path, "l{}", coordinate_pair(dx, dy)),
                _ if dx < 0 => write!(self.path, "{}", coordinate_pair(dx, dy)),
                _ => write!(self.path, " {}", coordinate_pair(dx, dy)),
            };
            self.at = Some([x, y]);
        }
        if places.len() == 1 {
            self.path.push_str("h0");
        }
    }
}

/// Returns two numbers as path data, without a blank before a minus sign.
fn coordinate_pair(x: i64, y: i64) -> String {
    if y < 0 { format!("{x}{y}") } else { format!("{x} {y}") }
}

/// Successive lines with the same stroke, which share one path element.
#[derive(Default)]
struct Lines {
    stroke: Option<Stroke>,
    pen: Pen,
}

impl Lines {
    /// Appends a polyline to the path.
    fn add(&mut self, points: &[Point]) {
        self.pen.line(points);
    }

    /// Writes out lines of another stroke, and continues with `stroke`.
    fn flush_unless(&mut self, stroke: Stroke, out: &mut String) {
        if self.stroke != Some(stroke) {
            self.flush(out);
            self.stroke = Some(stroke);
        }
    }

    /// Writes out the path element of the lines collected, if there are any.
    fn flush(&mut self, out: &mut String) {
        let path = std::mem::take(&mut self.pen).path;
        let Some(Stroke { colour, width, dash }) = self.stroke.take().filter(|_| !path.is_empty()) else { return };
        let dash = match dash {
            [] => String::new(),
            dash => {
                let lengths: Vec<String> = dash.iter().map(|length| to_units(*length).to_string()).collect();
                format!(" stroke-dasharray=\"{}\"", lengths.join(" "))
            }
        };
        let _ =
            writeln!(out, "<path stroke=\"{}\" stroke-width=\"{}\"{dash} d=\"{path}\"/>", hex(colour), to_units(width));
    }
}

/// Writes a grid of cells as an image of one pixel or a few for each cell, stretched over its parallelogram.
fn write_image(out: &mut String, picture: &Picture) -> Result<(), FigureError> {
    let data = STANDARD.encode(png::cells_png(picture)?);
    let number = |value: f64| {
        let text = format!("{:.1}", SCALE * value);
        text.strip_suffix(".0").map_or(text.clone(), String::from)
    };
    let [across, down, origin] = [picture.across, picture.down, picture.origin].map(|v| v.map(number).join(" "));
    let _ = writeln!(
        out,
        "<image width=\"1\" height=\"1\" preserveAspectRatio=\"none\" image-rendering=\"optimizeSpeed\" \
         style=\"image-rendering:pixelated\" transform=\"matrix({across} {down} {origin})\" \
         href=\"data:image/png;base64,{data}\"/>"
    );
    Ok(())
}

/// Returns `texts` as SVG elements: the outline of each letter once, and a reference to it wherever it occurs.
fn text_as_glyphs(texts: &[&Text]) -> String {
    let mut outlines = BTreeMap::new();
    let mut lines = String::new();
    for text in texts {
        let em = SCALE * text.size;
        let [x, y] = text.at.map(|place| one_decimal(SCALE * place));
        let turn = if text.upward { " rotate(-90)" } else { "" };
        let size = em / GRID;
        let label = escape_xml(&text.content);
        lines += &format!(
            "<g role=\"img\" aria-label=\"{label}\" fill=\"{}\" \
             transform=\"translate({x} {y}){turn} scale({size:.4} -{size:.4})\">",
            hex(text.colour)
        );
        for Letter { letter, pen, .. } in text::layout(&text.content, em, text.weight).0 {
            let id = letter_id(letter, text.weight);
            if let Some(path) = outline(letter, text.weight) {
                outlines.entry(id.clone()).or_insert(path);
                lines += &format!("<use href=\"#{id}\" x=\"{}\"/>", ((SCALE * text.start() + pen) / size).round());
            }
        }
        lines += "</g>\n";
    }
    let defined = outlines.iter().map(|(id, path)| format!("<path id=\"{id}\" d=\"{path}\"/>\n"));
    format!("<defs>\n{}</defs>\n{lines}", defined.collect::<String>())
}

/// Returns the element id of a letter's outline.
fn letter_id(letter: char, weight: Weight) -> String {
    let prefix = if weight == Weight::Bold { 'b' } else { 'r' };
    format!("{prefix}{:x}", letter as u32)
}

/// Escapes a text for use in an XML attribute.
fn escape_xml(content: &str) -> String {
    content.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;")
}

/// Formats a number with one decimal, or none if that is zero: a tenth of a unit is less than a screen shows.
fn one_decimal(value: f64) -> String {
    let text = format!("{value:.1}");
    text.strip_suffix(".0").map_or(text.clone(), String::from)
}

/// Steps of the grid on which outline points lie, per type size: finer than a screen shows.
const GRID: f64 = 256.0;

/// Returns the outline of a letter on the grid of [`GRID`] steps, y upward, as relative path data; `None` for a blank.
fn outline(letter: char, weight: Weight) -> Option<String> {
    let font = weight.font();
    let curves = font.outline(font.glyph_id(letter))?.curves;
    let unit = GRID / text::units_per_em(weight);
    let on_grid = |p: Corner| [p.x, p.y].map(|v| (f64::from(v) * unit).round() as i64);
    let mut path = String::new();
    let mut at: Option<Corner> = None;
    let mut pen = [0, 0];
    let mut last_command = ' ';
    let mut command = |path: &mut String, letter: char, places: &[Corner]| {
        if letter != last_command || letter == 'm' {
            path.push(letter);
            last_command = letter;
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
