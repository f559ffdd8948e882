//! Where the tool is sent instead, and the program that sends it there: written, and read back.

use nalgebra::Vector3;

use super::{Part, ProgramJob};
use crate::{
    input::error::Result,
    machine::ExternalAxes,
    simulation::{
        ProgramFile,
        along_path::PathAnswer,
        blocks::BlocksBeforeAfter,
        program_file::{Rewritten, Sent},
        tasks::Tracked,
    },
    spatial::Pose,
    toolpath::{
        PathPoint,
        gcode::{CalledFile, Calls},
    },
};

/// Where the tool is sent, gathered point after point.
#[derive(Debug, Clone)]
pub struct Corrected {
    /// As in the path where there is no command.
    sent: Sent,
    /// Points at which the tool cuts but that have no command: index and reason.
    pub failures: Vec<(usize, String)>,
    /// Points not cut at (rapid moves) that could not be compensated and are left as they were.
    pub left_alone: usize,
}

impl Corrected {
    /// For `job`, none of its points seen.
    pub fn new(job: &ProgramJob) -> Self {
        Self { sent: Sent::new(job.path.len(), job.turns_tool()), failures: Vec::new(), left_alone: 0 }
    }

    /// Points seen.
    pub fn seen(&self) -> usize {
        self.sent.positions.len()
    }

    /// Takes the next part of the pass that is to be written.
    pub fn add(&mut self, job: &ProgramJob, part: &Part<'_>, answers: &[PathAnswer]) {
        let mut track = job.track();
        for ((point, task), answer) in part.points.iter().zip(part.tasks()).zip(answers) {
            let k = self.seen();
            let target = answer.target.filter(|_| answer.status.is_success());
            let commanded = target.map(|pose| job.commanded(&mut track, point, task.external, pose));
            match commanded {
                Some(_) => {}
                None if point.cutting => self.failures.push((k, answer.status.reason(&job.machine))),
                None => self.left_alone += 1,
            }
            self.sent.add(&commanded.unwrap_or(*point));
        }
    }
}

/// The compensated program.
#[derive(Debug, Clone)]
pub struct Written {
    /// The program's text.
    pub bytes: Vec<u8>,
    /// Where it sends the tool, read back from the text.
    pub sent: Sent,
    /// The farthest that writing has moved a position, mm.
    pub rounded_mm: f64,
    /// The same for the ways in and out of holes of cycles, which all have the correction of the bottom; `None` if there are
    /// no such holes.
    pub in_holes_mm: Option<f64>,
    /// What the blocks of a G-code program ask of a control, before and as written.
    pub blocks: Option<BlocksBeforeAfter>,
    /// What becomes of its calls.
    pub calls: WrittenCalls,
}

impl ProgramJob {
    /// The point of the path that commands `target` in place of `point`. Along axes that are not controlled its position is that of the
    /// program, and so is its orientation if that is not corrected.
    pub(super) fn commanded(
        &self,
        track: &mut Tracked<'_>,
        point: &PathPoint,
        external: Option<ExternalAxes>,
        target: Pose,
    ) -> PathPoint {
        let placed = track.placed(external);
        let workpiece = placed.workpiece();
        let own = workpiece.transform(point.position_mm);
        let mut position = target.transform(placed.reference());
        for axis in self.machine.uncontrolled_axes() {
            position[axis] = own[axis];
        }
        let own = point.orientation.filter(|_| self.turns_tool());
        PathPoint {
            position_mm: workpiece.inverse().transform(position),
            orientation: own.map(|own| placed.orientation_of(&target.rotation, &own)).or(point.orientation),
            ..*point
        }
    }

    /// Where the tool went at each point of the path from where it went in a pass, `measured` (workpiece frame, mm): one
    /// position per point of the path, or per row of a polyline file, between which the deviation is interpolated.
    ///
    /// # Errors
    /// Neither as many positions as points nor as rows; in words.
    pub fn measured(&self, measured: Vec<Vector3<f64>>) -> std::result::Result<Vec<Vector3<f64>>, String> {
        let points = self.path.len();
        let nominal = match &self.file {
            _ if measured.len() == points => return Ok(measured),
            ProgramFile::Polyline(polyline) => polyline.toolpath().positions_mm(),
            _ => return Err(counts(measured.len(), points, points)),
        };
        if measured.len() != nominal.len() {
            return Err(counts(measured.len(), points, nominal.len()));
        }
        let deviation = |row: usize| measured[row] - nominal[row];
        let went = |point: &PathPoint| {
            let row = point.source.segment;
            point.position_mm + deviation(row.saturating_sub(1)).lerp(&deviation(row), point.source.parameter)
        };
        Ok(self.path.points().iter().map(went).collect())
    }

    /// Positions that mirror a measured pass at the wanted path, Figure 2. `measured`: where the tool went, workpiece
    /// frame, mm, one position per point of the path.
    pub fn mirrored(&self, measured: &[Vector3<f64>]) -> Sent {
        let mirrored = self.path.points().iter().zip(measured).map(|(point, went)| point.position_mm * 2.0 - went);
        Sent { positions: mirrored.collect(), orientations: None }
    }

    /// Writes the program that sends the tool where `corrected` says, and reads it back.
    ///
    /// # Errors
    /// The program cannot be rewritten.
    pub fn write(&self, corrected: &Corrected) -> Result<Written> {
        let wanted = &corrected.sent;
        let Rewritten { bytes, back, blocks, calls } =
            self.file.rewritten(&self.path, &wanted.positions, wanted.orientations.as_deref(), &self.process)?;
        let (mut rounded_mm, mut in_holes_mm) = (0.0, None);
        let positions = wanted.positions.iter().zip(&back.positions);
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
        Ok(Written { bytes, sent: back, rounded_mm, in_holes_mm, blocks, calls })
    }
}

fn counts(found: usize, points: usize, rows: usize) -> String {
    match points == rows {
        true => format!("has {found} positions, but the path has {points} points: expected one for each"),
        false => format!(
            "has {found} positions, but the path has {rows} rows, split into {points} points: expected one for each row, or \
             for each point"
        ),
    }
}

/// What becomes of the calls, loops and jumps of a program.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum WrittenCalls {
    /// It has none, or it was to be written out.
    None,
    /// They stay.
    Stay {
        /// The files that it calls beside it, as they are to be.
        beside: Vec<CalledFile>,
        /// The program if they did not.
        written_out: Vec<u8>,
    },
    /// The program is written out.
    WrittenOut {
        /// Why, in words.
        because: String,
    },
}

impl Written {
    /// Writes the program out after all unless every file that it calls beside it may be there as it is to be, as `may` says: an error
    /// tells why not.
    pub fn call_beside_only_if(&mut self, may: impl Fn(&CalledFile) -> Result<()>) {
        let WrittenCalls::Stay { beside, written_out } = &mut self.calls else { return };
        if let Some(error) = beside.iter().find_map(|file| may(file).err()) {
            self.bytes = std::mem::take(written_out);
            self.calls =
                WrittenCalls::WrittenOut { because: format!("what it calls cannot be written beside it: {error}") };
        }
    }

    /// The files that it calls beside it, as they are to be there.
    pub fn called(&self) -> &[CalledFile] {
        match &self.calls {
            WrittenCalls::Stay { beside, .. } => beside,
            _ => &[],
        }
    }
}
