//! A program for the machine: read, compensated, written back, read again and simulated as written.

pub mod bounded;
mod compensate;
mod corners;
mod corrected;
#[cfg(feature = "report")]
pub mod files;
mod part;
mod prove;
#[cfg(feature = "report")]
pub mod report;
mod turned;

use std::{path::Path, sync::OnceLock};

use serde::Serialize;

use self::{part::TrackPart, turned::turned};
pub use compensate::{Asked, Compensated, InMemory, Proved, Receiver, Refused, Way};
pub use corrected::{Corrected, Written, WrittenCalls};
pub use part::Part;
pub use prove::{LawBehind, ProvedPart};

use crate::{
    compensation::{Method, Target, TaskPoint},
    input::error::{Error, Result},
    machine::{Coordinate, Machine},
    process::{cutting::LoadError, file::Process},
    redundancy::FoundGamma,
    simulation::{
        Machines, ProgramFile, Sent,
        along_path::{Commands, Left, PathAnswer, PathSummary, PathSums, run_tracked},
        external_axes::locked_along,
        tasks::Tracked,
    },
    spatial::Pose,
    toolpath::{PathPoint, Toolpath},
    work::Work,
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
    /// The program; if γ was sought, as it says then how the platform stands.
    pub file: ProgramFile,
    /// What was found of γ, the rotation about the tool axis, if the process asks for the best one.
    pub redundancy: Option<FoundGamma>,
    /// Its points.
    pub path: Toolpath,
    /// Its name in errors.
    name: String,
    /// What is wanted at each point, if that is not found again whenever it is needed: a platform that turns with its position is tracked
    /// from point to point, which takes long.
    kept: Option<Vec<TaskPoint>>,
    /// Where the machine is tracked along each part of a program that is not too long to keep it.
    track: Vec<OnceLock<TrackPart>>,
    cuts_nowhere: bool,
    is_closed: bool,
}

