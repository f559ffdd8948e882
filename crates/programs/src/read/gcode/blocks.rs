//! Durations of the blocks of a program at the programmed feed, and the angles between them.

use nalgebra::Vector3;

use crate::{
    model::{
        MotionGeometry,
        gcode::{GcodeError, Motion, MotionCode},
    },
    read::gcode::GcodeProgram,
};

/// A line or arc at feed rate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Move {
    /// Duration at the programmed feed, s; `None` without feed or length.
    pub seconds: Option<f64>,
    /// Angle between the end of the feed move before and its start, rad; `None` without one, or if either has no direction.
    pub turn_rad: Option<f64>,
}

impl GcodeProgram {
    /// Number of lines of the program.
    #[must_use]
    pub fn line_count(&self) -> usize {
        self.lines.len()
    }

    /// Passes the lines and arcs at feed rate to `take`, in order; holes of cycles are left out. `Err` if the program cannot be followed.
    pub(crate) fn each_move(&self, mut take: impl FnMut(Move)) -> Result<(), GcodeError> {
        // The direction in which the move before ends; zero where that is not driven with the feed.
        let mut arrival = Vector3::zeros();
        self.walk(|block| {
            for motion in &block.motions {
                let fed = is_fed(motion);
                if fed {
                    take(fed_move(motion, &arrival));
                }
                let end = motion.geometry.at(1.0).filter(|_| fed);
                arrival = end.map_or_else(Vector3::zeros, |(_, tangent)| tangent);
            }
            Ok::<(), GcodeError>(())
        })?;
        Ok(())
    }
}

/// Returns the duration of `motion` (s), and its angle (rad) to `arrival`, the direction in which the move before ends (zero if none).
fn fed_move(motion: &Motion, arrival: &Vector3<f64>) -> Move {
    let length = motion.geometry.length();
    let has_way = length > 0.0 || motion.turned_alone_deg().is_some();
    let minutes = motion.minutes(length).filter(|_| has_way);
    let departure = motion.geometry.at(0.0).map(|(_, tangent)| tangent);
    let turn_rad = departure
        .filter(|departure| arrival.norm() > 0.0 && departure.norm() > 0.0)
        .map(|departure| arrival.angle(&departure));
    Move { seconds: minutes.map(|minutes| 60.0 * minutes), turn_rad }
}

/// Whether `motion` is a line or arc at feed rate.
fn is_fed(motion: &Motion) -> bool {
    matches!(motion.geometry, MotionGeometry::Line(..) | MotionGeometry::Arc(_)) && motion.code != MotionCode::Rapid
}
