//! Writes circles of robot programs: as one circle through corrected points, where it passes all points between them.

use std::{f64::consts::PI, ops::Range};

use nalgebra::Vector3;

use crate::{
    model::{
        MotionGeometry, Orientation,
        robot::{AptCircle, Arc, CircleTurn, RobotFault, Target},
    },
    read::robot::{Motion, ToolState, target_state},
    write::robot::{DesiredPose, Piece, Points, Writer, WrittenPose},
};

/// A written circle may turn by as much more or less than the programmed one, rad.
const TURN_RAD: f64 = 0.5;

impl Writer<'_> {
    /// Writes the corrected points of `arc` as one circle statement if a circle from `from` passes them within tolerance; returns whether
    /// it did.
    pub(crate) fn write_circle(
        &mut self,
        motion: &Motion,
        arc: &Arc,
        from: ToolState,
        points: Points<'_>,
    ) -> Result<bool, RobotFault> {
        let statement = &motion.statement;
        if let (Some(circle), Some(target)) = (&statement.apt.circle, &statement.end) {
            return self.write_apt_circle(motion, circle, target, from, points);
        }
        let (Some(start), Some(via), Some(target)) = (motion.start, &statement.via, &statement.end) else {
            return Ok(false);
        };
        let last = points.len() - 1;
        let start_by = from.position - start.position;
        let state_at = |target: &Target| target_state(self.format.language, statement, target, Some(&start));
        let (Some(via_at), Some(end_at)) = (state_at(via)?, state_at(target)?) else { return Ok(false) };
        let (via_by, end_by) = match statement.sweep_rad {
            // Its end is not where its pose is: it can only be moved as a whole.
            Some(_) => (points.correction(last), points.correction(last)),
            None => {
                let at = |k: usize| points.points[k].source.parameter;
                let k = (0..last).find(|k| at(*k) >= arc.via).unwrap_or(last);
                let before = k.checked_sub(1).map_or((0.0, start_by), |before| (at(before), points.correction(before)));
                let share = ((arc.via - before.0) / (at(k) - before.0)).clamp(0.0, 1.0);
                (before.1.lerp(&points.correction(k), share), points.correction(last))
            }
        };
        let postures = |k: usize| points.postures.get(k).copied().flatten();
        let via_k = (0..last).find(|k| points.points[*k].source.parameter >= arc.via).unwrap_or(last);
        let goal = |state: &ToolState, by: Vector3<f64>, orientation, k: usize| DesiredPose {
            position: state.position + by,
            orientation,
            external: state.external,
            arm: postures(k),
        };
        let via_pose =
            self.format.write_pose(statement, via, &goal(&via_at, via_by, via_at.orientation, via_k), Some(&from))?;
        let end_pose = self.format.write_pose(
            statement,
            target,
            &goal(&end_at, end_by, points.orientation(last), last),
            Some(&from),
        )?;
        let (Some(via_pose), Some(mut end_pose)) = (via_pose, end_pose) else { return Ok(false) };
        // Which way a circle of splines turns the tool depends on the orientation of its point between.
        if statement.spline.is_some()
            && !(are_alike(start.orientation, from.orientation)
                && are_alike(end_at.orientation, end_pose.state.orientation))
        {
            return Ok(false);
        }
        let through = [from.position, via_pose.state.position, end_pose.state.position];
        let Some(written) = Arc::through(through, statement.sweep_rad) else { return Ok(false) };
        if (written.sweep_rad() - arc.sweep_rad()).abs() > TURN_RAD {
            return Ok(false);
        }
        let circle = MotionGeometry::Circle(written);
        end_pose.state.position = circle.at(1.0).map_or(end_pose.state.position, |(position, _)| position);
        let Some(parameters) = self.parameters(&circle, [from, end_pose.state], motion, points, 0..points.len()) else {
            return Ok(false);
        };
        self.put_target(via, &via_pose);
        self.write_one_statement(target, &end_pose, parameters);
        Ok(true)
    }

    /// Writes an arc of APT about the centre that fits its corrected points, if one does; returns whether it did.
    fn write_apt_circle(
        &mut self,
        motion: &Motion,
        circle: &AptCircle,
        target: &Target,
        from: ToolState,
        points: Points<'_>,
    ) -> Result<bool, RobotFault> {
        let (statement, last) = (&motion.statement, points.len() - 1);
        let end = self.format.write_pose(statement, target, &points.goal(last, motion), Some(&from))?;
        let (Some(end), Some(start), MotionGeometry::Circle(arc)) = (end, motion.start, &motion.geometry) else {
            return Ok(false);
        };
        let half_mm = self.format.unit_mm(statement) * 0.5;
        let is_moved = end.is_changed
            || from.position != start.position
            || (0..points.len()).any(|k| points.correction(k).amax() > half_mm);
        let record = match is_moved {
            false => circle.record.clone(),
            true => {
                let CircleTurn::About(axis) = circle.turn else { return Ok(false) };
                let axis = statement.frames.base.rotation * axis;
                let across = |point: Vector3<f64>| point - axis * (point - from.position).dot(&axis);
                let thirds = [last / 3, 2 * last / 3].map(|k| across(points.corrected[k]));
                let centre = match Arc::through([from.position, thirds[0], thirds[1]], None) {
                    Some(fitted) if last >= 3 => fitted.centre(),
                    _ => across(arc.centre() + points.correction(last).lerp(&(from.position - start.position), 0.5)),
                };
                let height = (circle.centre(statement, &circle.record) - arc.centre()).dot(&axis);
                let radius_mm = (from.position - centre).norm();
                self.format.circle_record(statement, &circle.record, centre + axis * height, radius_mm)
            }
        };
        let is_changed = record.text != circle.record.text;
        let Ok(written) = circle.arc_between(statement, &record, [from.position, end.state.position]) else {
            return Ok(false);
        };
        if (written.sweep_rad() - arc.sweep_rad()).abs() > TURN_RAD {
            return Ok(false);
        }
        let geometry = MotionGeometry::Circle(written);
        let Some(parameters) = self.parameters(&geometry, [from, end.state], motion, points, 0..points.len()) else {
            return Ok(false);
        };
        self.put_target(&circle.record, &WrittenPose { text: record.text, is_changed, state: from });
        self.write_one_statement(target, &end, parameters);
        Ok(true)
    }

    /// Returns the circle from `from` on that passes the most of the first points of `range`: halves their number until one does, then
    /// bisects. `None` if no circle passes two or more.
    pub(crate) fn longest_arc(
        &self,
        motion: &Motion,
        target: &Target,
        from: ToolState,
        points: Points<'_>,
        range: Range<usize>,
    ) -> Result<Option<Piece>, RobotFault> {
        let attempt = |count: usize| self.arc_piece(motion, target, from, points, range.start..range.start + count);
        let (mut best, mut count, mut failed) = (None, range.len(), range.len() + 1);
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

    /// Returns a circle from `from` that passes the points `range` within tolerance, if there is one.
    fn arc_piece(
        &self,
        motion: &Motion,
        target: &Target,
        from: ToolState,
        points: Points<'_>,
        range: Range<usize>,
    ) -> Result<Option<Piece>, RobotFault> {
        let statement = &motion.statement;
        let (MotionGeometry::Circle(arc), Some(via), None) = (&motion.geometry, &statement.via, statement.sweep_rad)
        else {
            return Ok(None);
        };
        let ends = [motion.start, motion.end].map(|state| state.and_then(|state| state.orientation));
        if statement.spline.is_some() && (points.orientations.is_some() || !are_alike(ends[0], ends[1])) {
            return Ok(None);
        }
        let middle = range.start + range.len() / 2 - 1;
        let pose =
            |target: &Target, k: usize| self.format.write_pose(statement, target, &points.goal(k, motion), Some(&from));
        let (Some(via_pose), Some(end)) = (pose(via, middle)?, pose(target, range.end - 1)?) else { return Ok(None) };
        let through = [from.position, via_pose.state.position, end.state.position];
        let Some(written) = Arc::through(through, None) else { return Ok(None) };
        let nominal = points.motion_share(&range) * arc.sweep_rad();
        let is_alike = (written.sweep_rad() - nominal).abs() <= nominal * MAX_CHANGE_OF_TURN;
        let chord_mm = (end.state.position - from.position).norm();
        if !is_alike || written.sweep_rad() < LEAST_TURN_RAD || chord_mm < LEAST_CHORD_MM {
            return Ok(None);
        }
        let parameters = self.parameters(&MotionGeometry::Circle(written), [from, end.state], motion, points, range);
        Ok(parameters.map(|parameters| Piece { via: Some(via_pose), end, parameters }))
    }
}

/// Whether two orientations are the same, but for what no decimal of an angle shows.
fn are_alike(a: Option<Orientation>, b: Option<Orientation>) -> bool {
    a.zip(b).is_some_and(|(a, b)| a.angle_to(&b) < 1e-6)
}

/// A part of a circle may turn by as much more or less than programmed, as a share.
const MAX_CHANGE_OF_TURN: f64 = 0.5;
/// Controllers refuse shorter circles than this, and those that turn less.
const LEAST_CHORD_MM: f64 = 1.0;
/// See [`LEAST_CHORD_MM`]: a degree between the ways to the middle and to the end is a quarter of it.
const LEAST_TURN_RAD: f64 = PI / 36.0;
