//! The surface of a part in three dimensions, coloured by a quantity, in views side by side.

use super::colour_bar::{ColourBar, Scale};
use super::colours::{Colours, Shading};
use super::drawing::{Anchor, Drawing, Text};
use super::error::{FigureError, check_drawable};
use super::field::{Picture, Rgba};
use super::projection::Projection;
use super::style::{self, BORDER, Sizes};
use super::text::LINE_PITCH;

/// Direction of view: the eye stands at one of these azimuths from +x, the first unless another shows more of what was cut, and this elevation from the xy
/// plane, in degrees.
const AZIMUTHS: [f64; 4] = [-60.0, 30.0, 120.0, 210.0];
/// How much more another azimuth has to show.
const MORE: f64 = 1.02;
const ELEVATION: f64 = 45.0;
const GAP: f64 = 30.0;
/// Highest view, in pixels.
const TALLEST: f64 = 700.0;
/// Pixels of the page for one of the picture.
const PIXEL: f64 = 1.25;
/// Where the light comes from at the first azimuth, as a unit vector, and the share of it that is everywhere.
const LIGHT: [f64; 3] = [-0.36, -0.48, 0.8];
const AMBIENT: f64 = 0.62;
/// Grey of what was not cut.
const SKIN: [u8; 3] = [176, 180, 188];
/// Name of what has no value.
const UNKNOWN: &str = "not known";

/// What a face of the part shows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FaceValue {
    /// The skin of the stock: nothing was cut.
    Skin,
    /// No value, though it was cut.
    Unknown,
    /// A value.
    Value(f64),
}

/// The surface of a part, seen obliquely from above.
#[derive(Debug, Clone, PartialEq)]
pub struct PartFigure {
    /// Question that the figure answers.
    pub title: String,
    /// Conditions of the computation.
    pub subtitle: String,
    /// Label of the colour bar, for example "deviation \[mm\]".
    pub quantity: String,
    /// Corners of its faces in turn, counter-clockwise seen from outside, z up, mm.
    pub faces: Vec<[[f64; 3]; 4]>,
    /// Views from left to right: a title in lines, and what each face shows.
    pub views: Vec<(String, Vec<FaceValue>)>,
    /// Ends of the colour scale.
    pub range: (f64, f64),
    /// Remark a reader must not miss.
    pub note: String,
}

