//! A program for the machine: read, compensated, written back, read again and simulated as written.

pub mod before;
pub mod bounded;
mod corners;
#[cfg(feature = "report")]
pub mod files;
mod reach;
#[cfg(feature = "report")]
pub mod report;

use std::path::Path;

use nalgebra::Vector3;
use serde::Serialize;

use self::corners::go_round_corners;
use crate::{
    compensation::{Demand, Method, Target},
    input::error::{Error, Result},
    machine::{Coordinate, Machine},
    process::file::Process,
    spatial::Pose,
    study::{
        Machines, ProgramFile,
        along_path::{Commands, Left, PathAnswer, PathCase, PathSummary, PathSums, run_in_parts},
        blocks::BlocksBeforeAfter,
        demands::{Led, demands},
        external_axes::held_along,
        program_file::Rewritten,
    },
    toolpath::{PathPoint, Toolpath},
};

/// A program ready to be compensated on a machine.
#[derive(Debug, Clone)]
pub struct ProgramJob {
    /// The nominal machine with the tool of the process.
    pub machine: Machine,
    /// The machine with its errors.
    pub real: Machine,
    /// The process.
    pub process: Process,
    /// The program.
    pub file: ProgramFile,
    /// Its points.
    pub path: Toolpath,
    /// What is wanted at each, under load.
    pub demands: Vec<Demand>,
    cuts_nowhere: bool,
    begins_twice: bool,
}

/// A pass over the program: what some commands lead to.
#[derive(Debug, Clone, Serialize)]
pub struct Pass {
    /// What was commanded, in words.
    pub name: String,
    /// Summed up over the points at which the tool cuts.
    pub summary: PathSummary,
}

/// Where the tool is sent, gathered point after point.
#[derive(Debug, Clone)]
pub struct Corrected {
    /// Workpiece frame, mm; as in the path where there is no command.
    positions: Vec<Vector3<f64>>,
    /// Points at which the tool cuts but that have no command: index and reason.
    pub failures: Vec<(usize, String)>,
    /// Points not cut at (rapid moves) that could not be compensated and are left as they were.
    pub left_alone: usize,
}

impl Corrected {
    /// For `job`, none of its points seen.
    pub fn new(job: &ProgramJob) -> Self {
        Self { positions: Vec::with_capacity(job.path.len()), failures: Vec::new(), left_alone: 0 }
    }

    /// Points seen.
    pub fn seen(&self) -> usize {
        self.positions.len()
    }

    /// Takes the next answers of the pass that is to be written.
    pub fn add(&mut self, job: &ProgramJob, answers: &[PathAnswer]) {
        for answer in answers {
            let k = self.positions.len();
            let point = &job.path.points()[k];
            let target = answer.target.filter(|_| answer.status.is_success());
            let position = target.map(|pose| job.commanded(k, pose));
            match position {
                Some(_) => {}
                None if point.cutting => self.failures.push((k, answer.status.reason(&job.machine))),
                None => self.left_alone += 1,
            }
            self.positions.push(position.unwrap_or(point.position_mm));
        }
    }
}

/// The compensated program.
#[derive(Debug, Clone)]
pub struct Written {
    /// The program's text.
    pub bytes: Vec<u8>,
    /// Poses of P that it commands, read back from the text.
    pub poses: Vec<Pose>,
    /// The farthest that writing has moved a position, mm.
    pub rounded_mm: f64,
    /// The same for the ways in and out of holes of cycles, which all have the correction of the bottom; `None` if there are
    /// no such holes.
    pub in_holes_mm: Option<f64>,
    /// What the blocks of a G-code program ask of a control, before and as written.
    pub blocks: Option<BlocksBeforeAfter>,
}

impl ProgramJob {
    /// Reads the program in `file` and the cutting force along it.
    ///
    /// # Errors
    /// As [`ProgramFile::read`] and [`ProgramJob::new`].
    pub fn open(process: Process, file: &Path) -> Result<Self> {
        can_be_written(&process)?;
        let program = ProgramFile::read(file, &process.gcode)?;
        Self::new(process, program, &file.display().to_string())
    }

    /// `program`, called `name` in errors, with the cutting force along it.
    ///
    /// # Errors
    /// A target that a program cannot command, a program that moves nowhere or has too many points, or a path that lacks what
    /// the cutting force needs.
    pub fn new(process: Process, program: ProgramFile, name: &str) -> Result<Self> {
        can_be_written(&process)?;
        let path = program.toolpath(process.sampling)?;
        if path.is_empty() {
            let problem = match &program {
                ProgramFile::Gcode(program) if !program.notes().not_located.is_empty() => {
                    "moves nowhere known: a G0 or G1 to a position in X, Y and Z is expected, or start_mm in [gcode]"
                }
                _ => "moves nowhere: a program with at least one motion is expected",
            };
            return Err(Error::Argument { argument: name.into(), problem: problem.into() });
        }
        let path = process.with_cuts(path, name)?;
        let process = Process { machine: held_along(&process.machine, &path, name)?, ..process };
        let machine = process.machine.clone();
        let mut demands = demands(&process, &path, name)?;
        go_round_corners(&process, &path, &mut demands)
            .map_err(|source| Error::Argument { argument: name.into(), problem: source.to_string() })?;
        let real = Machines::new(&machine, &process.errors)?.real;
        let cuts_nowhere = !path.points().iter().any(|point| point.cutting);
        let begins_twice = path.begins_twice();
        Ok(Self { real, machine, process, file: program, path, demands, cuts_nowhere, begins_twice })
    }

