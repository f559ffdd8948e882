//! Programs of every format (G-code, robot, points): sampling their path points, and reading a written one back point by point.

use std::fmt;

use nalgebra::Vector3;
use thiserror::Error;

use crate::model::{
    MAX_COORDINATE_MM, Orientation, PathPoint, PositionsError, Toolpath, gcode::GcodeError, robot::RobotError,
};

/// A program that is written back and read again: of every format the same way.
pub trait Rewritable: Sized {
    /// The error of a program that cannot be followed.
    type Error;
    /// What is needed to read a program besides its bytes: name, language, options.
    type Reading: Clone + fmt::Debug;

    /// Reads the bytes of a written program. Fails when it cannot be followed.
    fn read_written(bytes: Vec<u8>, reading: &Self::Reading) -> Result<Self, Self::Error>;

    /// Passes the points of the program's path to `take`: those of each motion at the parameters (0 to 1) that `parameters` returns for
    /// the motion's index. An unknown tangent is zero. Fails when `parameters` returns `None`, or more points than a path may have in all.
    fn points_at(
        &self,
        parameters: impl FnMut(usize) -> Option<Vec<f64>>,
        take: impl FnMut(&PathPoint),
    ) -> Result<(), Self::Error>;

    /// Returns the names of the external axes that the program's path commands.
    fn external_axes(&self) -> Vec<String>;
}

/// A program written back, with what is needed to find each path point in it.
#[derive(Clone, Debug)]
pub struct Rewritten<P: Rewritable> {
    pub(crate) bytes: Vec<u8>,
    /// How many path points lie on each motion of the written program.
    pub(crate) pieces: Vec<usize>,
    /// Where on its motion each path point lies, from 0 to 1.
    pub(crate) parameters: Vec<f64>,
    /// Where the bytes of each line of an expanded program end; of a robot's, where those of each part begin and end.
    pub(crate) line_ends: Vec<usize>,
    pub(crate) reading: P::Reading,
}

impl<P: Rewritable> Rewritten<P> {
    /// Returns the program's bytes.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// Converts the written program into its bytes.
    #[must_use]
    pub fn into_bytes(self) -> Vec<u8> {
        self.bytes
    }

    /// Reads the written program as a controller would, moving the bytes out so that there is one copy of them. Fails when it cannot be followed.
    pub(crate) fn take_and_read(&mut self) -> Result<P, P::Error> {
        P::read_written(std::mem::take(&mut self.bytes), &self.reading)
    }

    /// Reads the written program as a controller would. Fails when it cannot be followed.
    pub fn read(&self) -> Result<P, P::Error> {
        P::read_written(self.bytes.clone(), &self.reading)
    }

    /// Reads the path of the written program, its point k where point k of the original path is passed: the same number of
    /// points, in the same order. Fails when the written program cannot be followed.
    pub fn read_back(&self) -> Result<Toolpath, P::Error> {
        let written = self.read()?;
        let points = self.collect_points(&written, |point| *point)?;
        Ok(Toolpath::assemble(points).with_external_axes(&written.external_axes()))
    }

    /// Returns the positions (mm in W) of the original path's points in `written`, the program read back. Fails when it is another program.
    pub fn read_positions(&self, written: &P) -> Result<Vec<Vector3<f64>>, P::Error> {
        self.collect_points(written, |point| point.position_mm)
    }

    /// Returns the tool orientations, if known, at the original path's points in `written`, the program read back; fails for another one.
    pub fn read_orientations(&self, written: &P) -> Result<Vec<Option<Orientation>>, P::Error> {
        self.collect_points(written, |point| point.orientation)
    }

    /// Returns `value` at each point of the original path, in the program `written`. Fails when it is another program.
    fn collect_points<T>(&self, written: &P, value: impl Fn(&PathPoint) -> T) -> Result<Vec<T>, P::Error> {
        let mut values = Vec::with_capacity(self.parameters.len());
        self.for_each_point(written, |point| values.push(value(point)))?;
        Ok(values)
    }

    /// Passes the points of `written` at which the original path's points lie to `take`, one after another. Fails when it is another program.
    pub(crate) fn for_each_point(&self, written: &P, take: impl FnMut(&PathPoint)) -> Result<(), P::Error> {
        let mut parameters = self.parameters.as_slice();
        let next_parameters = |motion: usize| {
            let (of_motion, rest) = parameters.split_at_checked(*self.pieces.get(motion)?)?;
            parameters = rest;
            Some(of_motion.to_vec())
        };
        written.points_at(next_parameters, take)
    }
}

/// Samples motions one after another and passes their path points to `take`.
pub(crate) struct Sampler<T> {
    most: usize,
    segment: usize,
    count: usize,
    length_mm: f64,
    points: Vec<PathPoint>,
    take: T,
}

