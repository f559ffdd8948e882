//! Writes a drawing as a PNG file, drawn by plotters.
//!
//! plotters places everything on whole units, and its bitmaps (as of 0.3.7, plotters-rs/plotters#350) smooth only lines one
//! unit wide and some borders of other shapes. A page pixel is divided into several units, which are averaged.

use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ColorType, ImageEncoder, RgbImage, RgbaImage};
use plotters::backend::{BitMapBackend, DrawingBackend};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color, FontTransform, RGBColor, TextStyle};

use super::drawing::{Drawing, Item, Point, Rect, Rgb, Stroke, Text};
use super::error::FigureError;
use super::field::Picture;
use super::style::WHITE;
use super::svg::HATCHING;
use super::text::{self, Letter};

/// Drawing units per page pixel, along each axis.
const SCALE: f64 = 3.0;
/// Drawing units per page pixel as a whole number.
const BLOCK: usize = SCALE as usize;
/// Opacity of the white behind text over colours.
const BACKING: f64 = 0.8;
/// Overlap of polygonal cells with their neighbours in pixels, so that no seams show.
const SEAM: f64 = 4.0;
/// Fewest pixels of an embedded image along a side with several cells: viewers that smooth images blur a cell's border by one.
const FINE: u32 = 160;

/// Returns the drawing as the bytes of a PNG file; `Err` when it cannot be drawn or encoded.
pub fn png(drawing: &Drawing) -> Result<Vec<u8>, FigureError> {
    let [width, height] = [drawing.width, drawing.height].map(|length| (SCALE * length.round()) as u32);
    let mut units = RgbImage::new(width, height);
    Painter { backend: BitMapBackend::with_buffer(&mut units, (width, height)) }.draw(drawing)?;
    let mut out = Vec::new();
    let encoder = PngEncoder::new_with_quality(&mut out, CompressionType::Best, FilterType::Adaptive);
    let [width, height] = [width, height].map(|length| length / BLOCK as u32);
    encoder.write_image(&block_means(&units), width, height, ColorType::Rgb8).map_err(fault)?;
    Ok(out)
}

/// Returns the mean colour of each block of units: rows of page pixels, three bytes each.
fn block_means(units: &RgbImage) -> Vec<u8> {
    let channels = 3 * units.width() as usize;
    let mut sums = vec![0_u16; channels / BLOCK];
    let mut page = Vec::with_capacity(units.len() / (BLOCK * BLOCK));
    for rows in units.chunks_exact(BLOCK * channels) {
        sums.fill(0);
        for row in rows.chunks_exact(channels) {
            for (sum, block) in sums.chunks_exact_mut(3).zip(row.chunks_exact(3 * BLOCK)) {
                for pixel in block.chunks_exact(3) {
                    (0..3).for_each(|k| sum[k] += u16::from(pixel[k]));
                }
            }
        }
        let count = (BLOCK * BLOCK) as u16;
        page.extend(sums.iter().map(|sum| ((sum + count / 2) / count) as u8));
    }
    page
}

/// Returns the cells of a picture as a PNG file, to be stretched over the picture's area; cells without a colour are transparent.
pub(super) fn cells_png(picture: &Picture) -> Result<Vec<u8>, FigureError> {
    let [width, height] =
        picture.pixel_counts().map(|parts| parts * FINE.div_ceil(parts).min(if parts > 1 { FINE } else { 1 }));
    let mut image = RgbaImage::new(width, height);
    let pixels = |[from, to]: [f64; 2], length: u32| {
        let at = |share: f64| (share * f64::from(length)).round() as u32;
        at(from)..at(to)
    };
    for (u, v, fill) in picture.cells() {
        for y in pixels(v, height) {
            pixels(u, width).for_each(|x| image.put_pixel(x, y, image::Rgba(fill.unwrap_or([0; 4]))));
        }
    }
    let mut out = Vec::new();
    let encoder = PngEncoder::new_with_quality(&mut out, CompressionType::Best, FilterType::Up);
    let is_opaque = image.pixels().all(|pixel| pixel.0[3] == u8::MAX);
    match is_opaque {
        true => {
            let opaque: Vec<u8> = image.pixels().flat_map(|pixel| [pixel.0[0], pixel.0[1], pixel.0[2]]).collect();
            encoder.write_image(&opaque, width, height, ColorType::Rgb8).map_err(fault)?;
        }
        false => encoder.write_image(&image, width, height, ColorType::Rgba8).map_err(fault)?,
    }
    Ok(out)
}

/// Converts an error of the drawing or encoding library.
fn fault(error: impl std::fmt::Display) -> FigureError {
    FigureError::Encode { reason: error.to_string() }
}

/// Converts a length in page pixels to drawing units.
fn to_units(length: f64) -> i32 {
    (SCALE * length).round() as i32
}

/// Converts a point in page pixels to drawing units.
fn to_unit_point([x, y]: Point) -> (i32, i32) {
    (to_units(x), to_units(y))
}

/// Converts a colour to the type of plotters.
fn to_plotters([r, g, b]: Rgb) -> RGBColor {
    RGBColor(r, g, b)
}

/// Draws a drawing on a plotters backend.
struct Painter<B> {
    backend: B,
}

