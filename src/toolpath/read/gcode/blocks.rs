//! The blocks of a program as a control runs them: how long each takes, and by how much the motion turns between two.

use nalgebra::Vector3;

use crate::toolpath::{
    model::{
        Way,
        gcode::{GcodeError, Motion, MotionCode},
    },
    read::gcode::Program,
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
        // The direction in which the move before ends; zero where that is not driven with the feed.
        let mut arrival = Vector3::zeros();
        self.walk(|block| {
            for motion in &block.motions {
                let fed = is_fed(motion);
                if fed {
                    take(driven(motion, &arrival));
                }
                let end = motion.geometry.at(1.0).filter(|_| fed);
                arrival = end.map_or_else(Vector3::zeros, |(_, tangent)| tangent);
            }
            Ok::<(), GcodeError>(())
        })?;
        Ok(())
    }
}

/// `motion` behind a move that ends in the direction `arrival`, which is zero if there is none.
fn driven(motion: &Motion, arrival: &Vector3<f64>) -> Move {
    let length = motion.geometry.length();
    let feed = motion.modal.feed_mm_per_min(length).filter(|feed| *feed > 0.0 && length > 0.0);
    let departure = motion.geometry.at(0.0).map(|(_, tangent)| tangent);
    let turn_rad = departure
        .filter(|departure| arrival.norm() > 0.0 && departure.norm() > 0.0)
        .map(|departure| arrival.angle(&departure));
    Move { seconds: feed.map(|feed| 60.0 * length / feed), turn_rad }
}

fn is_fed(motion: &Motion) -> bool {
    matches!(motion.geometry, Way::Line(..) | Way::Arc(_)) && motion.code != MotionCode::Rapid
}