/// Why a motion cannot be sampled.
pub(crate) enum SampleFault {
    TooMany,
    /// The ends of an arc are within the range; what lies between need not be.
    TooFar,
}

impl<T: FnMut(&PathPoint)> Sampler<T> {
    /// Creates a sampler of at most `most` points in all.
    pub fn new(most: usize, take: T) -> Self {
        Self { most, segment: 0, count: 0, length_mm: 0.0, points: Vec::new(), take }
    }

    /// Samples the next motion: `parameters` returns the parameters of its points (0 to 1) for its index, and `sample` appends the points to a list,
    /// given index, parameters and the path length (mm) before it. Fails if the points are too many, as where `parameters` returns `None`, or too far
    /// away.
    pub fn sample_motion(
        &mut self,
        parameters: impl FnOnce(usize) -> Option<Vec<f64>>,
        sample: impl FnOnce(usize, &[f64], f64, &mut Vec<PathPoint>),
    ) -> Result<(), SampleFault> {
        let at =
            parameters(self.segment).filter(|at| self.count + at.len() <= self.most).ok_or(SampleFault::TooMany)?;
        self.points.clear();
        sample(self.segment, &at, self.length_mm, &mut self.points);
        if self.points.iter().any(|point| point.position_mm.amax() > MAX_COORDINATE_MM) {
            return Err(SampleFault::TooFar);
        }
        self.points.iter().for_each(&mut self.take);
        self.length_mm = self.points.last().map_or(self.length_mm, |point| point.arc_length_mm);
        self.count += self.points.len();
        self.segment += 1;
        Ok(())
    }
}

/// Returns the parameters of the ends of `pieces` equal pieces of a motion, from 0 to 1.
pub(crate) fn even_parameters(pieces: usize) -> Vec<f64> {
    (1..=pieces).map(|k| k as f64 / pieces as f64).collect()
}

/// Returns the index after the last point of motion `segment` in `path`, whose points begin at `first`; `None` if they are not the
/// motion's. `at` gives the motion's position at a share from 0 to 1; `has_points`: whether it is part of the path.
pub(crate) fn end_of_segment(
    path: &Toolpath,
    segment: usize,
    first: usize,
    has_points: bool,
    at: impl Fn(f64) -> Option<Vector3<f64>>,
) -> Option<usize> {
    let points = path.points();
    let of_segment = points[first..].iter().take_while(|point| point.source.segment == segment);
    let next = first + of_segment.clone().count();
    if !of_segment.clone().all(|point| at(point.source.parameter) == Some(point.position_mm)) {
        return None;
    }
    let is_complete =
        if has_points { of_segment.last().is_some_and(|last| last.source.parameter == 1.0) } else { next == first };
    is_complete.then_some(next)
}

/// Searches for the piece that passes the most points, at most `most`: doubles their number, then bisects. `best` passes one point;
/// `attempt(n)` returns a piece through the first n points, if there is one.
pub(crate) fn longest_piece<P, E>(
    mut best: P,
    most: usize,
    attempt: impl Fn(usize) -> Result<Option<P>, E>,
) -> Result<P, E> {
    let (mut passed, mut failed) = (1, most + 1);
    while failed - passed > 1 {
        let is_doubling = failed == most + 1 && passed * 2 < most;
        let count = if is_doubling { passed * 2 } else { usize::midpoint(passed, failed) };
        match attempt(count)? {
            Some(piece) => (best, passed) = (piece, count),
            None => failed = count,
        }
    }
    Ok(best)
}

/// Why corrected positions cannot be written into a program.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum RewriteError {
    /// The positions do not fit the path.
    #[error(transparent)]
    Positions(#[from] PositionsError),
    /// The tolerance is none.
    #[error("write tolerance {tolerance_mm} mm: expected a finite number, 0 or more")]
    Tolerance {
        /// The tolerance given, mm.
        tolerance_mm: f64,
    },
    /// The G-code program cannot be followed.
    #[error(transparent)]
    Gcode(#[from] GcodeError),
    /// The program of poses cannot be followed.
    #[error(transparent)]
    Robot(#[from] RobotError),
    /// The path was not sampled from this program.
    #[error("the path does not belong to program {program}: expected a path sampled from it")]
    ForeignPath {
        /// The program's name.
        program: String,
    },
    /// The tool's axis is to be corrected in a hole.
    #[error(
        "{program}:{line}: a hole of a cycle keeps its direction, and its tool's axis is to be corrected: expected a program written \
         out, --expand"
    )]
    TurnedHole {
        /// The program's name.
        program: String,
        /// The line, from 1.
        line: usize,
    },
}
