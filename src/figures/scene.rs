//! What a figure consists of before it is written in any format.

use super::field::Picture;
use super::text::{self, Weight};

/// Sides of the polygon that stands for a circle.
const CIRCLE_CORNERS: usize = 48;

/// A place on the page in pixels, x to the right, y downward.
pub(super) type Point = [f64; 2];
/// A colour, 8 bits per channel.
pub(super) type Rgb = [u8; 3];

/// An upright rectangle on the page.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Rect {
    pub x: f64,
    pub y: f64,
    pub width: f64,
    pub height: f64,
}

impl Rect {
    pub fn right(&self) -> f64 {
        self.x + self.width
    }

    pub(crate) fn bottom(&self) -> f64 {
        self.y + self.height
    }

    pub fn centre(&self) -> Point {
        [self.x + self.width / 2.0, self.y + self.height / 2.0]
    }

    pub fn corners(&self) -> [Point; 4] {
        [[self.x, self.y], [self.right(), self.y], [self.right(), self.bottom()], [self.x, self.bottom()]]
    }

    /// The left upper corner and the two sides from there.
    pub fn frame(&self) -> [Point; 3] {
        [[self.x, self.y], [self.width, 0.0], [0.0, self.height]]
    }

    /// Area shared with `other`.
    pub(crate) fn overlap(&self, other: &Self) -> f64 {
        let width = self.right().min(other.right()) - self.x.max(other.x);
        let height = self.bottom().min(other.bottom()) - self.y.max(other.y);
        width.max(0.0) * height.max(0.0)
    }
}

/// How a line is drawn; ends and corners are round. An empty dash pattern is a solid line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Stroke {
    pub colour: Rgb,
    pub width: f64,
    pub dash: &'static [f64],
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Anchor {
    Start,
    Middle,
    End,
}

/// One line of text; `at` is on the baseline.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Text {
    pub at: Point,
    pub content: String,
    pub size: f64,
    pub weight: Weight,
    pub anchor: Anchor,
    /// Reads from bottom to top.
    pub upward: bool,
    pub colour: Rgb,
    /// White behind it, for text over colours.
    pub halo: bool,
}

impl Text {
    pub fn new(content: impl Into<String>, size: f64, at: Point, anchor: Anchor) -> Self {
        Self {
            at,
            content: text::printable(&content.into()),
            size,
            weight: Weight::Regular,
            anchor,
            upward: false,
            colour: super::style::INK,
            halo: false,
        }
    }

    pub(crate) fn bold(self) -> Self {
        Self { weight: Weight::Bold, ..self }
    }

    pub(crate) fn upward(self) -> Self {
        Self { upward: true, ..self }
    }

    pub(crate) fn coloured(self, colour: Rgb) -> Self {
        Self { colour, ..self }
    }

    pub(crate) fn with_halo(self) -> Self {
        Self { halo: true, ..self }
    }

    /// Where the text starts along its baseline, from `at`.
    pub fn start(&self) -> f64 {
        let width = text::width(&self.content, self.size, self.weight);
        match self.anchor {
            Anchor::Start => 0.0,
            Anchor::Middle => -width / 2.0,
            Anchor::End => -width,
        }
    }

    /// Around the capitals of a text that is not upward, with a small border.
    pub fn bounds(&self) -> Rect {
        let border = 0.12 * self.size;
        Rect {
            x: self.at[0] + self.start() - border,
            y: self.at[1] - text::capital_height(self.size) - border,
            width: text::width(&self.content, self.size, self.weight) + 2.0 * border,
            height: text::capital_height(self.size) + 2.0 * border,
        }
    }
}

#[derive(Debug, Clone, PartialEq)]
pub(super) enum Item {
    Line {
        points: Vec<Point>,
        stroke: Stroke,
    },
    /// A filled convex polygon.
    Convex {
        corners: Vec<Point>,
        fill: Rgb,
    },
    Text(Text),
    Picture(Picture),
}

/// Everything on a page, in drawing order.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Scene {
    pub title: String,
    pub width: f64,
    pub height: f64,
    pub items: Vec<Item>,
}

impl Scene {
    /// The lowest place any item is put at.
    pub(crate) fn lowest(&self) -> f64 {
        let low = |points: &[Point]| points.iter().map(|p| p[1]).fold(0.0, f64::max);
        let of_item = |item: &Item| match item {
            Item::Line { points, .. } => low(points),
            Item::Convex { corners, .. } => low(corners),
            Item::Text(text) => text.at[1],
            Item::Picture(picture) => {
                low(&[[0.0, 0.0], [0.0, 1.0], [1.0, 0.0], [1.0, 1.0]].map(|at| picture.place(at)))
            }
        };
        self.items.iter().map(of_item).fold(0.0, f64::max)
    }

    pub fn line(&mut self, points: Vec<Point>, stroke: Stroke) {
        self.items.push(Item::Line { points, stroke });
    }

    pub(crate) fn outline(&mut self, corners: &[Point], stroke: Stroke) {
        self.line(corners.iter().chain(corners.first()).copied().collect(), stroke);
    }

    pub fn circle(&mut self, centre: Point, radius: f64, stroke: Stroke) {
        let angle = |k: usize| std::f64::consts::TAU * k as f64 / CIRCLE_CORNERS as f64;
        let corner = |k| [centre[0] + radius * angle(k).cos(), centre[1] + radius * angle(k).sin()];
        self.line((0..=CIRCLE_CORNERS).map(corner).collect(), stroke);
    }

    pub(crate) fn convex(&mut self, corners: Vec<Point>, fill: Rgb) {
        self.items.push(Item::Convex { corners, fill });
    }

    pub fn text(&mut self, text: Text) {
        self.items.push(Item::Text(text));
    }

    pub(crate) fn picture(&mut self, picture: Picture) {
        self.items.push(Item::Picture(picture));
    }
}