/// Lays the figure out in `colours`; `Err` when its data cannot be drawn.
pub(super) fn drawing(figure: &PartFigure, colours: Colours, sizes: Sizes) -> Result<Drawing, FigureError> {
    if figure.faces.is_empty() || figure.views.is_empty() {
        return Err(FigureError::Empty { what: "part".into() });
    }
    check_drawable(figure.faces.iter().flatten().flatten().copied(), || "part".into())?;
    for (name, values) in &figure.views {
        if values.len() != figure.faces.len() {
            let (what, found, expected) = (name.clone(), values.len(), figure.faces.len());
            return Err(FigureError::GridMismatch { what, found, expected });
        }
    }
    let all = || figure.views.iter().flat_map(|view| &view.1);
    let values = all().filter_map(|face| if let FaceValue::Value(value) = face { Some(*value) } else { None });
    let scale = Scale::new(values, Some(figure.range), colours, Shading::Ordered)?;
    let missing = all().any(|face| *face == FaceValue::Unknown).then_some(UNKNOWN);
    let bar = ColourBar { scale, quantity: &figure.quantity, missing, size: sizes.body, tick_size: sizes.tick };
    let (mut drawing, top) = style::page_with_heading(&figure.title, &figure.subtitle, sizes);
    let azimuth = azimuth_of(figure);
    let mut projection = Projection::new(azimuth, ELEVATION);
    let [(x0, x1), (y0, y1)] = projection.ranges(figure.faces.iter().flatten().copied());
    let columns = figure.views.len().min(sizes.columns);
    let count = columns as f64;
    let beside = if sizes.is_portrait() { 0.0 } else { bar.width(0.6 * TALLEST) };
    let width = (sizes.width - 2.0 * BORDER - beside - count * GAP) / count;
    projection.scale = (width / (x1 - x0)).min(TALLEST / (y1 - y0));
    let height = projection.scale * (y1 - y0);
    let drawn = projection.scale * (x1 - x0);
    projection.origin = [-projection.scale * x0, -projection.scale * y0];
    let lines = figure.views.iter().map(|view| view.0.lines().count()).max().unwrap_or(0);
    let view_top = top + (LINE_PITCH * lines as f64 + 0.5) * sizes.body;
    let pitch = view_top - top + height + GAP;
    for (number, (title, values)) in figure.views.iter().enumerate() {
        let left = BORDER + (number % columns) as f64 * (width + GAP) + 0.5 * (width - drawn);
        let below = (number / columns) as f64 * pitch;
        for (line, words) in title.lines().enumerate() {
            let at = [left + 0.5 * drawn, top + below + sizes.body * (1.0 + LINE_PITCH * line as f64)];
            drawing.text(Text::new(words, sizes.body, at, Anchor::Middle));
        }
        let pixels = draw(&figure.faces, values, &projection, light_at(azimuth), [drawn, height], scale);
        drawing.picture(pixels.picture([left, view_top + below], [drawn, height]));
    }
    let mut bottom = view_top + height + (figure.views.len().div_ceil(columns) - 1) as f64 * pitch;
    if sizes.is_portrait() {
        bottom = bar.draw_across(&mut drawing, 2.0 * BORDER, bottom + sizes.body, sizes.width - 4.0 * BORDER);
    } else {
        let bar_height = height.clamp(0.5 * TALLEST, 0.6 * TALLEST);
        bar.draw(&mut drawing, sizes.width - BORDER - bar.width(bar_height), view_top, bar_height);
        bottom = bottom.max(view_top + bar_height);
    }
    if !figure.note.is_empty() {
        bottom = style::draw_paragraph(&mut drawing, &figure.note, bottom + sizes.body, sizes.body);
    }
    drawing.height = bottom + BORDER;
    Ok(drawing)
}

/// A picture with the depth of each pixel.
struct Pixels {
    count: [usize; 2],
    depths: Vec<f64>,
    colours: Vec<Rgba>,
}

/// Draws the faces into a picture of a view of `size`, nearer ones over those behind.
fn draw(
    faces: &[[[f64; 3]; 4]],
    values: &[FaceValue],
    projection: &Projection,
    light: [f64; 3],
    size: [f64; 2],
    scale: Option<Scale>,
) -> Pixels {
    let count = size.map(|side| (side / PIXEL).ceil().max(1.0) as usize);
    let cells = count[0] * count[1];
    let mut pixels = Pixels { count, depths: vec![f64::INFINITY; cells], colours: vec![[0; 4]; cells] };
    for (face, value) in faces.iter().zip(values) {
        let [r, g, b] = match (value, scale) {
            (FaceValue::Value(value), Some(scale)) => {
                let [r, g, b, _] = scale.colour(*value);
                [r, g, b]
            }
            (FaceValue::Unknown, _) => style::HATCH,
            _ => SKIN,
        };
        let light = AMBIENT + (1.0 - AMBIENT) * facing(face, light);
        let shaded = [r, g, b].map(|own| (f64::from(own) * light).round() as u8);
        let corners = face.map(|corner| {
            let [x, y] = projection.project(corner);
            [x / size[0] * count[0] as f64, y / size[1] * count[1] as f64, projection.depth(corner)]
        });
        let colour = [shaded[0], shaded[1], shaded[2], u8::MAX];
        for triangle in [[0, 1, 2], [0, 2, 3]] {
            pixels.fill(triangle.map(|corner| corners[corner]), colour);
        }
    }
    pixels
}

