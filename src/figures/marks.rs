//! Labelled rings over coloured fields.

use super::labels::{Occupied, Spot, around};
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
const LEADER: Stroke = Stroke { colour: INK, width: 2.0, dash: &[] };
const RIM: Stroke = Stroke { colour: WHITE, width: 9.0, dash: &[] };

fn radius(size: f64) -> f64 {
    0.3 * size
}

/// Draws each ring, and its label where it covers neither another mark nor, if possible, the border of `bounds`.
pub(super) fn draw(scene: &mut Scene, marks: &[PlacedMark<'_>], bounds: Rect, size: f64) {
    let radius = radius(size);
    for mark in marks {
        scene.circle(mark.at, radius, RIM);
        scene.circle(mark.at, radius, if mark.hidden { HIDDEN_RING } else { RING });
    }
    let reach = radius + 2.0;
    let rings = marks.iter().map(|mark| around(mark.at, [reach; 2])).collect();
    let mut occupied = Occupied { marks: rings, ..Occupied::default() };
    for mark in marks.iter().filter(|mark| !mark.label.is_empty()) {
        draw_label(scene, &mut occupied, mark, bounds, size);
    }
}

/// Writes the label of a mark beside it.
fn draw_label(scene: &mut Scene, occupied: &mut Occupied, mark: &PlacedMark<'_>, bounds: Rect, size: f64) {
    let half = [text::width(mark.label, size, Weight::Bold) / 2.0 + 4.0, text::capital_height(size) / 2.0 + 5.0];
    let Spot { rect, leader } = occupied.place(mark.at, radius(size), half, bounds);
    if let Some(leader) = leader {
        scene.line(leader.to_vec(), LEADER);
    }
    let at = [rect.centre()[0], rect.centre()[1] + text::capital_height(size) / 2.0];
    scene.text(Text::new(mark.label, size, at, Anchor::Middle).bold().with_halo());
}
