//! What a map of turns says: at each place, each direction of the tool at its best turn; over all directions, the worst of them.

use serde_json::{Value, json};

use super::quantities::{BEST, WORST_OVER_BEST};
use crate::{
    answer::{Quantity, ShareWithin},
    questions::turn_map::{TurnMap, TurnMapPoint, TurnMapStudy, Turns},
};

/// A map of turns with what is asked of it.
pub(super) struct Report<'a> {
    pub study: &'a TurnMapStudy,
    pub map: &'a TurnMap,
}

/// A place and what is found there.
#[derive(Clone, Copy)]
pub(super) struct Found<'a> {
    pub point: &'a TurnMapPoint,
    pub turns: &'a Turns,
}

impl<'a> Report<'a> {
    /// The point with this direction at a place of the grid.
    pub fn point(&self, axis: usize, place: usize) -> &'a TurnMapPoint {
        &self.map.points[axis * self.study.grid.len() + place]
    }

    /// All that is solved.
    fn found(&self) -> impl Iterator<Item = Found<'a>> {
        self.map.points.iter().filter_map(Found::at)
    }

    /// Of the best turns, the one at which the tool moves least.
    pub fn least(&self) -> Option<Found<'a>> {
        self.found().min_by(|a, b| a.best().total_cmp(&b.best()))
    }

    /// Of the best turns, the one at which the tool moves most.
    pub fn most(&self) -> Option<Found<'a>> {
        largest(&BEST, self.found())
    }

    /// Where the choice of the turn counts most.
    pub fn widest(&self) -> Option<Found<'a>> {
        largest(&WORST_OVER_BEST, self.found())
    }

    /// At a place, the direction whose best turn moves the tool most; `None` where some direction has none.
    pub fn all_axes(&self, place: usize) -> Option<Found<'a>> {
        let axes = 0..self.study.axes.len();
        let found = axes.map(|axis| Found::at(self.point(axis, place))).collect::<Option<Vec<Found<'a>>>>();
        largest(&BEST, found?)
    }

    /// Share of the places at which every direction has a turn within the tolerance.
    pub fn share_within(&self) -> Option<f64> {
        let tolerance = self.study.scene.tolerance_mm?;
        let mut share = ShareWithin::default();
        for place in 0..self.study.grid.len() {
            share.add(1.0, self.all_axes(place).is_some_and(|found| found.best() <= tolerance));
        }
        share.get()
    }

    /// Name of a direction.
    pub fn axis_name(&self, axis: usize) -> String {
        let [x, y, z] = self.axis(axis);
        format!("({x}, {y}, {z})")
    }

    /// A direction without the rounding of how it was computed.
    pub fn axis(&self, axis: usize) -> [f64; 3] {
        <[f64; 3]>::from(self.study.axes[axis]).map(|c| (c * 1e6).round() / 1e6 + 0.0)
    }

    /// The answer for programs.
    pub fn json(&self) -> Value {
        let found = |Found { point, turns }: Found<'_>| {
            let axis = self.axis(point.axis);
            json!({ "position_mm": point.position_mm, "tool_axis": axis, "best": turns.best, "worst": turns.worst })
        };
        json!({
            "schema": 1,
            "least": self.least().map(found),
            "most": self.most().map(found),
            "largest_gain": self.widest().map(found),
            "share_within_tolerance": self.share_within(),
        })
    }
}

/// Of what has a value of `quantity`, the last at which it is largest.
fn largest<'a>(quantity: &Quantity<Turns>, all: impl IntoIterator<Item = Found<'a>>) -> Option<Found<'a>> {
    let valued = all.into_iter().filter_map(|found| Some((quantity.value(found.turns)?, found)));
    valued.max_by(|(a, _), (b, _)| a.total_cmp(b)).map(|(_, found)| found)
}

impl<'a> Found<'a> {
    /// At `point`, if some turn is possible there.
    fn at(point: &'a TurnMapPoint) -> Option<Self> {
        Some(Found { point, turns: point.turns.as_ref().ok()? })
    }

    /// Deflection at the best turn, mm.
    pub fn best(&self) -> f64 {
        self.turns.best.deflection_mm
    }

    /// How many times as far the tool moves at the worst turn as at the best.
    pub fn gain(&self) -> f64 {
        self.turns.worst.deflection_mm / self.best()
    }
}
