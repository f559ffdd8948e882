//! A scene as a PNG file.
//!
//! Every shape is drawn by how far a pixel's centre lies inside it: half a pixel inside covers the pixel, half a pixel
//! outside does not. Edges come out smooth at any place and angle, which plotters' own shapes, whose corners are whole
//! pixels, do not; its bitmap blends the pixels.

use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ColorType, ImageEncoder};
use plotters::backend::{BitMapBackend, DrawingBackend};
use plotters::style::{Color, RGBColor};

use super::error::FigureError;
use super::scene::{Anchor, Item, Picture, Point, Rgb, Scene, Stroke, Text};
use super::style::WHITE;
use super::text;

/// Corners of the polygon that stands for a circle.
const CIRCLE_CORNERS: usize = 48;

pub(super) fn file(scene: &Scene) -> Result<Vec<u8>, FigureError> {
    let (width, height) = (scene.width.round() as usize, scene.height.round() as usize);
    let mut bytes = vec![255; 3 * width * height];
    {
        let backend = BitMapBackend::with_buffer(&mut bytes, (width as u32, height as u32));
        let mut canvas = Canvas { backend, width: width as i32, height: height as i32 };
        for item in &scene.items {
            canvas.draw(item)?;
        }
    }
    encode(width, height, &bytes)
}

/// RGB bytes, row by row, as a PNG file.
pub(super) fn encode(width: usize, height: usize, bytes: &[u8]) -> Result<Vec<u8>, FigureError> {
    let mut out = Vec::new();
    PngEncoder::new_with_quality(&mut out, CompressionType::Best, FilterType::Adaptive)
        .write_image(bytes, width as u32, height as u32, ColorType::Rgb8)
        .map_err(|e| FigureError::Encode { reason: e.to_string() })?;
    Ok(out)
}

/// Width of the white rim around text of a size.
pub(super) fn halo_radius(size: f64) -> f64 {
    0.11 * size
}

struct Canvas<'a> {
    backend: BitMapBackend<'a>,
    width: i32,
    height: i32,
}