    /// Whether point `k` counts in what is left: the tool cuts there, if it does anywhere, and it is not a closed path's begin,
    /// which comes once more at its end.
    pub fn counts(&self, k: usize) -> bool {
        (self.path.points()[k].cutting || self.cuts_nowhere) && (k > 0 || !self.begins_twice)
    }

    /// The path position that commands `target` at point `k`. Along axes that are not controlled it is that of the program.
    pub fn commanded(&self, k: usize, target: Pose) -> Vector3<f64> {
        let mut led = Led::new(&self.machine, &self.process.placement);
        let placed = led.placed(self.demands[k].external);
        let workpiece = placed.workpiece();
        let own = workpiece.transform(self.path.points()[k].position_mm);
        let mut position = target.transform(placed.reference());
        for axis in self.machine.uncontrolled_axes() {
            position[axis] = own[axis];
        }
        workpiece.inverse().transform(position)
    }

    /// The poses of P that positions of the program command one after another, as far as the drives control them.
    fn poses(&self, positions: impl Iterator<Item = Vector3<f64>>) -> Vec<Pose> {
        let mut led = Led::new(&self.machine, &self.process.placement);
        positions.zip(&self.demands).map(|(position, demand)| led.pose(position, demand.external)).collect()
    }

    fn case(&self) -> PathCase<'_> {
        PathCase {
            nominal: &self.machine,
            real: &self.real,
            resting: &self.machine,
            before: &[],
            demands: &self.demands,
        }
    }

    /// One pass over the program; `take` gets the index of the first of some points that follow one another, and their
    /// answers. `done` is called after each point.
    ///
    /// # Errors
    /// Of `take`.
    pub fn pass(
        &self,
        name: impl Into<String>,
        commands: &Commands<'_>,
        done: &(dyn Fn() + Sync),
        mut take: impl FnMut(usize, &[PathAnswer]) -> Result<()>,
    ) -> Result<Pass> {
        let (mut sums, mut first) = (PathSums::default(), 0);
        run_in_parts(&self.case(), commands, done, |answers| {
            for (k, answer) in answers.iter().enumerate() {
                if self.counts(first + k) {
                    sums.add(&Left::of(answer, &self.machine));
                }
            }
            take(first, &answers)?;
            first += answers.len();
            Ok::<(), Error>(())
        })?;
        Ok(Pass { name: name.into(), summary: sums.summary() })
    }

    /// One pass by a method.
    ///
    /// # Errors
    /// As [`ProgramJob::pass`].
    pub fn pass_by(
        &self,
        method: Method,
        done: &(dyn Fn() + Sync),
        take: impl FnMut(usize, &[PathAnswer]) -> Result<()>,
    ) -> Result<Pass> {
        self.pass(method.label(), &Commands::Method(method), done, take)
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
            ProgramFile::Gcode(_) => return Err(counts(measured.len(), points, points)),
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

    /// Poses of P that mirror a measured pass at the wanted path, Figure 2. `measured`: where the tool went, workpiece
    /// frame, mm, one position per point of the path.
    pub fn mirrored(&self, measured: &[Vector3<f64>]) -> Vec<Pose> {
        self.poses(self.path.points().iter().zip(measured).map(|(point, went)| point.position_mm * 2.0 - went))
    }

    /// Writes the program that sends the tool where `corrected` says, and reads it back.
    ///
    /// # Errors
    /// The program cannot be rewritten.
    pub fn write(&self, corrected: &Corrected) -> Result<Written> {
        let Rewritten { bytes, back, blocks } = self.file.rewritten(&self.path, &corrected.positions, &self.process)?;
        let (mut rounded_mm, mut in_holes_mm) = (0.0, None);
        for (point, (wanted, written)) in self.path.points().iter().zip(corrected.positions.iter().zip(&back)) {
            let moved = (written - wanted).norm();
            rounded_mm = f64::max(rounded_mm, moved);
            if self.file.is_hole(point.source.segment) {
                in_holes_mm = Some(in_holes_mm.map_or(moved, |most| f64::max(most, moved)));
            }
        }
        Ok(Written { bytes, poses: self.poses(back.into_iter()), rounded_mm, in_holes_mm, blocks })
    }
}

/// A program commands positions, not orientations.
fn can_be_written(process: &Process) -> Result<()> {
    if process.target == Target::FullPose
        && process.machine.controls.iter().any(|c| matches!(c, Coordinate::Rotation(_)))
    {
        let problem = "full_pose cannot be written: a program commands positions, not orientations".into();
        return Err(Error::Argument { argument: "compensate.target".into(), problem });
    }
    Ok(())
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
