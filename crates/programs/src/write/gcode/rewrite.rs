//! Writes a G-code program back with its path points moved to corrected positions.

use std::{borrow::Cow, collections::BTreeSet, ops::Range};

use nalgebra::Vector3;

use crate::{
    model::{
        MotionGeometry, Orientation, PathPoint, RewriteError, Rewritten, Toolpath, check_corrected, end_of_segment,
        gcode::{Angles, Coordinates, Dialect, Motion, MotionCode, Rotary, RotaryMotion, WriteOptions},
    },
    read::gcode::{GcodeProgram, lines::Lines},
    write::gcode::{Calls, Targets, Writer},
};

/// A path and the corrected positions and orientations of its points.
#[derive(Clone, Copy)]
struct MovedPath<'a> {
    path: &'a Toolpath,
    positions: &'a [Vector3<f64>],
    orientations: Option<&'a [Orientation]>,
}

impl MovedPath<'_> {
    /// Returns the corrected rotary angles at the `points` of `motion`, degrees; `None` if the axes neither turn nor are corrected.
    fn angles(&self, motion: &Motion, points: Range<usize>, rotary: &Rotary) -> Option<Vec<Angles>> {
        // In an inclined plane the tool stands along its z.
        let is_inclined = matches!(motion.turning.coordinates, Coordinates::Inclined(_));
        if (self.orientations.is_none() || is_inclined) && !motion.turning.turns() {
            return None;
        }
        let angles = |k: usize| {
            let programmed = motion.turning.at(self.path.points()[k].source.parameter);
            let orientation = self.orientations.map(|orientations| orientations[k]);
            let Some(Orientation::ToolAxis(axis)) = orientation else { return programmed };
            let corrected = rotary.angles_for(&axis, &programmed);
            // Where the tip would go with an axis that is nowhere, it keeps its angle.
            let is_unlocated =
                motion.turning.coordinates == Coordinates::Head && rotary.first_unlocated_axis(&corrected).is_some();
            if is_unlocated { programmed } else { corrected }
        };
        Some(points.map(angles).collect())
    }
}

impl GcodeProgram {
    /// Rewrites the program with the points of `path` moved to `corrected_mm`, positions in the workpiece frame.
    ///
    /// `path` is what [`GcodeProgram::toolpath`] gave. A motion block stays one block where one block of its kind passes all its corrected points to
    /// one unit of the last decimal, or within the tolerance; where the correction varies so that none does, it becomes a sequence of blocks, each
    /// of which passes as many points within the tolerance as it can: arcs of the same plane and turn, with the words for centres that the block
    /// has, where an arc does, lines otherwise. Blocks end at corrected points, to half a unit of the last decimal. Of a block that stays, only
    /// the numbers change that must, by more than half a unit of the last decimal: without correction the bytes are the same.
    ///
    /// A hole of a cycle stays one: its X, Y and Z are those of its corrected bottom and R that of its corrected beginning.
    ///
    /// Of a block that is split, the first line keeps the line number, comments, feed and all other words; M words that act at the end of a
    /// block (M0, M1, M2, M5, M9, M17, M30, M60, M99) and G9 go to its last line, and rotary axes are shared out. A word that may be another axis (E, U, V,
    /// W) is refused there. An axis word keeps its text on the first line or the last where it leads
    /// there as it is. Later lines that rely on a motion in force get the word back. Incremental coordinates lead from where the rounded
    /// words before them have led, so that rounding does not add up.
    ///
    /// In Heidenhain's dialect the sequence is of L blocks; if numbered, all that follow are counted on. A CC moves with its first arc.
    ///
    /// # Errors
    /// When there is not one finite position for every point, `path` is from another program, or the tolerance is none.
    pub fn rewrite(
        &self,
        path: &Toolpath,
        corrected_mm: &[Vector3<f64>],
        writing: WriteOptions,
    ) -> Result<Rewritten<GcodeProgram>, RewriteError> {
        self.rewrite_turned(path, corrected_mm, None, writing)
    }

