//! What a map of turns says: at each place, each direction of the tool at its best turn; over all directions, the worst of them.

use serde_json::{Value, json};

use crate::questions::turn_map::{AtTurn, TurnMap, TurnMapPoint, TurnMapStudy};

/// A map of turns with what is asked of it.
pub(super) struct Report<'a> {
    pub study: &'a TurnMapStudy,
    pub map: &'a TurnMap,
}

/// A place and what is found there.
#[derive(Clone, Copy)]
pub(super) struct Found<'a> {
    pub point: &'a TurnMapPoint,
    pub best: AtTurn,
    pub worst: AtTurn,
}

impl<'a> Report<'a> {
    /// The point with this direction at a place of the grid.
    pub fn point(&self, axis: usize, place: usize) -> &'a TurnMapPoint {
        &self.map.points[axis * self.study.grid.len() + place]
    }

    /// All that is solved.
    pub fn found(&self) -> impl Iterator<Item = Found<'a>> {
        self.map.points.iter().filter_map(Found::at)
    }

    /// Of the best turns, the one at which the tool moves least.
    pub fn least(&self) -> Option<Found<'a>> {
        self.found().min_by(|a, b| a.best.deflection_mm.total_cmp(&b.best.deflection_mm))
    }

    /// Of the best turns, the one at which the tool moves most.
    pub fn most(&self) -> Option<Found<'a>> {
        self.found().max_by(|a, b| a.best.deflection_mm.total_cmp(&b.best.deflection_mm))
    }

    /// Where the choice of the turn counts most.
    pub fn widest(&self) -> Option<Found<'a>> {
        self.found().filter(|found| found.best.deflection_mm > 0.0).max_by(|a, b| a.gain().total_cmp(&b.gain()))
    }

    /// At a place, the direction whose best turn moves the tool most; `None` where some direction has none.
    pub fn all_axes(&self, place: usize) -> Option<Found<'a>> {
        let found: Option<Vec<Found<'a>>> =
            (0..self.study.axes.len()).map(|axis| Found::at(self.point(axis, place))).collect();
        found?.into_iter().max_by(|a, b| a.best.deflection_mm.total_cmp(&b.best.deflection_mm))
    }

    /// Share of the places at which every direction has a turn within the tolerance.
    pub fn share_within(&self) -> Option<f64> {
        let tolerance = self.study.scene.tolerance_mm?;
        let places = self.study.grid.len();
        let within = |place: &usize| self.all_axes(*place).is_some_and(|found| found.best.deflection_mm <= tolerance);
        Some((0..places).filter(within).count() as f64 / places as f64)
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
        let found = |found: Option<Found<'_>>| {
            found.map(|found| {
                json!({
                    "position_mm": found.point.position_mm,
                    "tool_axis": self.axis(found.point.axis),
                    "best": found.best,
                    "worst": found.worst,
                })
            })
        };
        json!({
            "schema": 1,
            "least": found(self.least()),
            "most": found(self.most()),
            "largest_gain": found(self.widest()),
            "share_within_tolerance": self.share_within(),
        })
    }
}

impl<'a> Found<'a> {
    /// At `point`, if some turn is possible there.
    fn at(point: &'a TurnMapPoint) -> Option<Self> {
        let turns = point.turns.as_ref().ok()?;
        Some(Found { point, best: turns.best, worst: turns.worst })
    }

    /// How many times as far the tool moves at the worst turn as at the best.
    pub fn gain(&self) -> f64 {
        self.worst.deflection_mm / self.best.deflection_mm
    }
}
