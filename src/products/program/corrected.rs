//! Corrects the commanded path, writes the program that follows it, and reads it back.

use std::borrow::Cow;

use nalgebra::Vector3;

use super::{Part, ProgramJob, part::arm_posture};
use crate::{
    input::error::Result,
    machine::ExternalAxes,
    simulation::{along_path::PathPointResult, tasks::PoseTracker},
    spatial::Pose,
    toolpath::{
        CommandedPath, PathPoint, ProgramFile, RewrittenFile, Toolpath,
        blocks::BlocksBeforeAfter,
        gcode::{CalledFile, Calls},
        robot::ArmPosture,
    },
};

/// The corrected path of the tool, collected point by point.
#[derive(Debug, Clone)]
pub struct CorrectedPath {
    /// Corrected positions and orientations; those of the program where there is no command.
    sent: CommandedPath,
    /// Cutting points without a command: index and reason.
    pub failures: Vec<(usize, String)>,
    /// Number of non-cutting points (rapid moves) that have no correction and keep their position.
    pub uncorrected: usize,
    /// How the arm stands at each point; nothing where the program does not say it.
    postures: Vec<Option<ArmPosture>>,
}

impl CorrectedPath {
    /// Creates an empty corrected path for `job`.
    pub fn new(job: &ProgramJob) -> Self {
        let sent = CommandedPath::new(job.path.len(), job.is_full_pose());
        Self { sent, failures: Vec::new(), uncorrected: 0, postures: Vec::new() }
    }

    /// Returns the number of points added so far.
    pub fn point_count(&self) -> usize {
        self.sent.positions.len()
    }

    /// Adds the corrected points of the next `part`, with their `results`; a cutting point without a command is noted as a failure.
    pub fn add(&mut self, job: &ProgramJob, part: &Part<'_>, results: &[PathPointResult]) {
        let mut track = job.tracker();
        for ((point, task), result) in part.points.iter().zip(part.tasks()).zip(results) {
            let k = self.point_count();
            let target = result.target.filter(|_| result.status.is_success());
            let commanded = target.map(|pose| job.commanded_point(&mut track, point, task.external, pose));
            match commanded {
                Some(_) => {}
                None if point.cutting => self.failures.push((k, result.status.reason(&job.machine))),
                None => self.uncorrected += 1,
            }
            let sent = commanded.unwrap_or(*point);
            self.sent.positions.push(sent.position_mm);
            self.sent.orientations.iter_mut().for_each(|own| own.extend(sent.orientation));
            if job.file.says_postures() {
                self.postures.push(commanded.and_then(|_| arm_posture(&job.machine, &result.drives)));
            }
        }
    }
}

/// The compensated program as text, and the path read back from it.
#[derive(Debug, Clone)]
pub struct ProgramAsWritten {
    /// The program's text.
    pub bytes: Vec<u8>,
    /// Path of the tool, read back from the text.
    pub sent: CommandedPath,
    /// Largest distance by which writing has moved a position, mm.
    pub rounded_mm: f64,
    /// The same on the way into and out of holes of drilling cycles, which all get the correction of the bottom; `None` without such holes.
    pub in_holes_mm: Option<f64>,
    /// What the blocks of a G-code program demand of a control, before and as written.
    pub blocks: Option<BlocksBeforeAfter>,
    /// What becomes of its subprogram calls.
    pub calls: WrittenCalls,
}

impl ProgramJob {
    /// Returns the path point (workpiece frame) that commands the platform pose `target` in place of `point`. Coordinates that the drives
    /// do not control keep the program's values, and so does the orientation if it is not compensated.
    pub(super) fn commanded_point(
        &self,
        track: &mut PoseTracker<'_>,
        point: &PathPoint,
        external: Option<ExternalAxes>,
        target: Pose,
    ) -> PathPoint {
        let placed = track.placed(external);
        let workpiece = placed.workpiece();
        let given = workpiece.transform(point.position_mm);
        let mut position = target.transform(placed.reference());
        for axis in self.machine.uncontrolled_axes() {
            position[axis] = given[axis];
        }
        let given = point.orientation.filter(|_| self.is_full_pose());
        PathPoint {
            position_mm: workpiece.inverse().transform(position),
            orientation: given.map(|given| placed.tool_orientation_at(&target.rotation, &given)).or(point.orientation),
            ..*point
        }
    }

