//! Placement of labels beside what they name without overlaps, and labelled rings over colour maps.

use super::drawing::{Anchor, Drawing, Point, Rect, Stroke, Text};
use super::style::{INK, WHITE};
use super::text::{self, Weight};

/// Directions from the named point in which a label may stand, the preferred first.
const DIRECTIONS: [Point; 16] = [
    [1.0, -0.6],
    [1.0, 0.6],
    [-1.0, -0.6],
    [-1.0, 0.6],
    [1.0, 0.0],
    [-1.0, 0.0],
    [0.0, -1.0],
    [0.0, 1.0],
    [0.5, -1.0],
    [0.5, 1.0],
    [-0.5, -1.0],
    [-0.5, 1.0],
    [1.0, -0.3],
    [1.0, 0.3],
    [-1.0, -0.3],
    [-1.0, 0.3],
];
/// Distances from the named point that are tried, in heights of the label.
const DISTANCES: [f64; 12] = [0.0, 0.4, 0.9, 1.5, 2.2, 3.0, 4.0, 5.2, 6.6, 8.2, 10.0, 12.0];
/// Distance in heights of the label beyond which a line leads from the point to its label.
const NEAR: f64 = 1.0;
/// Cost of a pixel of distance relative to a square pixel of covered lines.
const DISTANCE_COST: f64 = 30.0;

/// Where a label was placed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spot {
    /// Area the label covers.
    pub rect: Rect,
    /// Line from the named point to the label, if the label stands too far off without one.
    pub leader: Option<[Point; 2]>,
}

/// Areas of the page that labels should not cover.
#[derive(Debug, Clone, Default)]
pub struct Occupied {
    /// Labels and marks, which a label covers only if there is no other room.
    pub marks: Vec<Rect>,
    /// Pieces of lines, which a label avoids if it can.
    pub lines: Vec<Rect>,
}

impl Occupied {
    /// Adds a line as a row of small squares.
    pub(crate) fn add_line(&mut self, points: &[Point], width: f64) {
        for pair in points.windows(2) {
            let [dx, dy] = [pair[1][0] - pair[0][0], pair[1][1] - pair[0][1]];
            let steps = ((dx * dx + dy * dy).sqrt() / (2.0 * width.max(4.0))).ceil().clamp(1.0, 400.0);
            let at = |k: f64| [pair[0][0] + dx * k / steps, pair[0][1] + dy * k / steps];
            self.lines.extend((0..=steps as usize).map(|k| rect_around(at(k as f64), [width.max(4.0); 2])));
        }
    }

    /// Places a label of half-width and half-height `half` for a mark of radius `reach` at the point `at`: at the nearest spot in
    /// `bounds` that covers no mark and few lines. The spot is occupied from then on.
    pub fn place_label(&mut self, at: Point, reach: f64, half: [f64; 2], bounds: Rect) -> Spot {
        let height = 2.0 * half[1];
        let candidates = DISTANCES.iter().flat_map(|distance| DIRECTIONS.map(|direction| (*distance, direction)));
        let spot = |(distance, [dx, dy]): (f64, Point)| {
            let gap = reach + 4.0 + distance * height;
            let centre = [at[0] + dx * (half[0] + gap), at[1] + dy * (half[1] + gap)];
            (distance, rect_around(centre, half))
        };
        let cost = |&(distance, rect): &(f64, Rect)| {
            let outside = half[0] * half[1] * 4.0 - rect.overlap(&bounds);
            let covered: f64 = self.marks.iter().map(|other| rect.overlap(other)).sum();
            let lines: f64 = self.lines.iter().map(|other| rect.overlap(other)).sum();
            1e4 * outside.max(0.0) + 1e4 * covered + 3.0 * lines + DISTANCE_COST * distance * height
        };
        let mut best = spot((0.0, DIRECTIONS[0]));
        let mut least = cost(&best);
        for candidate in candidates.map(spot) {
            let cost = cost(&candidate);
            if cost < least - 1e-6 {
                (best, least) = (candidate, cost);
            }
        }
        let (distance, rect) = best;
        self.marks.push(rect);
        let nearest = [at[0].clamp(rect.x, rect.right()), at[1].clamp(rect.y, rect.bottom())];
        Spot { rect, leader: (distance > NEAR).then_some([at, nearest]) }
    }
}

/// Returns the rectangle with half-width and half-height `half` around `centre`.
pub fn rect_around(centre: Point, half: [f64; 2]) -> Rect {
    Rect { x: centre[0] - half[0], y: centre[1] - half[1], width: 2.0 * half[0], height: 2.0 * half[1] }
}

/// A labelled point on the page.
pub(super) struct PlacedMark<'a> {
    pub at: Point,
    pub label: &'a str,
    /// Whether it lies behind what is drawn, and so gets a dashed ring.
    pub hidden: bool,
}

const RING: Stroke = Stroke { colour: INK, width: 4.0, dash: &[] };
const HIDDEN_RING: Stroke = Stroke { colour: INK, width: 4.0, dash: &[4.0, 8.0] };
const LEADER: Stroke = Stroke { colour: INK, width: 2.0, dash: &[] };
const RIM: Stroke = Stroke { colour: WHITE, width: 9.0, dash: &[] };

/// Returns the radius in pixels of the ring around a mark whose label has type size `size`.
fn ring_radius(size: f64) -> f64 {
    0.3 * size
}

/// Draws a ring at each mark, and labels where they cover no other mark and, if possible, neither `lines` nor the border of `bounds`.
pub(super) fn draw_marks(
    drawing: &mut Drawing,
    marks: &[PlacedMark<'_>],
    lines: &[[Point; 2]],
    bounds: Rect,
    size: f64,
) {
    let radius = ring_radius(size);
    for mark in marks {
        drawing.circle(mark.at, radius, RIM);
        drawing.circle(mark.at, radius, if mark.hidden { HIDDEN_RING } else { RING });
    }
    let reach = radius + 2.0;
    let rings = marks.iter().map(|mark| rect_around(mark.at, [reach; 2])).collect();
    let mut occupied = Occupied { marks: rings, ..Occupied::default() };
    lines.iter().for_each(|line| occupied.add_line(line, RIM.width));
    for mark in marks.iter().filter(|mark| !mark.label.is_empty()) {
        draw_label(drawing, &mut occupied, mark, bounds, size);
    }
}

/// Places and draws the label of a mark, with a line to it if it stands far off.
fn draw_label(drawing: &mut Drawing, occupied: &mut Occupied, mark: &PlacedMark<'_>, bounds: Rect, size: f64) {
    let half = [text::width(mark.label, size, Weight::Bold) / 2.0 + 4.0, text::capital_height(size) / 2.0 + 5.0];
    let Spot { rect, leader } = occupied.place_label(mark.at, ring_radius(size), half, bounds);
    if let Some(leader) = leader {
        drawing.line(leader.to_vec(), LEADER);
    }
    let at = [rect.centre()[0], rect.centre()[1] + text::capital_height(size) / 2.0];
    drawing.text(Text::new(mark.label, size, at, Anchor::Middle).bold().with_halo());
}
