//! A figure as laid out: lines, polygons, texts and pictures on a page, before it is written in any format.

use super::field::Picture;
use super::text::{self, Weight};

/// Sides of the polygon that approximates a circle.
const CIRCLE_CORNERS: usize = 48;

/// A point on the page in pixels, x to the right, y downward.
pub type Point = [f64; 2];
/// A colour, 8 bits per channel.
pub type Rgb = [u8; 3];

/// An upright rectangle on the page, in pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rect {
    /// Left side.
    pub x: f64,
    /// Upper side.
    pub y: f64,
    /// Extent from left to right.
    pub width: f64,
    /// Extent from top to bottom.
    pub height: f64,
}

impl Rect {
    /// Returns the x of its right side.
    pub fn right(&self) -> f64 {
        self.x + self.width
    }

    /// Returns the y of its lower side.
    pub(crate) fn bottom(&self) -> f64 {
        self.y + self.height
    }

    /// Returns its centre.
    pub fn centre(&self) -> Point {
        [self.x + self.width / 2.0, self.y + self.height / 2.0]
    }

    /// Returns its corners in turn, the upper left one first.
    pub fn corners(&self) -> [Point; 4] {
        [[self.x, self.y], [self.right(), self.y], [self.right(), self.bottom()], [self.x, self.bottom()]]
    }

    /// Returns its upper left corner and the vectors of its two sides from there.
    pub fn frame(&self) -> [Point; 3] {
        [[self.x, self.y], [self.width, 0.0], [0.0, self.height]]
    }

    /// Returns the area shared with `other`, in square pixels.
    pub fn overlap(&self, other: &Self) -> f64 {
        let width = self.right().min(other.right()) - self.x.max(other.x);
        let height = self.bottom().min(other.bottom()) - self.y.max(other.y);
        width.max(0.0) * height.max(0.0)
    }
}

/// Colour, width and dash pattern of a line; ends and corners are round.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stroke {
    /// Its colour.
    pub colour: Rgb,
    /// Width in pixels.
    pub width: f64,
    /// Lengths of dashes and gaps in turn, in pixels; empty for a solid line.
    pub dash: &'static [f64],
}

/// Which part of a text lies at its point on the page.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Anchor {
    /// Its beginning.
    Start,
    /// Its middle.
    Middle,
    /// Its end.
    End,
}

/// One line of text on the page.
#[derive(Debug, Clone, PartialEq)]
pub struct Text {
    /// Point on the baseline where the text is anchored.
    pub at: Point,
    /// Its words.
    pub content: String,
    /// Type size in pixels.
    pub size: f64,
    /// Whether letters are regular or bold.
    pub weight: Weight,
    /// Which part of the text lies at `at`.
    pub anchor: Anchor,
    /// Whether it reads from bottom to top.
    pub upward: bool,
    /// Colour of its letters.
    pub colour: Rgb,
    /// Whether it has a white background, for text over colours.
    pub halo: bool,
}

impl Text {
    /// Returns a text in ink colour, of regular weight, anchored at `at`.
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

    /// Returns the text in bold.
    pub(crate) fn bold(self) -> Self {
        Self { weight: Weight::Bold, ..self }
    }

    /// Returns the text reading from bottom to top.
    pub(crate) fn upward(self) -> Self {
        Self { upward: true, ..self }
    }

    /// Returns the text in this colour.
    pub(crate) fn coloured(self, colour: Rgb) -> Self {
        Self { colour, ..self }
    }

    /// Returns the text with a white background.
    pub(crate) fn with_halo(self) -> Self {
        Self { halo: true, ..self }
    }

    /// Returns where the text starts along its baseline, relative to `at`, in pixels.
    pub fn start(&self) -> f64 {
        let width = text::width(&self.content, self.size, self.weight);
        match self.anchor {
            Anchor::Start => 0.0,
            Anchor::Middle => -width / 2.0,
            Anchor::End => -width,
        }
    }

    /// Returns the rectangle around the capitals of a text that is not upward, with a small border.
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

/// One item drawn on the page.
#[derive(Debug, Clone, PartialEq)]
pub enum Item {
    /// A polyline.
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
    /// A grid of coloured cells.
    Picture(Picture),
}

/// Everything on the page of a figure, in drawing order.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Drawing {
    /// Title, which SVG documents carry.
    pub title: String,
    /// Width of the page in pixels.
    pub width: f64,
    /// Height of the page in pixels.
    pub height: f64,
    /// Items drawn, the lowest first.
    pub items: Vec<Item>,
}

impl Drawing {
    /// Returns the largest y of any item's points, in pixels: y points downward.
    pub(crate) fn lowest(&self) -> f64 {
        let largest_y = |points: &[Point]| points.iter().map(|p| p[1]).fold(0.0, f64::max);
        let of_item = |item: &Item| match item {
            Item::Line { points, .. } => largest_y(points),
            Item::Convex { corners, .. } => largest_y(corners),
            Item::Text(text) => text.at[1],
            Item::Picture(picture) => {
                largest_y(&[[0.0, 0.0], [0.0, 1.0], [1.0, 0.0], [1.0, 1.0]].map(|at| picture.page_point(at)))
            }
        };
        self.items.iter().map(of_item).fold(0.0, f64::max)
    }

    /// Adds a polyline through `points`, drawn with `stroke`.
    pub fn line(&mut self, points: Vec<Point>, stroke: Stroke) {
        self.items.push(Item::Line { points, stroke });
    }

    /// Adds the closed outline of a polygon.
    pub(crate) fn outline(&mut self, corners: &[Point], stroke: Stroke) {
        self.line(corners.iter().chain(corners.first()).copied().collect(), stroke);
    }

    /// Adds a circle.
    pub fn circle(&mut self, centre: Point, radius: f64, stroke: Stroke) {
        let angle = |k: usize| std::f64::consts::TAU * k as f64 / CIRCLE_CORNERS as f64;
        let corner = |k| [centre[0] + radius * libm::cos(angle(k)), centre[1] + radius * libm::sin(angle(k))];
        self.line((0..=CIRCLE_CORNERS).map(corner).collect(), stroke);
    }

    /// Adds a filled convex polygon.
    pub(crate) fn convex(&mut self, corners: Vec<Point>, fill: Rgb) {
        self.items.push(Item::Convex { corners, fill });
    }

    /// Adds a text.
    pub fn text(&mut self, text: Text) {
        self.items.push(Item::Text(text));
    }

    /// Adds a grid of coloured cells.
    pub(crate) fn picture(&mut self, picture: Picture) {
        self.items.push(Item::Picture(picture));
    }
}