impl Canvas<'_> {
    fn draw(&mut self, item: &Item) -> Result<(), FigureError> {
        match item {
            Item::Line { points, closed, stroke } => self.line(points, *closed, stroke),
            Item::Circle { centre, radius, stroke } => self.line(&circle(*centre, *radius), true, stroke),
            Item::Convex { corners, fill } => self.convex(corners, |_| *fill),
            Item::Text(text) => self.text(text),
            Item::Picture(picture) => self.picture(picture),
        }
    }

    fn blend(&mut self, x: i32, y: i32, colour: Rgb, coverage: f64) -> Result<(), FigureError> {
        if coverage <= 0.0 || x < 0 || y < 0 || x >= self.width || y >= self.height {
            return Ok(());
        }
        let [r, g, b] = colour;
        let colour = RGBColor(r, g, b).mix(coverage.min(1.0)).to_backend_color();
        self.backend.draw_pixel((x, y), colour).map_err(|e| FigureError::Encode { reason: e.to_string() })
    }

    fn line(&mut self, points: &[Point], closed: bool, stroke: &Stroke) -> Result<(), FigureError> {
        let mut points = points.to_vec();
        if closed {
            points.extend(points.first().copied());
        }
        let segments = dashes(&points, stroke.dash);
        let reach = stroke.width / 2.0;
        let ends: Vec<Point> = segments.iter().flatten().copied().collect();
        let window = self.window(&ends, reach);
        let mut mask = vec![0.0_f64; window.area()];
        for segment in &segments {
            let part = self.window(segment, reach);
            for (x, y) in part.pixels() {
                let coverage = reach + 0.5 - distance([f64::from(x) + 0.5, f64::from(y) + 0.5], segment);
                let cell = &mut mask[window.index(x, y)];
                *cell = cell.max(coverage.min(2.0 * reach));
            }
        }
        for ((x, y), coverage) in window.pixels().zip(mask) {
            self.blend(x, y, stroke.colour, coverage)?;
        }
        Ok(())
    }

    /// Fills a convex polygon; `colour` is asked for each pixel centre.
    fn convex(&mut self, corners: &[Point], colour: impl Fn(Point) -> Rgb) -> Result<(), FigureError> {
        let edges: Vec<[Point; 2]> =
            corners.iter().copied().zip(corners.iter().copied().cycle().skip(1)).map(|(a, b)| [a, b]).collect();
        let turn = edges.iter().map(|[a, b]| a[0] * b[1] - a[1] * b[0]).sum::<f64>().signum();
        for (x, y) in self.window(corners, 0.0).pixels() {
            let centre = [f64::from(x) + 0.5, f64::from(y) + 0.5];
            let inside = edges.iter().map(|edge| turn * left_of(centre, edge)).fold(f64::INFINITY, f64::min);
            self.blend(x, y, colour(centre), inside + 0.5)?;
        }
        Ok(())
    }

    fn picture(&mut self, picture: &Picture) -> Result<(), FigureError> {
        let Picture { origin: [x, y], across, down, .. } = *picture;
        let corners = [
            [x, y],
            [x + across[0], y + across[1]],
            [x + across[0] + down[0], y + across[1] + down[1]],
            [x + down[0], y + down[1]],
        ];
        let area = across[0] * down[1] - across[1] * down[0];
        let sample = |at: Point| {
            let from = [at[0] - x, at[1] - y];
            let u = (from[0] * down[1] - from[1] * down[0]) / area;
            let v = (across[0] * from[1] - across[1] * from[0]) / area;
            let pick = |fraction: f64, count: usize| ((fraction * count as f64).max(0.0) as usize).min(count - 1);
            picture.pixels[pick(v, picture.rows) * picture.columns + pick(u, picture.columns)]
        };
        self.convex(&corners, |[x, y]| {
            let quarters = [[-0.25, -0.25], [0.25, -0.25], [-0.25, 0.25], [0.25, 0.25]];
            let samples = quarters.map(|[dx, dy]| sample([x + dx, y + dy]));
            let mean = |channel: usize| samples.iter().map(|s| u32::from(s[channel])).sum::<u32>() / 4;
            [mean(0) as u8, mean(1) as u8, mean(2) as u8]
        })
    }

    fn text(&mut self, text: &Text) -> Result<(), FigureError> {
        if text.halo {
            let radius = halo_radius(text.size);
            for [x, y] in circle([0.0, 0.0], radius) {
                self.stamp(text, [text.at[0] + x, text.at[1] + y], WHITE)?;
            }
        }
        self.stamp(text, text.at, text.colour)
    }

    fn stamp(&mut self, text: &Text, at: Point, colour: Rgb) -> Result<(), FigureError> {
        let width = text::width(&text.content, text.size, text.weight);
        let back = match text.anchor {
            Anchor::Start => 0.0,
            Anchor::Middle => width / 2.0,
            Anchor::End => width,
        };
        let mut covered = Vec::new();
        text::cover(&text.content, text.size, text.weight, |x, y, c| covered.push((x, y, f64::from(c))));
        let [ox, oy] = if text.upward { [at[0], at[1] + back] } else { [at[0] - back, at[1]] };
        let (ox, oy) = (ox.round() as i32, oy.round() as i32);
        for (x, y, coverage) in covered {
            let (px, py) = if text.upward { (ox + y, oy - x - 1) } else { (ox + x, oy + y) };
            self.blend(px, py, colour, coverage)?;
        }
        Ok(())
    }

    /// The pixels within `reach` of the points.
    fn window(&self, points: &[Point], reach: f64) -> Window {
        let span = |axis: usize, most: i32| {
            let low = points.iter().map(|p| p[axis]).fold(f64::INFINITY, f64::min) - reach - 1.0;
            let high = points.iter().map(|p| p[axis]).fold(f64::NEG_INFINITY, f64::max) + reach + 1.0;
            ((low.floor() as i32).clamp(0, most), (high.ceil() as i32).clamp(0, most))
        };
        let ((x0, x1), (y0, y1)) = (span(0, self.width), span(1, self.height));
        Window { x0, x1: x1.max(x0), y0, y1: y1.max(y0) }
    }
}

