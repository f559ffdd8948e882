//! Motions as they are written: one statement where one passes all corrected points, a sequence of straight ones
//! otherwise.

use nalgebra::Vector3;

use crate::toolpath::{
    model::{
        Orientation, PathPoint, WRITTEN_RAD, Way, longest,
        robot::{Kind, Language, RobotFault, Target},
    },
    read::robot::{Motion, Stand, indent, line_ending},
    write::robot::{Goal, Pen, Shown},
};

/// Points of one motion, and where they should be.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Points<'a> {
    pub points: &'a [PathPoint],
    /// Workpiece frame, mm.
    pub corrected: &'a [Vector3<f64>],
    pub orientations: Option<&'a [Orientation]>,
}

impl Points<'_> {
    pub(crate) fn len(&self) -> usize {
        self.points.len()
    }

    pub(crate) fn orientation(&self, k: usize) -> Option<Orientation> {
        self.orientations.map_or(self.points[k].orientation, |orientations| Some(orientations[k]))
    }

    pub(crate) fn goal(&self, k: usize, motion: &Motion) -> Goal {
        Goal {
            position: self.corrected[k],
            orientation: self.orientation(k),
            external: motion.external_at(self.points[k].source.parameter),
        }
    }

    /// How much of the motion the points `which` stand for, from 0 to 1.
    pub(crate) fn share(&self, which: &std::ops::Range<usize>) -> f64 {
        let parameter = |k: usize| self.points[k].source.parameter;
        parameter(which.end - 1) - which.start.checked_sub(1).map_or(0.0, parameter)
    }

    pub(crate) fn correction(&self, k: usize) -> Vector3<f64> {
        self.corrected[k] - self.points[k].position_mm
    }
}

/// The program as it is being written.
#[derive(Debug)]
pub(crate) struct Writer<'a> {
    source: &'a [u8],
    pub(crate) pen: Pen,
    tolerance_mm: f64,
    out: Vec<u8>,
    /// What of the source is in `out`.
    copied: usize,
    /// Where the written program has the tool.
    tracked: Option<Stand>,
    pieces: Vec<usize>,
    places: Vec<f64>,
}

/// A statement of a split motion: the pose it passes if it is a circle, its last pose, and where its points lie on it.
pub(crate) struct Piece {
    pub via: Option<Shown>,
    pub shown: Shown,
    pub places: Vec<f64>,
}

impl<'a> Writer<'a> {
    pub fn new(source: &'a [u8], pen: Pen, tolerance_mm: f64) -> Self {
        let out = Vec::with_capacity(source.len());
        Self { source, pen, tolerance_mm, out, copied: 0, tracked: None, pieces: Vec::new(), places: Vec::new() }
    }

    /// The bytes; points of each motion; and where on its motion each lies.
    pub fn finish(mut self) -> (Vec<u8>, Vec<usize>, Vec<f64>) {
        self.out.extend_from_slice(&self.source[self.copied..]);
        (self.out, self.pieces, self.places)
    }

    /// Writes `motion`, whose points are `points`.
    pub fn motion(&mut self, motion: &Motion, points: Points<'_>) -> Result<(), RobotFault> {
        let statement = &motion.statement;
        let (Some(target), Some(last)) = (&statement.end, points.len().checked_sub(1)) else {
            self.tracked = None;
            self.pieces.push(0);
            return Ok(());
        };
        match (&motion.way, self.tracked) {
            (Way::Line(..), Some(from)) => {
                let goal = points.goal(last, motion);
                let shown = self.pen.show(statement, target, &goal, Some(&from))?.ok_or(RobotFault::NoCircle)?;
                let way = Way::Line(from.position, shown.stand.position);
                match self.places(&way, [from, shown.stand], motion, points, 0..points.len()) {
                    Some(places) => self.whole(target, &shown, places),
                    None => self.split(motion, points)?,
                }
            }
            (Way::Circle(arc), Some(from)) => {
                if !self.circle(motion, arc, from, points)? {
                    self.split(motion, points)?;
                }
            }
            _ => {
                let from = self.tracked;
                let shown = self.pen.show(statement, target, &points.goal(last, motion), from.as_ref())?;
                let shown = shown.ok_or(RobotFault::CircleFromNowhere)?;
                self.whole(target, &shown, vec![1.0; points.len()]);
            }
        }
        Ok(())
    }