/// Returns the azimuth from which most of what was cut is turned to the eye, in degrees.
fn azimuth_of(figure: &PartFigure) -> f64 {
    let cut = |k: &usize| figure.views.iter().any(|view| view.1[*k] != FaceValue::Skin);
    let normals: Vec<[f64; 3]> = (0..figure.faces.len()).filter(cut).map(|k| normal(&figure.faces[k])).collect();
    let shown = |azimuth: f64| {
        let ((sine, cosine), (up, flat)) = (libm::sincos(azimuth.to_radians()), libm::sincos(ELEVATION.to_radians()));
        normals.iter().map(|own| (flat * (cosine * own[0] + sine * own[1]) + up * own[2]).max(0.0)).sum::<f64>()
    };
    let first = (AZIMUTHS[0], shown(AZIMUTHS[0]));
    let better = |best: (f64, f64), own: (f64, f64)| if own.1 > MORE * best.1 { own } else { best };
    AZIMUTHS[1..].iter().map(|own| (*own, shown(*own))).fold(first, better).0
}

/// Returns where the light comes from for an eye at this azimuth.
fn light_at(azimuth: f64) -> [f64; 3] {
    let (sine, cosine) = libm::sincos((azimuth - AZIMUTHS[0]).to_radians());
    [cosine * LIGHT[0] - sine * LIGHT[1], sine * LIGHT[0] + cosine * LIGHT[1], LIGHT[2]]
}

/// Returns the normal of a face, twice as long as its area.
fn normal([a, b, c, d]: &[[f64; 3]; 4]) -> [f64; 3] {
    let minus = |p: &[f64; 3], q: &[f64; 3]| [0, 1, 2].map(|axis| p[axis] - q[axis]);
    let (u, v) = (minus(c, a), minus(d, b));
    [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
}

/// Returns the share of the light that a face gets, 0 to 1.
fn facing(face: &[[f64; 3]; 4], light: [f64; 3]) -> f64 {
    let normal = normal(face);
    let length = normal.iter().map(|own| own * own).sum::<f64>().sqrt();
    let cosine = normal.iter().zip(light).map(|(own, light)| own * light).sum::<f64>() / length;
    if length > 0.0 { cosine.max(0.0) } else { 1.0 }
}

impl Pixels {
    /// Fills a triangle, corners as column, row and depth.
    fn fill(&mut self, [a, b, c]: [[f64; 3]; 3], colour: Rgba) {
        let area = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
        if area == 0.0 {
            return;
        }
        let range = |axis: usize| {
            let low = a[axis].min(b[axis]).min(c[axis]);
            let high = a[axis].max(b[axis]).max(c[axis]);
            (low - 0.5).ceil().max(0.0) as usize..(high + 0.5).floor().clamp(0.0, self.count[axis] as f64) as usize
        };
        let (columns, rows) = (range(0), range(1));
        // Half a pixel beyond its edges, so that no seam shows between faces.
        let slack = |from: [f64; 3], to: [f64; 3]| 0.5 * ((to[0] - from[0]).abs() + (to[1] - from[1]).abs());
        let slacks = [slack(b, c), slack(c, a), slack(a, b)].map(|own| -own / area.abs());
        for row in rows {
            for column in columns.clone() {
                let (x, y) = (column as f64 + 0.5, row as f64 + 0.5);
                let share = |p: [f64; 3], q: [f64; 3]| ((q[0] - p[0]) * (y - p[1]) - (x - p[0]) * (q[1] - p[1])) / area;
                let shares = [share(b, c), share(c, a), share(a, b)];
                if shares.iter().zip(slacks).any(|(own, least)| *own < least) {
                    continue;
                }
                let depth = shares[0] * a[2] + shares[1] * b[2] + shares[2] * c[2];
                let at = row * self.count[0] + column;
                if depth < self.depths[at] {
                    (self.depths[at], self.colours[at]) = (depth, colour);
                }
            }
        }
    }

    fn picture(&self, [x, y]: [f64; 2], [width, height]: [f64; 2]) -> Picture {
        let edges = |count: usize| (0..=count).map(|own| own as f64).collect::<Vec<_>>();
        let [columns, rows] = self.count;
        // Rows of pictures go upwards.
        let colour = |column: usize, row: usize| Some(self.colours[(rows - 1 - row) * columns + column]);
        Picture::new([[x, y], [width, 0.0], [0.0, height]], &edges(columns), &edges(rows), colour)
    }
}
