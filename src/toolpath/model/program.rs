//! What programs of all formats have in common: their points one after another, and how what is written is read point by point.

use std::fmt;

use nalgebra::Vector3;
use thiserror::Error;

use crate::toolpath::model::{
    MAX_COORDINATE_MM, Orientation, PathPoint, PositionsError, Toolpath, gcode::GcodeError, robot::RobotError,
};

/// A program as its format has it, which is read, followed and written back.
pub trait Program: Sized {
    /// What is wrong with one that cannot be followed.
    type Error;
    /// What reading takes besides the bytes.
    type Reading: Clone + fmt::Debug;

    /// Reads what was written.
    ///
    /// # Errors
    /// When it cannot be followed.
    fn read_written(bytes: Vec<u8>, reading: &Self::Reading) -> Result<Self, Self::Error>;

    /// Gives the points of its path to `take`, those of each motion where `places` has them of its index, from 0 to 1; a tangent that is
    /// not known is zero.
    ///
    /// # Errors
    /// When `places` has none, or more than a path may have in all.
    fn points_at(
        &self,
        places: impl FnMut(usize) -> Option<Vec<f64>>,
        take: impl FnMut(&PathPoint),
    ) -> Result<(), Self::Error>;

    /// Names of the external axes that its path commands.
    fn external_axes(&self) -> Vec<String>;
}

/// A program written back, with what is needed to read it point by point.
#[derive(Clone, Debug)]
pub struct Rewritten<P: Program> {
    pub(crate) bytes: Vec<u8>,
    /// How many path points each motion of the written program stands for.
    pub(crate) pieces: Vec<usize>,
    /// Where on its motion each of them lies, from 0 to 1.
    pub(crate) places: Vec<f64>,
    /// Where the bytes end that each line of a program written out has become.
    pub(crate) line_ends: Vec<usize>,
    pub(crate) reading: P::Reading,
}

impl<P: Program> Rewritten<P> {
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

    /// The written program, read as a controller would; it takes the bytes along, so that there is one copy of them.
    ///
    /// # Errors
    /// When it cannot be followed.
    pub(crate) fn take_and_read(&mut self) -> Result<P, P::Error> {
        P::read_written(std::mem::take(&mut self.bytes), &self.reading)
    }

    /// The written program, read as a controller would.
    ///
    /// # Errors
    /// When it cannot be followed.
    pub fn read(&self) -> Result<P, P::Error> {
        P::read_written(self.bytes.clone(), &self.reading)
    }

    /// The path of the written program, point k where point k of the original path is passed: the same number of points, in
    /// the same order.
    ///
    /// # Errors
    /// When the written program cannot be followed.
    pub fn read_back(&self) -> Result<Toolpath, P::Error> {
        let written = self.read()?;
        let points = self.each(&written, |point| *point)?;
        Ok(Toolpath::assemble(points).with_external_axes(&written.external_axes()))
    }

    /// As [`Rewritten::read_back`], of the written program once it has been read, the positions alone (workpiece frame, mm).
    ///
    /// # Errors
    /// When it is another program.
    pub fn positions_of(&self, written: &P) -> Result<Vec<Vector3<f64>>, P::Error> {
        self.each(written, |point| point.position_mm)
    }

    /// As [`Rewritten::positions_of`], how the tool stands; `None` where the program does not say it.
    ///
    /// # Errors
    /// When it is another program.
    pub fn orientations_of(&self, written: &P) -> Result<Vec<Option<Orientation>>, P::Error> {
        self.each(written, |point| point.orientation)
    }

    fn each<T>(&self, written: &P, of: impl Fn(&PathPoint) -> T) -> Result<Vec<T>, P::Error> {
        let mut found = Vec::with_capacity(self.places.len());
        self.each_of(written, |point| found.push(of(point)))?;
        Ok(found)
    }

    /// The same, point after point, given to `take`.
    ///
    /// # Errors
    /// When it is another program.
    pub(crate) fn each_of(&self, written: &P, take: impl FnMut(&PathPoint)) -> Result<(), P::Error> {
        let mut places = self.places.as_slice();
        let own = |motion: usize| {
            let (own, rest) = places.split_at_checked(*self.pieces.get(motion)?)?;
            places = rest;
            Some(own.to_vec())
        };
        written.points_at(own, take)
    }
}

/// Takes motions one after another and gives their points to `take`.
pub(crate) struct Sampler<T> {
    most: usize,
    segment: usize,
    count: usize,
    length_mm: f64,
    points: Vec<PathPoint>,
    take: T,
}

/// Why a motion has no points.
pub(crate) enum NoPoints {
    TooMany,
    /// The ends of an arc are within the range; what lies between need not be.
    TooFar,
}

impl<T: FnMut(&PathPoint)> Sampler<T> {
    /// For `most` points.
    pub fn new(most: usize, take: T) -> Self {
        Self { most, segment: 0, count: 0, length_mm: 0.0, points: Vec::new(), take }
    }

    /// Takes the next motion: `places` has where on it its points lie of its index, and `sample` adds them to a list, given index,
    /// places, and length of the path before it.
    pub fn motion(
        &mut self,
        places: impl FnOnce(usize) -> Option<Vec<f64>>,
        sample: impl FnOnce(usize, &[f64], f64, &mut Vec<PathPoint>),
    ) -> Result<(), NoPoints> {
        let own = places(self.segment).filter(|own| self.count + own.len() <= self.most).ok_or(NoPoints::TooMany)?;
        self.points.clear();
        sample(self.segment, &own, self.length_mm, &mut self.points);
        if self.points.iter().any(|point| point.position_mm.amax() > MAX_COORDINATE_MM) {
            return Err(NoPoints::TooFar);
        }
        self.points.iter().for_each(&mut self.take);
        self.length_mm = self.points.last().map_or(self.length_mm, |point| point.arc_length_mm);
        self.count += self.points.len();
        self.segment += 1;
        Ok(())
    }
}

/// The places of the ends of equal pieces of a motion, from 0 to 1.
pub(crate) fn even_places(pieces: usize) -> Vec<f64> {
    (1..=pieces).map(|k| k as f64 / pieces as f64).collect()
}

/// Where the points end that motion `segment` has in `path` from `first` on; `None` if they are not its. `at`: where it is at a share of
/// its way; `has_points`: whether it is anywhere.
pub(crate) fn end_of(
    path: &Toolpath,
    segment: usize,
    first: usize,
    has_points: bool,
    at: impl Fn(f64) -> Option<Vector3<f64>>,
) -> Option<usize> {
    let points = path.points();
    let own = points[first..].iter().take_while(|point| point.source.segment == segment);
    let next = first + own.clone().count();
    if !own.clone().all(|point| at(point.source.parameter) == Some(point.position_mm)) {
        return None;
    }
    let is_complete =
        if has_points { own.last().is_some_and(|last| last.source.parameter == 1.0) } else { next == first };
    is_complete.then_some(next)
}

/// The most of `most` points that one piece passes, sought in steps that double, then between the last two; `best` passes the first.
pub(crate) fn longest<P, E>(mut best: P, most: usize, attempt: impl Fn(usize) -> Result<Option<P>, E>) -> Result<P, E> {
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

/// Corrected positions that cannot be written into a program.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum RewriteError {
    /// The positions do not fit the path.
    #[error(transparent)]
    Positions(#[from] PositionsError),
    /// The tolerance is none.
    #[error("write tolerance {tolerance_mm} mm: expected a finite number, 0 or more")]
    Tolerance {
        /// What was given, mm.
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
