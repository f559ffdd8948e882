//! Labelled rings over coloured fields.

use super::scene::{Anchor, Point, Rect, Scene, Stroke, Text};
use super::style::{INK, WHITE};
use super::text::{self, Weight};

/// A mark at its place on the page.
pub(super) struct PlacedMark<'a> {
    pub at: Point,
    pub label: &'a str,
    /// Drawn with a dashed ring.
    pub hidden: bool,
}

const RING: Stroke = Stroke { colour: INK, width: 4.0, dash: &[] };
const HIDDEN_RING: Stroke = Stroke { colour: INK, width: 4.0, dash: &[4.0, 8.0] };
const RIM: Stroke = Stroke { colour: WHITE, width: 9.0, dash: &[] };

fn radius(size: f64) -> f64 {
    0.36 * size
}

/// Draws each ring, and its label where it covers neither another mark nor, if possible, the border of `bounds`.
pub(super) fn draw(scene: &mut Scene, marks: &[PlacedMark<'_>], bounds: Rect, size: f64) {
    let radius = radius(size);
    for mark in marks {
        scene.circle(mark.at, radius, RIM);
        scene.circle(mark.at, radius, if mark.hidden { HIDDEN_RING } else { RING });
    }
    let reach = radius + 2.0;
    let mut taken: Vec<Rect> = marks.iter().map(|mark| around(mark.at, reach, reach)).collect();
    for mark in marks.iter().filter(|mark| !mark.label.is_empty()) {
        let spot = label_spot(mark, bounds, &taken, size);
        taken.push(spot);
        let at = [spot.centre()[0], spot.centre()[1] + text::capital_height(size) / 2.0];
        scene.text(Text::new(mark.label, size, at, Anchor::Middle).bold().with_halo());
    }
}

/// The first of eight places around the mark that is free and inside, or else the least bad.
fn label_spot(mark: &PlacedMark<'_>, bounds: Rect, taken: &[Rect], size: f64) -> Rect {
    let half_width = text::width(mark.label, size, Weight::Bold) / 2.0 + 4.0;
    let half_height = text::capital_height(size) / 2.0 + 5.0;
    let beside = radius(size) + 6.0 + half_width;
    let above = radius(size) + 6.0 + half_height;
    let corner = (beside - 3.0, above - 0.6 * radius(size));
    let offsets = [
        (corner.0, -corner.1),
        (corner.0, corner.1),
        (-corner.0, -corner.1),
        (-corner.0, corner.1),
        (beside, 0.0),
        (-beside, 0.0),
        (0.0, -above),
        (0.0, above),
    ];
    let spots = offsets.map(|(x, y)| around([mark.at[0] + x, mark.at[1] + y], half_width, half_height));
    let cost = |spot: &Rect| {
        let outside = spot.width * spot.height - spot.overlap(&bounds);
        outside + 3.0 * taken.iter().map(|other| spot.overlap(other)).sum::<f64>()
    };
    let mut best = spots[0];
    for spot in &spots[1..] {
        if cost(spot) < cost(&best) - 1e-6 {
            best = *spot;
        }
    }
    best
}

fn around(centre: Point, half_width: f64, half_height: f64) -> Rect {
    Rect { x: centre[0] - half_width, y: centre[1] - half_height, width: 2.0 * half_width, height: 2.0 * half_height }
}
