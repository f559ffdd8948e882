//! What a figure consists of before it is written in any format.

use super::field::Picture;
use super::text::{self, Weight};

/// Sides of the polygon that stands for a circle.
const CIRCLE_CORNERS: usize = 48;

/// A place on the page in pixels, x to the right, y downward.
pub type Point = [f64; 2];
/// A colour, 8 bits per channel.
pub type Rgb = [u8; 3];

/// An upright rectangle on the page.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rect {
    /// Its left side.
    pub x: f64,
    /// Its upper side.
    pub y: f64,
    /// From left to right.
    pub width: f64,
    /// From top to bottom.
    pub height: f64,
}

impl Rect {
    /// Its right side.
    pub fn right(&self) -> f64 {
        self.x + self.width
    }

    pub(crate) fn bottom(&self) -> f64 {
        self.y + self.height
    }

    /// Its middle.
    pub fn centre(&self) -> Point {
        [self.x + self.width / 2.0, self.y + self.height / 2.0]
    }

    /// Its corners in turn, the left upper one first.
    pub fn corners(&self) -> [Point; 4] {
        [[self.x, self.y], [self.right(), self.y], [self.right(), self.bottom()], [self.x, self.bottom()]]
    }

    /// The left upper corner and the two sides from there.
    pub fn frame(&self) -> [Point; 3] {
        [[self.x, self.y], [self.width, 0.0], [0.0, self.height]]
    }

    /// Area shared with `other`.
    pub fn overlap(&self, other: &Self) -> f64 {
        let width = self.right().min(other.right()) - self.x.max(other.x);
        let height = self.bottom().min(other.bottom()) - self.y.max(other.y);
        width.max(0.0) * height.max(0.0)
    }
}

/// How a line is drawn; ends and corners are round. An empty dash pattern is a solid line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stroke {
    /// Its colour.
    pub colour: Rgb,
    /// In pixels.
    pub width: f64,
    /// Lengths of dashes and gaps in turn, in pixels.
    pub dash: &'static [f64],
}

/// Which part of a text stands at its place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Anchor {
    /// Its begin.
    Start,
    /// Its middle.
    Middle,
    /// Its end.
    End,
}

/// One line of text; `at` is on the baseline.
#[derive(Debug, Clone, PartialEq)]
pub struct Text {
    /// Its place.
    pub at: Point,
    /// Its words.
    pub content: String,
    /// Type size in pixels.
    pub size: f64,
    /// How strong its letters are.
    pub weight: Weight,
    /// Which part of it is at its place.
    pub anchor: Anchor,
    /// Reads from bottom to top.
    pub upward: bool,
    /// Of its letters.
    pub colour: Rgb,
    /// White behind it, for text over colours.
    pub halo: bool,
}

impl Text {
    /// A text in ink, of regular weight.
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

/// What is drawn.
#[derive(Debug, Clone, PartialEq)]
pub enum Item {
    /// A line through points.
    Line {
        /// The points.
        points: Vec<Point>,
        /// How it is drawn.
        stroke: Stroke,
    },
    /// A filled convex polygon.
    Convex {
        /// Its corners in turn.
        corners: Vec<Point>,
        /// Its colour.
        fill: Rgb,
    },
    /// A line of text.
    Text(Text),
    /// Coloured cells.
    Picture(Picture),
}

/// Everything on a page, in drawing order.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Scene {
    /// Its title, which documents carry.
    pub title: String,
    /// In pixels.
    pub width: f64,
    /// In pixels.
    pub height: f64,
    /// What is drawn, the lowest first.
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

    /// Adds a line.
    pub fn line(&mut self, points: Vec<Point>, stroke: Stroke) {
        self.items.push(Item::Line { points, stroke });
    }

    pub(crate) fn outline(&mut self, corners: &[Point], stroke: Stroke) {
        self.line(corners.iter().chain(corners.first()).copied().collect(), stroke);
    }

    /// Adds a circle.
    pub fn circle(&mut self, centre: Point, radius: f64, stroke: Stroke) {
        let angle = |k: usize| std::f64::consts::TAU * k as f64 / CIRCLE_CORNERS as f64;
        let corner = |k| [centre[0] + radius * angle(k).cos(), centre[1] + radius * angle(k).sin()];
        self.line((0..=CIRCLE_CORNERS).map(corner).collect(), stroke);
    }

    pub(crate) fn convex(&mut self, corners: Vec<Point>, fill: Rgb) {
        self.items.push(Item::Convex { corners, fill });
    }

    /// Adds a text.
    pub fn text(&mut self, text: Text) {
        self.items.push(Item::Text(text));
    }

    pub(crate) fn picture(&mut self, picture: Picture) {
        self.items.push(Item::Picture(picture));
    }
}
