//! The blocks of a program as a control runs them: how long each takes, and by how much the motion turns between two.

use crate::toolpath::gcode::{
    Program,
    modal::MotionCode,
    motion::{Geometry, Motion},
};

/// A line or arc that is driven with the feed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Move {
    /// How long it takes at the programmed feed, s; `None` where no feed is given, or no length.
    pub seconds: Option<f64>,
    /// The angle between the end of the move before and its beginning, rad; `None` if there is none before it with the feed, or either
    /// has no direction.
    pub turn_rad: Option<f64>,
}

impl Program {
    /// How many lines the program has.
    #[must_use]
    pub fn line_count(&self) -> usize {
        self.lines.len()
    }

    /// Its lines and arcs that are driven with the feed; holes of cycles are not among them.
    pub fn moves(&self) -> impl Iterator<Item = Move> + '_ {
        let before = std::iter::once(None).chain(self.motions.iter().map(Some));
        before.zip(&self.motions).filter(|(_, motion)| is_fed(motion)).map(|(before, motion)| {
            let length = motion.geometry.length();
            let feed = motion.modal.feed_mm_per_min(length).filter(|feed| *feed > 0.0 && length > 0.0);
            let turn_rad = before.filter(|before| is_fed(before)).and_then(|before| {
                let (arrival, departure) = (before.geometry.at(1.0)?.1, motion.geometry.at(0.0)?.1);
                (arrival.norm() > 0.0 && departure.norm() > 0.0).then(|| arrival.angle(&departure))
            });
            Move { seconds: feed.map(|feed| 60.0 * length / feed), turn_rad }
        })
    }
}

fn is_fed(motion: &Motion) -> bool {
    matches!(motion.geometry, Geometry::Line(..) | Geometry::Arc(_)) && motion.code != MotionCode::Rapid
}