impl<B: DrawingBackend> Painter<B> {
    /// Draws all items of the drawing over a white page.
    fn draw(mut self, drawing: &Drawing) -> Result<(), FigureError> {
        let page = Rect { x: 0.0, y: 0.0, width: drawing.width, height: drawing.height.round() };
        self.draw_rectangle(page, &to_plotters(WHITE).mix(1.0))?;
        for item in &drawing.items {
            match item {
                Item::Line { points, stroke } => {
                    dashes(points, stroke.dash).iter().try_for_each(|part| self.draw_line(part, stroke))?;
                }
                Item::Convex { corners, fill } => self.draw_polygon(corners, *fill)?,
                Item::Text(text) => self.draw_text(text)?,
                Item::Picture(picture) => self.draw_picture(picture)?,
            }
        }
        self.backend.present().map_err(fault)
    }

    /// Draws a filled rectangle, given in page pixels.
    fn draw_rectangle(&mut self, rect: Rect, fill: &impl Color) -> Result<(), FigureError> {
        let [first, _, last, _] = rect.corners().map(to_unit_point);
        self.backend.draw_rect(first, last, &fill.to_rgba(), true).map_err(fault)
    }

    /// Draws a filled convex polygon, given in page pixels.
    fn draw_polygon(&mut self, corners: &[Point], fill: Rgb) -> Result<(), FigureError> {
        self.backend.fill_polygon(corners.iter().copied().map(to_unit_point), &to_plotters(fill)).map_err(fault)
    }

    /// Draws a solid polyline with round corners and ends.
    fn draw_line(&mut self, points: &[Point], stroke: &Stroke) -> Result<(), FigureError> {
        let width = to_units(stroke.width) as u32;
        let places: Vec<_> = points.iter().copied().map(to_unit_point).collect();
        let colour = to_plotters(stroke.colour);
        // Filled shapes of the bitmap include both borders, and lines have butt ends.
        let style = colour.stroke_width(width - 1);
        for pair in places.windows(2) {
            self.backend.draw_path([pair[0], pair[1]], &style).map_err(fault)?;
        }
        places.into_iter().try_for_each(|p| self.backend.draw_circle(p, (width - 1) / 2, &colour, true)).map_err(fault)
    }

    /// Draws a text letter by letter, on a translucent white background if it has a halo.
    fn draw_text(&mut self, text: &Text) -> Result<(), FigureError> {
        if text.halo {
            self.draw_rectangle(text.bounds(), &to_plotters(WHITE).mix(BACKING))?;
        }
        let ink = to_plotters(text.colour);
        let turn = if text.upward { FontTransform::Rotate270 } else { FontTransform::None };
        let place = |x: f64, y: f64| {
            let (dx, dy) = turn.transform(x.round() as i32, y.round() as i32);
            let (x, y) = to_unit_point(text.at);
            (x + dx, y + dy)
        };
        let em = SCALE * text.size;
        let height = text::even_height(em);
        let font = text::font(height, text.weight).transform(turn.clone());
        let style = TextStyle::from(font).color(&ink).pos(Pos::new(HPos::Left, VPos::Top));
        let start = SCALE * text.start();
        for Letter { letter, ink, .. } in text::layout(&text.content, em, text.weight).0 {
            let at = place(start + ink, -height / 2.0);
            self.backend.draw_text(letter.encode_utf8(&mut [0; 4]), &style, at).map_err(fault)?;
        }
        Ok(())
    }

    /// Draws the coloured cells of a picture, then its hatching.
    fn draw_picture(&mut self, picture: &Picture) -> Result<(), FigureError> {
        let [right, down] = picture.lengths().map(|length| SEAM / length);
        for ([u0, u1], [v0, v1], fill) in picture.cells() {
            let Some(fill) = fill else { continue };
            let (u1, v1) = ((u1 + right).min(1.0), (v1 + down).min(1.0));
            let corners = [[u0, v0], [u1, v0], [u1, v1], [u0, v1]];
            self.draw_polygon(&corners.map(|at| picture.page_point(at)), on_paper(fill))?;
        }
        picture.hatching().iter().try_for_each(|line| self.draw_line(line, &HATCHING))
    }
}

/// Returns the opaque colour that a translucent one shows over white paper.
fn on_paper([r, g, b, opacity]: [u8; 4]) -> Rgb {
    let share = f64::from(opacity) / 255.0;
    [r, g, b].map(|part| (share * f64::from(part) + (1.0 - share) * 255.0).round() as u8)
}

/// Returns the parts of a polyline that a dash `pattern` draws; the whole line if it is empty. Plotters (0.3.7) has one dash only.
pub fn dashes(points: &[Point], pattern: &[f64]) -> Vec<Vec<Point>> {
    if pattern.is_empty() {
        return vec![points.to_vec()];
    }
    let mut out: Vec<Vec<Point>> = vec![points.first().copied().into_iter().collect()];
    let (mut part, mut remaining) = (0, pattern[0]);
    for pair in points.windows(2) {
        let [[x0, y0], [x1, y1]] = [pair[0], pair[1]];
        let length = libm::hypot(x1 - x0, y1 - y0);
        let mut done = 0.0;
        while done < length {
            let step = remaining.min(length - done);
            done += step;
            remaining -= step;
            let at = [x0 + (x1 - x0) * done / length, y0 + (y1 - y0) * done / length];
            if part % 2 == 0 {
                out.last_mut().expect("there is a first part").push(at);
            }
            if remaining <= 0.0 {
                part = (part + 1) % pattern.len();
                remaining = pattern[part];
                if part % 2 == 0 {
                    out.push(vec![at]);
                }
            }
        }
    }
    out.retain(|part| part.len() > 1);
    out
}