/// Pixels x0..x1 by y0..y1.
struct Window {
    x0: i32,
    x1: i32,
    y0: i32,
    y1: i32,
}

impl Window {
    fn area(&self) -> usize {
        ((self.x1 - self.x0) * (self.y1 - self.y0)) as usize
    }

    fn index(&self, x: i32, y: i32) -> usize {
        ((y - self.y0) * (self.x1 - self.x0) + x - self.x0) as usize
    }

    fn pixels(&self) -> impl Iterator<Item = (i32, i32)> + use<> {
        let (x0, x1) = (self.x0, self.x1);
        (self.y0..self.y1).flat_map(move |y| (x0..x1).map(move |x| (x, y)))
    }
}

fn circle(centre: Point, radius: f64) -> Vec<Point> {
    let angle = |k: usize| std::f64::consts::TAU * k as f64 / CIRCLE_CORNERS as f64;
    (0..CIRCLE_CORNERS).map(|k| [centre[0] + radius * angle(k).cos(), centre[1] + radius * angle(k).sin()]).collect()
}

/// Signed distance of `point` from the line through `edge`.
fn left_of(point: Point, [a, b]: &[Point; 2]) -> f64 {
    let along = [b[0] - a[0], b[1] - a[1]];
    let length = along[0].hypot(along[1]);
    if length == 0.0 {
        return f64::INFINITY;
    }
    (along[0] * (point[1] - a[1]) - along[1] * (point[0] - a[0])) / length
}

/// Distance of `point` from the segment.
fn distance(point: Point, [a, b]: &[Point; 2]) -> f64 {
    let along = [b[0] - a[0], b[1] - a[1]];
    let from = [point[0] - a[0], point[1] - a[1]];
    let square = along[0] * along[0] + along[1] * along[1];
    let share = if square > 0.0 { ((from[0] * along[0] + from[1] * along[1]) / square).clamp(0.0, 1.0) } else { 0.0 };
    (from[0] - share * along[0]).hypot(from[1] - share * along[1])
}

/// The segments of a polyline that a dash pattern leaves; all of them if the pattern is empty.
fn dashes(points: &[Point], pattern: &[f64]) -> Vec<[Point; 2]> {
    let segments = points.windows(2).map(|pair| [pair[0], pair[1]]);
    if pattern.is_empty() {
        return segments.collect();
    }
    let mut out = Vec::new();
    let (mut part, mut left) = (0, pattern[0]);
    for [a, b] in segments {
        let length = (b[0] - a[0]).hypot(b[1] - a[1]);
        let at = |s: f64| [a[0] + (b[0] - a[0]) * s / length, a[1] + (b[1] - a[1]) * s / length];
        let mut done = 0.0;
        while done < length {
            let step = left.min(length - done);
            if part % 2 == 0 {
                out.push([at(done), at(done + step)]);
            }
            done += step;
            left -= step;
            if left <= 0.0 {
                part = (part + 1) % pattern.len();
                left = pattern[part];
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dashes_leave_the_gaps_out() {
        let parts = dashes(&[[0.0, 0.0], [10.0, 0.0]], &[3.0, 2.0]);
        assert_eq!(parts, [[[0.0, 0.0], [3.0, 0.0]], [[5.0, 0.0], [8.0, 0.0]]]);
    }

    #[test]
    fn distance_is_to_the_nearest_point_of_the_segment() {
        assert_eq!(distance([3.0, 4.0], &[[0.0, 0.0], [0.0, 0.0]]), 5.0);
        assert_eq!(distance([5.0, 2.0], &[[0.0, 0.0], [10.0, 0.0]]), 2.0);
        assert_eq!(distance([13.0, 4.0], &[[0.0, 0.0], [10.0, 0.0]]), 5.0);
    }
}