    /// A statement that stays one.
    pub(crate) fn whole(&mut self, target: &Target, shown: &Shown, places: Vec<f64>) {
        self.put(target, shown);
        self.stands_for(shown.stand, places);
    }

    /// Copies up to `target`, and writes it as `shown` if it changes.
    pub(crate) fn put(&mut self, target: &Target, shown: &Shown) {
        if shown.is_changed {
            self.out.extend_from_slice(&self.source[self.copied..target.at.start]);
            self.out.extend_from_slice(&shown.text);
            self.copied = target.at.end;
        }
    }

    fn stands_for(&mut self, stand: Stand, places: Vec<f64>) {
        self.tracked = Some(stand);
        self.pieces.push(places.len());
        self.places.extend(places);
    }

    /// Where on `way`, along which the tool turns between `stands`, the points `which` lie, one after another; `None`
    /// if it does not pass them.
    pub(crate) fn places(
        &self,
        way: &Way,
        [from, to]: [Stand; 2],
        motion: &Motion,
        points: Points<'_>,
        which: std::ops::Range<usize>,
    ) -> Option<Vec<f64>> {
        let parameter = |k: usize| points.points[k].source.parameter;
        let begin = which.start.checked_sub(1).map_or(0.0, parameter);
        let length = parameter(which.end - 1) - begin;
        let unit_mm = self.pen.unit_mm(&motion.statement) * (1.0 + 1e-6);
        let mut places = Vec::with_capacity(which.len());
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
            places.push(place);
        }
        *places.last_mut()? = 1.0;
        Some(places)
    }

    /// Writes a motion as a sequence: of straight motions, and of circles where they pass more points of one.
    fn split(&mut self, motion: &Motion, points: Points<'_>) -> Result<(), RobotFault> {
        let statement = &motion.statement;
        let Some(target) = &statement.end else { return Ok(()) };
        let first_pose = statement.via.as_ref().unwrap_or(target).at.start;
        let (source, at) = (self.source, &statement.at);
        let own = &source[statement.keyword.clone()];
        let straight = match (statement.kind, self.pen.language) {
            (Kind::Circle, Language::Krl) => b"LIN".as_slice(),
            (Kind::Circle, Language::Rapid) => b"MoveL",
            _ => own,
        };
        let (blanks, _) = indent(source, at.start);
        self.out.extend_from_slice(&source[self.copied..at.start]);
        let mut next = 0;
        while next < points.len() {
            let piece = self.longest(motion, target, points, next)?;
            next += piece.places.len();
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
            self.stands_for(piece.shown.stand, piece.places);
        }
        self.copied = at.end;
        Ok(())
    }

    /// The piece that passes most of the points from `first` on. A line to the first point always does.
    fn longest(&self, motion: &Motion, target: &Target, points: Points<'_>, first: usize) -> Result<Piece, RobotFault> {
        let from = self.tracked.ok_or(RobotFault::CircleFromNowhere)?;
        let most = if self.tolerance_mm > 0.0 { points.len() - first } else { 1 };
        let show = |k: usize| {
            let shown = self.pen.show(&motion.statement, target, &points.goal(k, motion), Some(&from))?;
            shown.ok_or(RobotFault::CircleFromNowhere)
        };
        let attempt = |count: usize| -> Result<Option<Piece>, RobotFault> {
            let shown = show(first + count - 1)?;
            let way = Way::Line(from.position, shown.stand.position);
            let places = self.places(&way, [from, shown.stand], motion, points, first..first + count);
            Ok(places.map(|places| Piece { via: None, shown, places }))
        };
        let mut best = longest(Piece { via: None, shown: show(first)?, places: vec![1.0] }, most, attempt)?;
        if let Some(arc) = self.longest_arc(motion, target, from, points, first..first + most)?
            && arc.places.len() > best.places.len()
        {
            best = arc;
        }
        Ok(best)
    }
}

/// Where `way` passes nearest to `goal`, from 0 to 1; of a circle, next to `guess`.
fn nearest(way: &Way, goal: &Vector3<f64>, guess: f64) -> f64 {
    match way {
        Way::Line(start, end) => {
            let along = end - start;
            let share = (goal - start).dot(&along) / along.norm_squared();
            if share.is_finite() { share.clamp(0.0, 1.0) } else { guess }
        }
        Way::Circle(arc) => arc.nearest(goal, guess),
        _ => 1.0,
    }
}