    /// Rewrites the program like [`GcodeProgram::rewrite`], with the tool axis turned to `orientations` as well, if they are given: by the rotary
    /// axes of the options, by the least rotations from the programmed angles, near a pole as far as a few degrees can. Fails like
    /// [`GcodeProgram::rewrite`], and where a hole of a cycle would have to be turned.
    pub fn rewrite_turned(
        &self,
        path: &Toolpath,
        corrected_mm: &[Vector3<f64>],
        orientations: Option<&[Orientation]>,
        writing: WriteOptions,
    ) -> Result<Rewritten<GcodeProgram>, RewriteError> {
        check_corrected(path, corrected_mm, orientations)?;
        let orientations = orientations.filter(|_| !self.options.rotary.is_empty());
        let writing = writing.checked()?;
        let corrected_mm = &*self.even_out_corrections(path, corrected_mm, writing.format);
        let corrected = MovedPath { path, positions: corrected_mm, orientations };
        let rewritten = self.rewrite_with(corrected, writing, &BTreeSet::new())?;
        if !matches!(self.folded_calls(&rewritten), Some(Calls::WrittenOut(_))) {
            return Ok(rewritten);
        }
        // What comes from several places needs words that it does not need coming from one.
        let with_full_lines = self.rewrite_with(corrected, writing, &self.lines_corrected_alike(path, corrected_mm))?;
        let stays = matches!(self.folded_calls(&with_full_lines), Some(Calls::Stay { .. }));
        Ok(if stays { with_full_lines } else { rewritten })
    }

    /// Rewrites the program in one pass; moves on the lines `full_lines` (from 1) get a word for every axis.
    fn rewrite_with(
        &self,
        corrected @ MovedPath { path, positions: corrected_mm, .. }: MovedPath<'_>,
        writing: WriteOptions,
        full_lines: &BTreeSet<usize>,
    ) -> Result<Rewritten<GcodeProgram>, RewriteError> {
        let foreign = || RewriteError::ForeignPath { program: self.name.clone() };
        let mut writer = Writer::new(self, writing, full_lines);
        let (mut segment, mut next, mut line) = (0, 0, 0);
        let mut pole_arcs = self.pole_arcs.iter();
        // Of the coordinates of the line that sets the centre.
        let correction_of_arc = |arc: Option<usize>, turning: &RotaryMotion| {
            let next_point = arc.map(|arc| path.points().partition_point(|point| point.source.segment <= arc));
            let last = next_point
                .and_then(|next_point| next_point.checked_sub(1))
                .filter(|last| Some(path.points()[*last].source.segment) == arc);
            last.map_or_else(Vector3::zeros, |last| {
                let rotary = &self.options.rotary;
                let [from, to] = [path.points()[last].position_mm, corrected_mm[last]]
                    .map(|place| rotary.programmed_position(turning.coordinates, place, &turning.to));
                to - from
            })
        };
        self.walk(|block| {
            (line..block.line).for_each(|index| writer.copy_line(index));
            line = block.line + 1;
            let mut motion_targets = Vec::with_capacity(block.motions.len());
            for motion in &block.motions {
                let has_points = motion.geometry != MotionGeometry::Unlocated;
                let at = |t: f64| motion.at(t, &self.options.rotary).map(|(position, _)| position);
                let points = next..end_of_segment(path, segment, next, has_points, at).ok_or_else(foreign)?;
                let angles = corrected.angles(motion, points.clone(), &self.options.rotary);
                let turns = |angles: &Vec<Angles>| angles.iter().any(|angles| *angles != motion.turning.to);
                if matches!(motion.code, MotionCode::Cycle(_)) && angles.as_ref().is_some_and(turns) {
                    return Err(RewriteError::TurnedHole { program: self.name.clone(), line: motion.line });
                }
                let (points_of, positions) = (&path.points()[points.clone()], &corrected_mm[points.clone()]);
                let (programmed, goals) = self.coordinates(motion, points_of, positions, angles.as_deref());
                motion_targets.push((programmed, goals, angles));
                (segment, next) = (segment + 1, points.end);
            }
            let targets: Vec<Targets> = motion_targets
                .iter()
                .map(|(points, corrected, angles)| Targets { points, corrected, angles: angles.as_deref() })
                .collect();
            match (block.motions.first().map(|motion| motion.code), &block.zero_setting) {
                (Some(MotionCode::Cycle(_)), _) => writer.write_holes(block, &block.motions, &targets),
                (Some(_), _) => {
                    let motions = block.motions.iter().zip(targets);
                    motions.for_each(|(motion, targets)| writer.write_motion(block, motion, targets));
                }
                (None, zero_setting) => {
                    match (zero_setting, &block.pole) {
                        (Some(zero_setting), _) => writer.write_origin(block, zero_setting),
                        (None, Some(pole)) => {
                            let arc = pole_arcs.next().copied().flatten();
                            writer.write_pole(block, pole, correction_of_arc(arc, &pole.turning));
                        }
                        (None, None) => writer.copy_block(block),
                    }
                    block.motion_word.into_iter().for_each(|code| writer.set_motion(code));
                }
            }
            writer.record_line_end();
            Ok::<(), RewriteError>(())
        })?;
        if let Some((line, refusal)) = writer.refused {
            return Err(self.refused(line, refusal).into());
        }
        (line..self.lines.len()).for_each(|index| writer.copy_line(index));
        if next != path.len() {
            return Err(foreign());
        }
        Ok(Rewritten {
            bytes: self.renumbered(writer.out, &mut writer.line_ends),
            pieces: writer.pieces,
            parameters: writer.parameters,
            line_ends: writer.line_ends,
            reading: (self.name.clone(), self.options.clone()),
        })
    }

