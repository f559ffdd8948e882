//! The blocks of a program as a control runs them: how long each takes, and by how much the motion turns between two.

use crate::toolpath::gcode::{
    GcodeError, Program,
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

    /// Gives its lines and arcs that are driven with the feed to `take`; holes of cycles are not among them.
    ///
    /// # Errors
    /// When it cannot be followed.
    pub fn each_move(&self, mut take: impl FnMut(Move)) -> Result<(), GcodeError> {
        let mut before: Option<Motion> = None;
        self.walk(|block| {
            for motion in &block.motions {
                if is_fed(motion) {
                    take(driven(motion, before.as_ref().filter(|before| is_fed(before))));
                }
                before = Some(motion.clone());
            }
            Ok::<(), GcodeError>(())
        })?;
        Ok(())
    }
}

/// `motion` behind the one `before`, if that is driven with the feed, too.
fn driven(motion: &Motion, before: Option<&Motion>) -> Move {
    let length = motion.geometry.length();
    let feed = motion.modal.feed_mm_per_min(length).filter(|feed| *feed > 0.0 && length > 0.0);
    let turn_rad = before.and_then(|before| {
        let (arrival, departure) = (before.geometry.at(1.0)?.1, motion.geometry.at(0.0)?.1);
        (arrival.norm() > 0.0 && departure.norm() > 0.0).then(|| arrival.angle(&departure))
    });
    Move { seconds: feed.map(|feed| 60.0 * length / feed), turn_rad }
}

fn is_fed(motion: &Motion) -> bool {
    matches!(motion.geometry, Geometry::Line(..) | Geometry::Arc(_)) && motion.code != MotionCode::Rapid
}
