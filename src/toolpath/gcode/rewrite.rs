//! Writing a program back with moved points.

use nalgebra::Vector3;
use thiserror::Error;

use crate::toolpath::{
    NumberFormat, PositionsError, Toolpath,
    gcode::{
        Block, GcodeOptions, LengthUnit, Program,
        edit::Style,
        error::GcodeError,
        modal::MotionCode,
        motion::Geometry,
        pole::Pole,
        writer::{Targets, Writer},
    },
    number,
    path::check_positions,
};

/// Corrected positions that cannot be written into a program.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum RewriteError {
    /// The positions do not fit the path.
    #[error(transparent)]
    Positions(#[from] PositionsError),
    /// The path was not sampled from this program.
    #[error("the path does not belong to program {program}: expected a path sampled from it")]
    ForeignPath {
        /// The program's name.
        program: String,
    },
}

impl From<RewriteError> for crate::input::error::Error {
    fn from(fault: RewriteError) -> Self {
        Self::program(fault)
    }
}

/// A program written back, with what is needed to read it point by point.
#[derive(Clone, Debug)]
pub struct Rewritten {
    bytes: Vec<u8>,
    /// How many path points each motion of the written program stands for.
    pieces: Vec<usize>,
    name: String,
    options: GcodeOptions,
}

impl Rewritten {
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

    /// Reads the written program as a controller would, and gives its path with point k where point k of the
    /// original path was: the same number of points, in the same order.
    ///
    /// # Errors
    /// When the written program cannot be followed.
    pub fn read_back(&self) -> Result<Toolpath, GcodeError> {
        let program = Program::parse(self.bytes.clone(), &self.name, &self.options)?;
        program.sample(|segment, _| self.pieces.get(segment).copied())
    }
}

impl Program {
    /// The program with the points of `path` moved to `corrected_mm`, positions in the workpiece frame.
    ///
    /// `path` is what [`Program::toolpath`] gave. A motion block stays one block where one block of its kind passes
    /// all its corrected points to one unit of the last decimal of `format`; where the correction varies so that
    /// none does, it becomes a sequence of G1 blocks with one point each. Of a block that stays, only the numbers
    /// change that must, by more than half a unit of the last decimal: without correction the bytes are the same.
    ///
    /// A hole of a cycle stays one: its X, Y and Z are those of its corrected bottom and R that of its corrected beginning.
    ///
    /// Of a block that is split, the first line keeps the line number, comments, feed and all other words; M words
    /// that act at the end of a block (M0, M1, M2, M5, M9, M30, M60) go to its last line. An axis word keeps its text on the
    /// first line or the last where it leads there as it is. Later lines that rely on a
    /// motion in force get the word back. Incremental coordinates lead from where the rounded words before them
    /// have led, so that rounding does not add up.
    ///
    /// In Heidenhain's dialect the sequence is of L blocks; if they are numbered, all that follow are counted on. A CC moves with
    /// the first arc about it.
    ///
    /// # Errors
    /// When there is not one finite position for every point, or `path` is from another program.
    pub fn rewrite(
        &self,
        path: &Toolpath,
        corrected_mm: &[Vector3<f64>],
        format: NumberFormat,
    ) -> Result<Rewritten, RewriteError> {
        check_positions(path, corrected_mm)?;
        let groups = self.group(path)?;
        let mut writer = Writer::new(self, format);
        let arcs = self.arcs_about_poles();
        let moved_with = |block: &Block, pole: &Pole| {
            let arc = arcs[arcs.partition_point(|arc| *arc < block.motions.start)..].first();
            let group = arc.filter(|arc| pole.is_of(&self.motions[**arc])).map(|arc| groups[*arc]);
            let last = group.and_then(|(first, last)| (first..last).next_back());
            last.map_or_else(Vector3::zeros, |last| corrected_mm[last] - path.points()[last].position_mm)
        };
        let mut blocks = self.blocks.iter().peekable();
        for index in 0..self.lines.len() {
            match blocks.next_if(|block| block.line == index) {
                Some(block) => match self.motions[block.motions.clone()].first().map(|motion| motion.code) {
                    Some(code) => {
                        let targets = groups[block.motions.clone()].iter().map(|&(first, last)| Targets {
                            points: &path.points()[first..last],
                            corrected: &corrected_mm[first..last],
                        });
                        let motions = &self.motions[block.motions.clone()];
                        match code {
                            MotionCode::Cycle(_) => writer.holes(block, motions, &targets.collect::<Vec<_>>()),
                            _ => motions
                                .iter()
                                .zip(targets)
                                .for_each(|(motion, targets)| writer.motion(block, motion, targets)),
                        }
                    }
                    None => {
                        match &block.origin_at {
                            Some(origin_at) => writer.origin(block, origin_at),
                            None => match &block.pole {
                                Some(pole) => writer.pole(block, pole, moved_with(block, pole)),
                                None => writer.copy(index),
                            },
                        }
                        writer.motion_word = block.motion_word.or(writer.motion_word);
                    }
                },
                None => writer.copy(index),
            }
        }
        Ok(Rewritten {
            bytes: self.dialect.numbered(&self.source, writer.out),
            pieces: writer.pieces,
            name: self.name.clone(),
            options: self.options.clone(),
        })
    }

    /// The range of points of each motion, after checking that they are its points.
    fn group(&self, path: &Toolpath) -> Result<Vec<(usize, usize)>, RewriteError> {
        let foreign = || RewriteError::ForeignPath { program: self.name.clone() };
        let points = path.points();
        let mut next = 0;
        let mut groups = Vec::with_capacity(self.motions.len());
        for (segment, motion) in self.motions.iter().enumerate() {
            let first = next;
            while points.get(next).is_some_and(|point| point.source.segment == segment) {
                let here = motion.geometry.at(points[next].source.parameter);
                if here.map(|(position, _)| position) != Some(points[next].position_mm) {
                    return Err(foreign());
                }
                next += 1;
            }
            let complete = match motion.geometry {
                Geometry::Unlocated => next == first,
                _ => next > first && points[next - 1].source.parameter == 1.0,
            };
            if !complete {
                return Err(foreign());
            }
            groups.push((first, next));
        }
        if next == points.len() { Ok(groups) } else { Err(foreign()) }
    }

    /// The decimals of its coordinates.
    pub(super) fn decimals_seen(&self) -> NumberFormat {
        let (mut mm, mut inch) = (0, 0);
        for block in &self.blocks {
            let Some(motion) = self.motions[block.motions.clone()].first() else {
                continue;
            };
            let content = self.content(block.line);
            let seen = match motion.modal.unit {
                LengthUnit::Millimetre => &mut mm,
                LengthUnit::Inch => &mut inch,
            };
            for word in motion.words.iter().filter(|word| matches!(word.letter, 'X' | 'Y' | 'Z' | 'R')) {
                let text = String::from_utf8_lossy(&content[word.number()]);
                *seen = number::decimals_in(&text).max(*seen);
            }
        }
        NumberFormat::seen(mm, inch)
    }

    /// How this program's author writes words.
    pub(super) fn style(&self) -> Style {
        self.blocks
            .iter()
            .rev()
            .filter_map(|block| Some((block, self.motions[block.motions.clone()].first()?)))
            .fold(Style::plain(self.dialect), |style, (block, motion)| {
                style.on_line(self.content(block.line), &motion.words)
            })
    }
}