    /// Returns the measured position at each point of the path (workpiece frame, mm) from `measured`: one position per point, or one per row
    /// of a polyline file, between which the deviation is interpolated.
    ///
    /// # Errors
    /// The number of positions is neither that of the points nor that of the rows; the message is in words.
    pub fn measured_points(&self, measured: Vec<Vector3<f64>>) -> std::result::Result<Vec<Vector3<f64>>, String> {
        let points = self.path.len();
        let nominal = match &self.file {
            _ if measured.len() == points => return Ok(measured),
            ProgramFile::Polyline(polyline) => polyline.toolpath().positions_mm(),
            _ => return Err(count_problem(measured.len(), points, points)),
        };
        if measured.len() != nominal.len() {
            return Err(count_problem(measured.len(), points, nominal.len()));
        }
        let deviation = |row: usize| measured[row] - nominal[row];
        let measured_at = |point: &PathPoint| {
            let row = point.source.segment;
            point.position_mm + deviation(row.saturating_sub(1)).lerp(&deviation(row), point.source.parameter)
        };
        Ok(self.path.points().iter().map(measured_at).collect())
    }

    /// Returns the path whose positions (workpiece frame, mm) mirror the `measured` ones at the wanted path, one per point, Figure 2.
    pub fn mirrored_path(&self, measured: &[Vector3<f64>]) -> CommandedPath {
        let mirrored = self.path.points().iter().zip(measured).map(|(point, found)| point.position_mm * 2.0 - found);
        CommandedPath { positions: mirrored.collect(), orientations: None }
    }

    /// Writes the program that follows `corrected`, reads it back, and returns both with the largest distance between them.
    ///
    /// # Errors
    /// The program cannot be rewritten.
    pub fn write(&self, corrected: &CorrectedPath) -> Result<ProgramAsWritten> {
        let wanted = &corrected.sent;
        let path = match corrected.postures.is_empty() {
            true => Cow::Borrowed(&*self.path),
            false => Cow::Owned(Toolpath::clone(&self.path).with_postures(corrected.postures.clone())),
        };
        let writing = self.process.write_options(self.file.own_format())?;
        let RewrittenFile { bytes, sent, blocks, calls } =
            self.file.rewrite(&path, &wanted.positions, wanted.orientations.as_deref(), writing)?;
        let (mut rounded_mm, mut in_holes_mm) = (0.0, None);
        let positions = wanted.positions.iter().zip(&sent.positions);
        for (point, (wanted, written)) in self.path.points().iter().zip(positions) {
            let moved = (written - wanted).norm();
            rounded_mm = f64::max(rounded_mm, moved);
            if self.file.is_hole(point.source.segment) {
                in_holes_mm = Some(in_holes_mm.map_or(moved, |most| f64::max(most, moved)));
            }
        }
        let (bytes, calls) = match calls {
            None => (bytes, WrittenCalls::None),
            Some(Calls::WrittenOut(differs)) => (bytes, WrittenCalls::WrittenOut { because: differs.to_string() }),
            Some(Calls::Stay { program, beside }) => (program, WrittenCalls::Stay { beside, written_out: bytes }),
        };
        if let ProgramFile::Gcode(program) = &self.file
            && ![program.source(), program.file_bytes()].contains(&&bytes[..])
        {
            super::check_unit(&self.file, "the program")?;
        }
        Ok(ProgramAsWritten { bytes, sent, rounded_mm, in_holes_mm, blocks, calls })
    }
}

/// Returns the message for `found` measured positions where a path has `points` points from `rows` rows.
fn count_problem(found: usize, points: usize, rows: usize) -> String {
    match points == rows {
        true => format!("has {found} positions, but the path has {points} points: expected one for each"),
        false => format!(
            "has {found} positions, but the path has {rows} rows, split into {points} points: expected one for each row, or \
             for each point"
        ),
    }
}

/// What became of the calls, loops and jumps of a program.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum WrittenCalls {
    /// The program has none, or the user asked to write it out.
    None,
    /// The calls stay in the program.
    Stay {
        /// The called files beside it, with their new contents.
        beside: Vec<CalledFile>,
        /// The program without calls, in case they cannot stay.
        written_out: Vec<u8>,
    },
    /// The program is written out, without calls.
    WrittenOut {
        /// Why, in words.
        because: String,
    },
}

impl ProgramAsWritten {
    /// Writes the program out unless `may` accepts every called file; the error of `may` becomes the reason.
    pub fn keep_calls_only_if(&mut self, may: impl Fn(&CalledFile) -> Result<()>) {
        let WrittenCalls::Stay { beside, written_out } = &mut self.calls else { return };
        if let Some(error) = beside.iter().find_map(|file| may(file).err()) {
            self.bytes = std::mem::take(written_out);
            self.calls =
                WrittenCalls::WrittenOut { because: format!("what it calls cannot be written beside it: {error}") };
        }
    }

    /// Returns the files that the program calls beside it, with their new contents.
    pub fn callees(&self) -> &[CalledFile] {
        match &self.calls {
            WrittenCalls::Stay { beside, .. } => beside,
            _ => &[],
        }
    }
}
