//! Writes the motions of robot programs: one statement where one passes all corrected points, otherwise a sequence of
//! straight motions and circles.

use nalgebra::Vector3;

use crate::toolpath::{
    model::{
        MotionGeometry, Orientation, PathPoint, WRITTEN_RAD, longest_piece,
        robot::{Language, MotionKind, RobotFault, Target},
    },
    read::robot::{Motion, ToolState, indent, line_ending},
    write::robot::{Goal, PoseFormat, WrittenPose},
};

/// The points of one motion, and their corrected positions and orientations.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Points<'a> {
    pub points: &'a [PathPoint],
    /// Corrected positions in the workpiece frame, mm.
    pub corrected: &'a [Vector3<f64>],
    pub orientations: Option<&'a [Orientation]>,
}

impl Points<'_> {
    /// Returns the number of points.
    pub(crate) fn len(&self) -> usize {
        self.points.len()
    }

    /// Returns the wanted tool orientation at point `k`: the corrected one, or that of the path.
    pub(crate) fn orientation(&self, k: usize) -> Option<Orientation> {
        self.orientations.map_or(self.points[k].orientation, |orientations| Some(orientations[k]))
    }

    /// Returns where the written pose of point `k` should lead.
    pub(crate) fn goal(&self, k: usize, motion: &Motion) -> Goal {
        Goal {
            position: self.corrected[k],
            orientation: self.orientation(k),
            external: motion.external_at(self.points[k].source.parameter),
        }
    }

    /// Returns the share of the motion, from 0 to 1, that ends at the points `which`.
    pub(crate) fn motion_share(&self, which: &std::ops::Range<usize>) -> f64 {
        let parameter = |k: usize| self.points[k].source.parameter;
        parameter(which.end - 1) - which.start.checked_sub(1).map_or(0.0, parameter)
    }

    /// Returns the commanded less the programmed tool position of point `k`, in the workpiece frame, mm.
    pub(crate) fn correction(&self, k: usize) -> Vector3<f64> {
        self.corrected[k] - self.points[k].position_mm
    }
}

/// The writer of a corrected robot program: the text written so far, and where it has led the tool.
#[derive(Debug)]
pub(crate) struct Writer<'a> {
    source: &'a [u8],
    pub(crate) pen: PoseFormat,
    tolerance_mm: f64,
    out: Vec<u8>,
    /// How many bytes of the source have been copied or replaced.
    copied: usize,
    /// Where the written statements have led the tool; `None` if unknown.
    tracked: Option<ToolState>,
    pieces: Vec<usize>,
    parameters: Vec<f64>,
}

/// A statement of a split motion: the intermediate pose of a circle, the end pose, and where its points lie on it, from 0 to 1.
pub(crate) struct Piece {
    pub via: Option<WrittenPose>,
    pub shown: WrittenPose,
    pub parameters: Vec<f64>,
}

impl<'a> Writer<'a> {
    /// Creates a writer of the program `source` with nothing written; poses get the format `pen`.
    pub fn new(source: &'a [u8], pen: PoseFormat, tolerance_mm: f64) -> Self {
        let out = Vec::with_capacity(source.len());
        Self { source, pen, tolerance_mm, out, copied: 0, tracked: None, pieces: Vec::new(), parameters: Vec::new() }
    }

    /// Copies the rest of the source and returns the bytes, the number of points of each motion, and where on its motion each lies.
    pub fn finish(mut self) -> (Vec<u8>, Vec<usize>, Vec<f64>) {
        self.out.extend_from_slice(&self.source[self.copied..]);
        (self.out, self.pieces, self.parameters)
    }

    /// Writes `motion` with its corrected `points`: as one statement if one passes them all, otherwise split.
    pub fn write_motion(&mut self, motion: &Motion, points: Points<'_>) -> Result<(), RobotFault> {
        let statement = &motion.statement;
        let (Some(target), Some(last)) = (&statement.end, points.len().checked_sub(1)) else {
            self.tracked = None;
            self.pieces.push(0);
            return Ok(());
        };
        match (&motion.way, self.tracked) {
            (MotionGeometry::Line(..), Some(from)) => {
                let goal = points.goal(last, motion);
                let shown = self.pen.write_pose(statement, target, &goal, Some(&from))?.ok_or(RobotFault::NoCircle)?;
                let way = MotionGeometry::Line(from.position, shown.stand.position);
                match self.parameters(&way, [from, shown.stand], motion, points, 0..points.len()) {
                    Some(parameters) => self.write_one_statement(target, &shown, parameters),
                    None => self.write_split(motion, points)?,
                }
            }
            (MotionGeometry::Circle(arc), Some(from)) => {
                if !self.write_circle(motion, arc, from, points)? {
                    self.write_split(motion, points)?;
                }
            }
            _ => {
                let from = self.tracked;
                let shown = self.pen.write_pose(statement, target, &points.goal(last, motion), from.as_ref())?;
                let shown = shown.ok_or(RobotFault::CircleFromNowhere)?;
                self.write_one_statement(target, &shown, vec![1.0; points.len()]);
            }
        }
        Ok(())
    }

    /// Writes a motion that stays one statement.
    pub(crate) fn write_one_statement(&mut self, target: &Target, shown: &WrittenPose, parameters: Vec<f64>) {
        self.put_target(target, shown);
        self.record_points(shown.stand, parameters);
    }

    /// Copies the source up to `target` and writes the pose as `shown`, if it changes.
    pub(crate) fn put_target(&mut self, target: &Target, shown: &WrittenPose) {
        if shown.is_changed {
            self.out.extend_from_slice(&self.source[self.copied..target.at.start]);
            self.out.extend_from_slice(&shown.text);
            self.copied = target.at.end;
        }
    }

