//! Writes circles of robot programs: as one circle through corrected points, where it passes all points between them.

use std::{f64::consts::PI, ops::Range};

use nalgebra::Vector3;

use crate::toolpath::{
    model::{
        MotionGeometry,
        robot::{Arc, RobotFault, Target},
    },
    read::robot::{Motion, ToolState, target_state},
    write::robot::{Goal, Piece, Points, Writer},
};

/// A written circle may turn by as much more or less than the programmed one, rad.
const TURN_RAD: f64 = 0.5;

impl Writer<'_> {
    /// Writes the corrected points of `arc` as one circle statement if a circle passes them within tolerance; returns whether it did, else
    /// nothing is written.
    pub(crate) fn write_circle(
        &mut self,
        motion: &Motion,
        arc: &Arc,
        from: ToolState,
        points: Points<'_>,
    ) -> Result<bool, RobotFault> {
        let statement = &motion.statement;
        let (Some(start), Some(via), Some(target)) = (motion.start, &statement.via, &statement.end) else {
            return Ok(false);
        };
        let last = points.len() - 1;
        let begin = from.position - start.position;
        let own = |target: &Target| target_state(self.pen.language, statement, target, Some(&start));
        let (Some(own_via), Some(own_end)) = (own(via)?, own(target)?) else { return Ok(false) };
        let (via_by, end_by) = match statement.sweep_rad {
            // Its end is not where its pose is: it can only be moved as a whole.
            Some(_) => (points.correction(last), points.correction(last)),
            None => {
                let at = |k: usize| points.points[k].source.parameter;
                let k = (0..last).find(|k| at(*k) >= arc.via).unwrap_or(last);
                let before = k.checked_sub(1).map_or((0.0, begin), |before| (at(before), points.correction(before)));
                let share = ((arc.via - before.0) / (at(k) - before.0)).clamp(0.0, 1.0);
                (before.1.lerp(&points.correction(k), share), points.correction(last))
            }
        };
        let goal = |stand: &ToolState, by: Vector3<f64>, orientation| Goal {
            position: stand.position + by,
            orientation,
            external: stand.external,
        };
        let shown_via =
            self.pen.write_pose(statement, via, &goal(&own_via, via_by, own_via.orientation), Some(&from))?;
        let shown_end =
            self.pen.write_pose(statement, target, &goal(&own_end, end_by, points.orientation(last)), Some(&from))?;
        let (Some(shown_via), Some(mut shown_end)) = (shown_via, shown_end) else { return Ok(false) };
        let through = [from.position, shown_via.stand.position, shown_end.stand.position];
        let Some(written) = Arc::through(through, statement.sweep_rad) else { return Ok(false) };
        if (written.sweep_rad() - arc.sweep_rad()).abs() > TURN_RAD {
            return Ok(false);
        }
        let way = MotionGeometry::Circle(written);
        shown_end.stand.position = way.at(1.0).map_or(shown_end.stand.position, |(position, _)| position);
        let Some(parameters) = self.parameters(&way, [from, shown_end.stand], motion, points, 0..points.len()) else {
            return Ok(false);
        };
        self.put_target(via, &shown_via);
        self.write_one_statement(target, &shown_end, parameters);
        Ok(true)
    }

    /// Returns the circle from `from` on that passes the most of the first points of `which`: halves their number until one does,
    /// then bisects. `None` if no circle passes two or more.
    pub(crate) fn longest_arc(
        &self,
        motion: &Motion,
        target: &Target,
        from: ToolState,
        points: Points<'_>,
        which: Range<usize>,
    ) -> Result<Option<Piece>, RobotFault> {
        let attempt = |count: usize| self.arc_piece(motion, target, from, points, which.start..which.start + count);
        let (mut best, mut count, mut failed) = (None, which.len(), which.len() + 1);
        while best.is_none() && count > 1 {
            best = attempt(count)?;
            if best.is_none() {
                (failed, count) = (count, count / 2);
            }
        }
        while best.is_some() && failed - count > 1 {
            let middle = usize::midpoint(count, failed);
            match attempt(middle)? {
                Some(piece) => (best, count) = (Some(piece), middle),
                None => failed = middle,
            }
        }
        Ok(best)
    }

    /// Returns a circle from `from` that passes the points `which` within tolerance, if there is one.
    fn arc_piece(
        &self,
        motion: &Motion,
        target: &Target,
        from: ToolState,
        points: Points<'_>,
        which: Range<usize>,
    ) -> Result<Option<Piece>, RobotFault> {
        let statement = &motion.statement;
        let (MotionGeometry::Circle(arc), Some(via), None) = (&motion.way, &statement.via, statement.sweep_rad) else {
            return Ok(None);
        };
        let middle = which.start + which.len() / 2 - 1;
        let show =
            |target: &Target, k: usize| self.pen.write_pose(statement, target, &points.goal(k, motion), Some(&from));
        let (Some(passed), Some(shown)) = (show(via, middle)?, show(target, which.end - 1)?) else { return Ok(None) };
        let through = [from.position, passed.stand.position, shown.stand.position];
        let Some(written) = Arc::through(through, None) else { return Ok(None) };
        let nominal = points.motion_share(&which) * arc.sweep_rad();
        let is_alike = (written.sweep_rad() - nominal).abs() <= nominal * MOST_CHANGE_OF_TURN;
        let chord_mm = (shown.stand.position - from.position).norm();
        if !is_alike || written.sweep_rad() < LEAST_TURN_RAD || chord_mm < LEAST_CHORD_MM {
            return Ok(None);
        }
        let parameters = self.parameters(&MotionGeometry::Circle(written), [from, shown.stand], motion, points, which);
        Ok(parameters.map(|parameters| Piece { via: Some(passed), shown, parameters }))
    }
}

/// A part of a circle may turn by as much more or less than programmed, as a share.
const MOST_CHANGE_OF_TURN: f64 = 0.5;
/// Controllers refuse shorter circles than this, and those that turn less.
const LEAST_CHORD_MM: f64 = 1.0;
/// See [`LEAST_CHORD_MM`]: a degree between the ways to the middle and to the end is a quarter of it.
const LEAST_TURN_RAD: f64 = PI / 36.0;