    /// Returns what is `written` with its blocks counted on, where they are numbered; `line_ends` move with it.
    fn renumbered(&self, written: Vec<u8>, line_ends: &mut [usize]) -> Vec<u8> {
        let before = (self.dialect == Dialect::Heidenhain).then(|| Lines::split(&written));
        let bytes = self.dialect.renumbered(&self.source, written);
        if let Some(before) = before {
            let (after, mut lines) = (Lines::split(&bytes), 0usize);
            for end in line_ends {
                while lines < before.len() && before.ending(lines).end <= *end {
                    lines += 1;
                }
                *end = lines.checked_sub(1).map_or(0, |last| after.ending(last).end);
            }
        }
        bytes
    }

    /// Converts the points of a motion and their corrected positions to the coordinates (mm) of its words.
    fn coordinates<'a>(
        &self,
        motion: &Motion,
        points: &'a [PathPoint],
        corrected_mm: &'a [Vector3<f64>],
        angles: Option<&[Angles]>,
    ) -> (Cow<'a, [PathPoint]>, Cow<'a, [Vector3<f64>]>) {
        let is_turned = |angles: &[Angles]| angles.iter().any(|angles| *angles != [0.0; 3]);
        let coordinates = motion.turning.coordinates;
        let displaces_tip =
            motion.turning.displaces_tip() || (coordinates == Coordinates::Head && angles.is_some_and(is_turned));
        if !displaces_tip {
            return (points.into(), corrected_mm.into());
        }
        let place = |k: usize| {
            let programmed = || motion.turning.at(points[k].source.parameter);
            let angles = angles.map_or_else(programmed, |angles| angles[k]);
            self.options.rotary.programmed_position(coordinates, corrected_mm[k], &angles)
        };
        let programmed = points.iter().map(|point| PathPoint {
            position_mm: motion.geometry.at(point.source.parameter).map_or(point.position_mm, |(at, _)| at),
            ..*point
        });
        (programmed.collect(), (0..points.len()).map(place).collect())
    }
}