    /// Records that a motion to `stand` with path points at `parameters` (0 to 1) has been written.
    fn record_points(&mut self, stand: ToolState, parameters: Vec<f64>) {
        self.tracked = Some(stand);
        self.pieces.push(parameters.len());
        self.parameters.extend(parameters);
    }

    /// Returns where on `way`, along which the tool turns evenly from `from` to `to`, the points `which` lie, from 0 to 1 in
    /// ascending order; `None` if it does not pass them within tolerance.
    pub(crate) fn parameters(
        &self,
        way: &MotionGeometry,
        [from, to]: [ToolState; 2],
        motion: &Motion,
        points: Points<'_>,
        which: std::ops::Range<usize>,
    ) -> Option<Vec<f64>> {
        let parameter = |k: usize| points.points[k].source.parameter;
        let begin = which.start.checked_sub(1).map_or(0.0, parameter);
        let length = parameter(which.end - 1) - begin;
        let unit_mm = self.pen.unit_mm(&motion.statement) * (1.0 + 1e-6);
        let mut parameters = Vec::with_capacity(which.len());
        let mut passed = 0.0;
        for k in which.clone() {
            let goal = &points.corrected[k];
            let share = if length > 0.0 { (parameter(k) - begin) / length } else { 1.0 };
            let off = |t: f64| Some(way.at(t)?.0 - goal);
            let place = if off(share)?.amax() <= unit_mm {
                share.max(passed)
            } else {
                let place = if k + 1 < which.end { nearest(way, goal, share).max(passed) } else { 1.0 };
                if off(place)?.norm() > self.tolerance_mm {
                    return None;
                }
                place
            };
            let stands = from.orientation.zip(to.orientation).map(|(from, to)| from.towards(&to, place));
            if let (Some(_), Some(stands), Some(wanted)) = (points.orientations, stands, points.orientation(k))
                && stands.angle_to(&wanted) > WRITTEN_RAD
            {
                return None;
            }
            passed = place;
            parameters.push(place);
        }
        *parameters.last_mut()? = 1.0;
        Some(parameters)
    }

    /// Writes a motion as a sequence of straight motions, and of circles where these pass more points.
    fn write_split(&mut self, motion: &Motion, points: Points<'_>) -> Result<(), RobotFault> {
        let statement = &motion.statement;
        let Some(target) = &statement.end else { return Ok(()) };
        let first_pose = statement.via.as_ref().unwrap_or(target).at.start;
        let (source, at) = (self.source, &statement.at);
        let own = &source[statement.keyword.clone()];
        let straight = match (statement.kind, self.pen.language) {
            (MotionKind::Circle, Language::Krl) => b"LIN".as_slice(),
            (MotionKind::Circle, Language::Rapid) => b"MoveL",
            _ => own,
        };
        let (blanks, _) = indent(source, at.start);
        self.out.extend_from_slice(&source[self.copied..at.start]);
        let mut next = 0;
        while next < points.len() {
            let piece = self.longest(motion, target, points, next)?;
            next += piece.parameters.len();
            self.out.extend_from_slice(if piece.via.is_some() { own } else { straight });
            self.out.extend_from_slice(&source[statement.keyword.end..first_pose]);
            if let (Some(shown), Some(via)) = (&piece.via, &statement.via) {
                self.out.extend_from_slice(&shown.text);
                self.out.extend_from_slice(&source[via.at.end..target.at.start]);
            }
            self.out.extend_from_slice(&piece.shown.text);
            self.out.extend_from_slice(&source[statement.suffix.clone()]);
            if next < points.len() {
                self.out.extend_from_slice(line_ending(source));
                self.out.extend_from_slice(blanks);
            }
            self.record_points(piece.shown.stand, piece.parameters);
        }
        self.copied = at.end;
        Ok(())
    }

    /// Returns the piece that passes the most points from `first` on; a line to the first point always passes one.
    fn longest(&self, motion: &Motion, target: &Target, points: Points<'_>, first: usize) -> Result<Piece, RobotFault> {
        let from = self.tracked.ok_or(RobotFault::CircleFromNowhere)?;
        let most = if self.tolerance_mm > 0.0 { points.len() - first } else { 1 };
        let show = |k: usize| {
            let shown = self.pen.write_pose(&motion.statement, target, &points.goal(k, motion), Some(&from))?;
            shown.ok_or(RobotFault::CircleFromNowhere)
        };
        let attempt = |count: usize| -> Result<Option<Piece>, RobotFault> {
            let shown = show(first + count - 1)?;
            let way = MotionGeometry::Line(from.position, shown.stand.position);
            let parameters = self.parameters(&way, [from, shown.stand], motion, points, first..first + count);
            Ok(parameters.map(|parameters| Piece { via: None, shown, parameters }))
        };
        let mut best = longest_piece(Piece { via: None, shown: show(first)?, parameters: vec![1.0] }, most, attempt)?;
        if let Some(arc) = self.longest_arc(motion, target, from, points, first..first + most)?
            && arc.parameters.len() > best.parameters.len()
        {
            best = arc;
        }
        Ok(best)
    }
}

/// Returns the parameter, from 0 to 1, at which `way` passes nearest to `goal` (mm); on a circle, the one next to `guess`.
fn nearest(way: &MotionGeometry, goal: &Vector3<f64>, guess: f64) -> f64 {
    match way {
        MotionGeometry::Line(start, end) => {
            let along = end - start;
            let share = (goal - start).dot(&along) / along.norm_squared();
            if share.is_finite() { share.clamp(0.0, 1.0) } else { guess }
        }
        MotionGeometry::Circle(arc) => arc.nearest(goal, guess),
        _ => 1.0,
    }
}