/// How the points of a program get their commands.
#[derive(Debug, Clone, Copy)]
pub enum ProgramCommands<'a> {
    /// By a compensation method.
    Method(Method),
    /// From a program.
    Sent(&'a Sent),
    /// Drive positions at each point, mm or rad.
    Drives(&'a [Vec<f64>]),
}

/// A pass over the program: what some commands lead to.
#[derive(Debug, Clone, Serialize)]
pub struct Pass {
    /// What was commanded, in words.
    pub name: String,
    /// Summed up over the points at which the tool cuts.
    pub summary: PathSummary,
}

impl ProgramJob {
    /// Reads the program in `file` and the cutting force along it.
    ///
    /// # Errors
    /// As [`ProgramFile::read`] and [`ProgramJob::new`].
    pub fn open(process: Process, file: &Path, work: &Work) -> Result<Self> {
        let program = ProgramFile::read(file, &process)?;
        Self::new(process, program, &file.display().to_string(), work)
    }

    /// `program`, called `name` in errors, with the cutting force along it; γ is sought if the process asks for the best one, which is what
    /// `work` is told of.
    ///
    /// # Errors
    /// A target that a program cannot command, a program that moves nowhere or has too many points, or a path that lacks what
    /// the cutting force needs; no γ that is possible all along, or a format that cannot say it; those of `work`.
    pub fn new(process: Process, program: ProgramFile, name: &str, work: &Work) -> Result<Self> {
        let (process, program, redundancy) = match process.redundancy.is_sought() {
            true => turned(&process, &program, name, work)?,
            false => (process, program, None),
        };
        let path = program.long_toolpath(process.sampling)?;
        if path.is_empty() {
            let problem = match &program {
                ProgramFile::Gcode(program) if !program.notes().not_located.is_empty() => {
                    "moves nowhere known: a G0 or G1 to a position in X, Y and Z is expected, or start_mm in [gcode]"
                }
                #[cfg(not(target_family = "wasm"))]
                ProgramFile::Robot(program) if !program.notes().not_located.is_empty() => {
                    "moves nowhere known: a motion to a full pose is expected (X, Y, Z and the orientation)"
                }
                _ => "moves nowhere: a program with at least one motion is expected",
            };
            return Err(Error::argument(name, problem));
        }
        check_says_turns(&process, &path, name)?;
        let path = process.with_cuts(path, name)?;
        let process = Process { machine: locked_along(&process.machine, &path, name)?, ..process };
        let machine = process.machine.clone();
        let faulty = |fault: LoadError| Error::argument(name, fault.to_string());
        process.check_loads(&path).map_err(faulty)?;
        let all = || (0..path.len()).map(part::task_at(&process, &path)).collect::<std::result::Result<_, _>>();
        let kept = machine.turns_with_position.then(all).transpose().map_err(faulty)?;
        let real = Machines::new(&machine, &process.errors)?.real;
        let cuts_nowhere = !path.points().iter().any(|point| point.cutting);
        let is_closed = path.is_closed();
        let (name, track) = (name.to_string(), part::track(&path));
        let file = program;
        Ok(Self { real, machine, process, file, redundancy, path, name, kept, track, cuts_nowhere, is_closed })
    }

    /// Whether point `k` counts in what is left: the tool cuts there, if it does anywhere, and it is not a closed path's begin,
    /// which comes once more at its end.
    pub fn counts(&self, k: usize) -> bool {
        (self.path.points()[k].cutting || self.cuts_nowhere) && (k > 0 || !self.is_closed)
    }

    /// Whether the tool is turned as well as moved.
    pub(super) fn turns_tool(&self) -> bool {
        turns_tool(&self.process)
    }

    /// The machine at home, to be tracked along the program.
    fn track(&self) -> Tracked<'_> {
        Tracked::new(&self.machine, &self.process.placement)
    }

    /// One pass over the program; `take` gets some points that follow one another, and their answers. `done` is called after each
    /// point.
    ///
    /// # Errors
    /// Of `take`.
    pub fn pass(
        &self,
        name: impl Into<String>,
        commands: &ProgramCommands<'_>,
        done: &(dyn Fn() + Sync),
        mut take: impl FnMut(&Part<'_>, &[PathAnswer]) -> Result<()>,
    ) -> Result<Pass> {
        let (mut sums, mut track, mut before) = (PathSums::default(), self.track(), None);
        for part in self.parts() {
            let part = part?;
            let case = part.case([&self.machine, &self.real, &self.machine]);
            let along = self.tracking(&part, &mut before);
            let answers =
                self.answers(&part, &mut track, commands, &|commands| run_tracked(&case, commands, &along, done));
            self.sum_up(&mut sums, part.first, &answers);
            take(&part, &answers)?;
        }
        Ok(Pass { name: name.into(), summary: sums.summary() })
    }

    /// What `run` answers to `commands` at the points of `part`, as poses if they are positions; `tracked` comes from the part before.
    fn answers(
        &self,
        part: &Part<'_>,
        track: &mut Tracked<'_>,
        commands: &ProgramCommands<'_>,
        run: &dyn Fn(&Commands<'_>) -> Vec<PathAnswer>,
    ) -> Vec<PathAnswer> {
        match commands {
            ProgramCommands::Method(method) => run(&Commands::Method(*method)),
            ProgramCommands::Drives(drives) => run(&Commands::Drives(&drives[part.range()])),
            ProgramCommands::Sent(sent) => {
                let asked = part.range().zip(part.points).zip(part.tasks());
                let pose = |((k, point), task): ((usize, &PathPoint), &TaskPoint)| {
                    let turned = sent.orientations.as_ref().map(|orientations| &orientations[k]);
                    track.pose(sent.positions[k], turned.or(point.orientation.as_ref()), task.external)
                };
                let poses: Vec<Pose> = asked.map(pose).collect();
                run(&Commands::Program(&poses))
            }
        }
    }

    /// Adds those of `answers`, from point `first` on, that count.
    fn sum_up(&self, sums: &mut PathSums, first: usize, answers: &[PathAnswer]) {
        let counted = answers.iter().enumerate().filter(|(k, _)| self.counts(first + k));
        counted.for_each(|(_, answer)| sums.add(&Left::of(answer, &self.machine)));
    }

    /// One pass by a method.
    ///
    /// # Errors
    /// As [`ProgramJob::pass`].
    pub fn pass_by(
        &self,
        method: Method,
        done: &(dyn Fn() + Sync),
        take: impl FnMut(&Part<'_>, &[PathAnswer]) -> Result<()>,
    ) -> Result<Pass> {
        self.pass(method.label(), &ProgramCommands::Method(method), done, take)
    }
}

/// Whether the orientation of the platform is compensated.
fn turns_tool(process: &Process) -> bool {
    let controls = &process.machine.controls;
    process.target == Target::FullPose && controls.iter().any(|c| matches!(c, Coordinate::Rotation(_)))
}

/// A program whose orientations are to be corrected must say how the tool stands.
fn check_says_turns(process: &Process, path: &Toolpath, name: &str) -> Result<()> {
    if !turns_tool(process) || path.points().iter().all(|point| point.orientation.is_some()) {
        return Ok(());
    }
    let problem = "full_pose cannot be written: the program does not say how the tool stands at each point; expected one that does (a \
                   polyline with columns for it, a program of a robot, APT with the tool's axis, G-code with [[gcode.rotary]]), or \
                   tool_tip as compensate.target";
    Err(Error::argument(name, problem))
}
