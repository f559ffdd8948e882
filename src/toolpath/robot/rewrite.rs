//! Writing a program of poses back with moved points.

use nalgebra::Vector3;

use super::{
    RobotError, RobotOptions, RobotProgram, RobotRewriteError,
    follow::Motion,
    language::Language,
    split::{Points, Writer},
    target_text::Pen,
    way::Way,
};
use crate::toolpath::{Orientation, PathPoint, Toolpath, gcode::Writing, path::check_corrected};

/// A program written back, with what is needed to read it point by point.
#[derive(Clone, Debug)]
pub struct RewrittenRobot {
    bytes: Vec<u8>,
    /// How many path points each motion of the written program stands for.
    pieces: Vec<usize>,
    /// Where on its motion each of them lies, from 0 to 1.
    places: Vec<f64>,
    name: String,
    language: Language,
    beside: Option<(String, Vec<u8>)>,
    options: RobotOptions,
}

impl RewrittenRobot {
    /// The program's bytes.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// The program's bytes, to keep.
    #[must_use]
    pub fn into_bytes(self) -> Vec<u8> {
        self.bytes
    }

    /// The written program, read as a controller would, with the `.dat` of the one it was written from.
    ///
    /// # Errors
    /// When it cannot be followed.
    pub fn read(&self) -> Result<RobotProgram, RobotError> {
        RobotProgram::parse(self.bytes.clone(), &self.name, self.language, self.beside.clone(), &self.options)
    }

    /// The path of the written program, point k where point k of the original path is passed: the same number of
    /// points, in the same order.
    ///
    /// # Errors
    /// When the written program cannot be followed.
    pub fn read_back(&self) -> Result<Toolpath, RobotError> {
        let mut points = Vec::with_capacity(self.places.len());
        self.each_of(&self.read()?, |point| points.push(*point))?;
        Ok(Toolpath::assemble(points).with_external_axes(&self.options.external_axes))
    }

    /// As [`RewrittenRobot::read_back`], of the written program once it has been read, the positions alone (workpiece
    /// frame, mm).
    ///
    /// # Errors
    /// When it is another program.
    pub fn positions_of(&self, written: &RobotProgram) -> Result<Vec<Vector3<f64>>, RobotError> {
        let mut positions = Vec::with_capacity(self.places.len());
        self.each_of(written, |point| positions.push(point.position_mm))?;
        Ok(positions)
    }

    /// As [`RewrittenRobot::positions_of`], how the tool stands; `None` where the program does not say it.
    ///
    /// # Errors
    /// When it is another program.
    pub fn orientations_of(&self, written: &RobotProgram) -> Result<Vec<Option<Orientation>>, RobotError> {
        let mut orientations = Vec::with_capacity(self.places.len());
        self.each_of(written, |point| orientations.push(point.orientation))?;
        Ok(orientations)
    }

    /// The same, point after point, given to `take`.
    ///
    /// # Errors
    /// When it is another program.
    pub(crate) fn each_of(&self, written: &RobotProgram, take: impl FnMut(&PathPoint)) -> Result<(), RobotError> {
        let mut places = self.places.as_slice();
        let own = |segment: usize, _: &Motion| {
            let (own, rest) = places.split_at_checked(*self.pieces.get(segment)?)?;
            places = rest;
            Some(own.to_vec())
        };
        written.sample(RobotProgram::MAX_POINTS, own, take)
    }
}

impl RobotProgram {
    /// The program with the points of `path` moved to `corrected_mm`, positions in the workpiece frame, and turned to
    /// `orientations` if they are given.
    ///
    /// `path` is what [`RobotProgram::toolpath`] gave. A motion stays one statement where one of its kind passes all
    /// its corrected points to a unit of the last decimal, or within the tolerance; otherwise it becomes a sequence of
    /// straight motions, or of circles and straight ones, each of which passes as many points as it can. They repeat the statement's velocity, zone,
    /// tool and approximation, and nothing else. Numbers change only by more than half a unit of the last decimal:
    /// without correction the bytes are the same. A point that is declared elsewhere stays declared there; where it is
    /// corrected, the motion has its numbers instead of its name.
    ///
    /// # Errors
    /// When there is not one finite position (and orientation) for every point, or `path` is from another program.
    pub fn rewrite(
        &self,
        path: &Toolpath,
        corrected_mm: &[Vector3<f64>],
        orientations: Option<&[Orientation]>,
        writing: impl Into<Writing>,
    ) -> Result<RewrittenRobot, RobotRewriteError> {
        check_corrected(path, corrected_mm, orientations)?;
        let writing = writing.into();
        let pen = Pen { language: self.language, format: writing.format, decimals: self.decimals };
        let mut writer = Writer::new(&self.source, pen, writing.tolerance_mm.max(0.0));
        let (mut segment, mut next) = (0, 0);
        self.walk(|motion| {
            let range = next..self.end_of(motion, segment, next, path)?;
            let points = Points {
                points: &path.points()[range.clone()],
                corrected: &corrected_mm[range.clone()],
                orientations: orientations.map(|orientations| &orientations[range.clone()]),
            };
            writer.motion(motion, points).map_err(|fault| self.refused(&motion.statement, fault))?;
            (segment, next) = (segment + 1, range.end);
            Ok::<(), RobotRewriteError>(())
        })?;
        if next != path.len() {
            return Err(self.foreign());
        }
        let (bytes, pieces, places) = writer.finish();
        Ok(RewrittenRobot {
            bytes,
            pieces,
            places,
            name: self.name.clone(),
            language: self.language,
            beside: self.beside.clone(),
            options: self.options.clone(),
        })
    }

    fn foreign(&self) -> RobotRewriteError {
        RobotRewriteError::ForeignPath { program: self.name.clone() }
    }

    /// Where the points end that `motion`, the `segment`-th, has in `path` from `first` on, after checking that they
    /// are its.
    fn end_of(
        &self,
        motion: &Motion,
        segment: usize,
        first: usize,
        path: &Toolpath,
    ) -> Result<usize, RobotRewriteError> {
        let points = path.points();
        let mut next = first;
        while let Some(point) = points.get(next).filter(|point| point.source.segment == segment) {
            let here = motion.way.at(point.source.parameter);
            if here.map(|(position, _)| position) != Some(point.position_mm) {
                return Err(self.foreign());
            }
            next += 1;
        }
        let complete = match motion.way {
            Way::Unlocated => next == first,
            _ => next > first && points[next - 1].source.parameter == 1.0,
        };
        if complete { Ok(next) } else { Err(self.foreign()) }
    }
}
