//! A program for the machine: read, compensated, written back, read again and simulated as written.
//!
//! What it is, from what was read ([`ProgramFile`]) to its verification; the stages before are those of [`toolpath`](crate::toolpath):
//!
//! | stage | what it is |
//! |---|---|
//! | [`ProgramJob`] | the program with machine, process and force along its path |
//! | [`CompensateOptions`], [`CommandSource`] | what is asked for, and of what the drive commands are made |
//! | [`ProgramCommands`] | the drive commands along the program, as they are simulated |
//! | [`CorrectedPath`] | where these commands send the tool, point by point |
//! | [`ProgramAsWritten`] | the text through that path, and the [`CommandedPath`] that was read back from it |
//! | [`Verification`] | residual errors of what was read back, part by part ([`VerifiedPart`]) |
//! | [`VerifiedProgram`] | the program as written with its verification; [`Compensated`]: that, or why there is none |
//! | `files::ProgramResults` | what was found of a program that stands in its files; `files::ProgramOutcome`: that, or why there is none |

pub mod bounded;
#[cfg(not(target_family = "wasm"))]
mod clearance;
mod compensate;
mod corrected;
mod deflected;
mod feed;
#[cfg(feature = "report")]
pub mod files;
mod forces;
mod part;
#[cfg(feature = "report")]
pub mod report;
#[cfg(feature = "report")]
mod surface;
mod turned;
mod verify;

use std::{
    ops::Deref,
    path::Path,
    sync::{Arc, OnceLock},
};

use serde::Serialize;

use self::part::TrackPart;
use self::turned::with_best_gamma;
pub use compensate::{CommandSource, CompensateOptions, Compensated, NoFiles, NotWritten, PartSink, VerifiedProgram};
pub use corrected::{CorrectedPath, ProgramAsWritten, WrittenCalls};
pub use deflected::DeflectedCut;
pub use feed::{FoundFeeds, Placed};
pub use forces::ForceCheck;
pub use part::Part;
pub use verify::{CuttingLawCheck, Verification, VerifiedPart, WithoutForce};

use crate::{
    compensation::{Method, Target, TaskPoint},
    input::error::{Error, Result},
    machine::Coordinate,
    process::{
        CutPath, PathReference,
        cutting::LoadError,
        file::Process,
        uncertainty::{ForceSpread, UncertaintyTable},
    },
    redundancy::FoundGamma,
    simulation::{
        Machines, TrackedPath,
        along_path::{Commands, PathPointResult, PathSummary, PathSums, PointResidual, run_tracked},
        spread_along,
        tasks::PoseTracker,
        with_drives_left,
    },
    spatial::Pose,
    toolpath::{CommandedPath, PathPoint, ProgramFile, Toolpath, gcode::Dialect},
    work::{Event, Work},
};

/// A program ready to be compensated: its machine, process and path, with the cutting force along it.
#[derive(Debug, Clone)]
pub struct ProgramJob {
    /// Its machine, where the workpiece stands, and what is uncertain.
    pub tracked: TrackedPath,
    /// The nominal machine and the actual ones, which have the chain errors of the process.
    pub machines: Machines,
    /// The process.
    pub process: Process,
    /// The process with each component of its forces alone, where one varies by itself. Each is blended at corners by itself: behind one on an arc their sum may differ from
    /// the whole as blended.
    components: Vec<Process>,
    /// The program; where the best γ was sought, it has the orientations of that γ.
    pub file: ProgramFile,
    /// The γ (rotation about the tool axis) that was found, if the process asks for the best one.
    pub redundancy: Option<FoundGamma>,
    /// The feeds that were chosen, if the process asks for it; `file` has them.
    pub feed: Option<FoundFeeds>,
    /// The points of the program.
    pub path: CutPath,
    /// The program's name in error messages.
    name: String,
    /// Task points of all path points; `None` where they are computed when needed. Stored only for a platform with parasitic rotation, whose
    /// poses must be tracked from point to point, which takes long.
    tasks: Option<Vec<TaskPoint>>,
    /// Tracked configurations of each part, filled when first needed; empty for programs too long to store them.
    part_tracks: Vec<OnceLock<TrackPart>>,
    /// Whether the tool cuts at no point; all points then count in the residual error.
    cuts_nowhere: bool,
    /// Whether the path ends where it begins.
    is_closed: bool,
}

impl Deref for ProgramJob {
    type Target = TrackedPath;

    fn deref(&self) -> &TrackedPath {
        &self.tracked
    }
}

/// Where the drive commands along a program come from.
#[derive(Debug, Clone, Copy)]
pub enum ProgramCommands<'a> {
    /// A compensation method computes them.
    Method(Method),
    /// They send the tool along this path, as a program does.
    CommandedPath(&'a CommandedPath),
    /// They are these drive positions at each point, mm or rad.
    Drives(&'a [Vec<f64>]),
}

/// Residual errors of one simulated pass over the program.
#[derive(Debug, Clone, Serialize)]
pub struct Pass {
    /// Name of the commands, such as a method or "…, as written".
    pub name: String,
    /// Residual errors over the points that count.
    pub summary: PathSummary,
}

impl ProgramJob {
    /// Reads the program in `file` and computes the cutting force along it.
    ///
    /// # Errors
    /// As [`Process::read_program`] and [`ProgramJob::new`].
    pub fn open(process: Process, file: &Path, work: &Work) -> Result<Self> {
        let program = process.read_program(file)?;
        Self::new(process, program, &file.display().to_string(), work)
    }

    /// Prepares `program`, called `name` in errors, and computes the cutting force along it; seeks γ if the process asks for the best one,
    /// and reports the progress of that to `work`; chooses its feeds if the process limits something by them.
    ///
    /// # Errors
    /// A target that a program cannot command, a program that moves nowhere or has too many points, or a path that lacks what the cutting
    /// force needs; no γ that is possible along the whole path, or a format that cannot express it; a program whose feeds cannot be chosen; errors of `work`.
    pub fn new(process: Process, program: ProgramFile, name: &str, work: &Work) -> Result<Self> {
        if let Some(limits) = &process.feed {
            return feed::with_feeds(limits, &process, program, name, work);
        }
        Self::as_programmed(process, program, name, work)
    }

    /// Prepares `program` as [`ProgramJob::new`] does, with the feeds that it has.
    fn as_programmed(process: Process, program: ProgramFile, name: &str, work: &Work) -> Result<Self> {
        // Pages get programs at the γ that was found.
        let (process, program, redundancy) = match process.redundancy.is_sought() {
            true => with_best_gamma(&process, &program, name, work)?,
            false => (process, program, None),
        };
        let path = program.long_toolpath(process.sampling)?;
        if path.is_empty() {
            let problem = match &program {
                ProgramFile::Gcode(program) if !program.notes().unlocated_lines.is_empty() => {
                    "moves nowhere known: a G0 or G1 to a position in X, Y and Z is expected, or start_mm in [gcode]"
                }
                ProgramFile::Robot(program) if !program.notes().unlocated_lines.is_empty() => {
                    "moves nowhere known: a motion to a full pose is expected (X, Y, Z and the orientation)"
                }
                _ => "moves nowhere: a program with at least one motion is expected",
            };
            return Err(Error::argument(name, problem));
        }
        check_orientations(&process, &path, name)?;
        if process.has_force() || process.errors.iter().any(|errors| !errors.is_none()) {
            check_unit(&program, name)?;
        }
        if let Some(stock) = &process.stock {
            if process.placement.reference == PathReference::ToolTip {
                let (cell_mm, bytes) = stock.field_size(&path, &process.machine, &process.placement)?;
                work.tell(Event::Stock { cell_mm, bytes });
            }
            work.tell(Event::Stage(crate::work::Stage { of: "moves cut", items: path.len() }));
        }
        let path = process.mark_cutting_and_tell(path, name, &mut || work.tell(Event::Computed(1)))?;
        let process = with_drives_left(process, &path, Some(&program), name)?;
        let mut tracked = TrackedPath::of(&process);
        process.check_loads(&path).map_err(|fault| Error::argument(name, load_problem(&fault, &program)))?;
        let tasks = part::stored_tasks(&process, &path, name)?;
        let machines = tracked.machines()?;
        let tools = path.cutting_tools();
        let cut = process.cut_by(&tools);
        let uncertain = |table: &UncertaintyTable| table.of_path(&process.machine, &process.errors, &cut);
        tracked.uncertainty = process.uncertainty.as_ref().map(uncertain).transpose()?.map(Arc::new);
        let has_components = tracked.uncertainty.as_ref().is_some_and(|own| own.force.has_components());
        let components = (0..ForceSpread::COMPONENTS.len()).filter(|_| has_components);
        let components = components.filter_map(|own| process.with_only(own)).collect();
        let cuts_nowhere = !path.points().iter().any(|point| point.cutting);
        let is_closed = path.is_closed();
        let (name, part_tracks) = (name.to_string(), part::empty_tracks(&path));
        let file = program;
        let job = Self {
            tracked,
            machines,
            process,
            components,
            file,
            redundancy,
            feed: None,
            path,
            name,
            tasks,
            part_tracks,
            cuts_nowhere,
            is_closed,
        };
        job.check_postures()?;
        Ok(job)
    }

    /// Returns whether point `k` counts in the residual error: the tool cuts there, or the program cuts nowhere; the first point of a closed
    /// path does not count, since it is also the last.
    pub fn is_counted(&self, k: usize) -> bool {
        (self.path.points()[k].cutting || self.cuts_nowhere) && (k > 0 || !self.is_closed)
    }

    /// Returns the number of the pass of each point.
    pub(super) fn passes(&self) -> Vec<u32> {
        spread_along::numbers_of_passes(0, self.path.points().iter().map(|own| own.cutting))
    }

    /// Returns whether no motion of the program counts as cutting.
    pub fn cuts_nowhere(&self) -> bool {
        self.cuts_nowhere
    }

    /// Returns whether the tool's orientation is compensated as well as its position.
    pub(super) fn is_full_pose(&self) -> bool {
        is_full_pose(&self.process)
    }

    /// Returns a tracker of the nominal machine that starts at its home pose.
    fn tracker(&self) -> PoseTracker<'_> {
        PoseTracker::new(&self.machine, &self.process.placement)
    }

    /// Simulates `commands` over the program and returns the residual errors, named `name`. Calls `take` with each part and its results, in
    /// order, and `done` after each point. Errors of `take`.
    pub fn pass(
        &self,
        name: impl Into<String>,
        commands: &ProgramCommands<'_>,
        done: &(dyn Fn() + Sync),
        mut take: impl FnMut(&Part<'_>, &[PathPointResult]) -> Result<()>,
    ) -> Result<Pass> {
        let (mut sums, mut track, mut before) = (PathSums::default(), self.tracker(), None);
        for part in self.parts() {
            let part = part?;
            let case = part.case([&self.machine, &self.machines.actual, &self.machine]);
            let along = self.track(&part, &mut before);
            let results =
                self.part_results(&part, &mut track, commands, &|commands| run_tracked(&case, commands, &along, done));
            self.sum_up(&mut sums, part.first, &results);
            take(&part, &results)?;
        }
        Ok(Pass { name: name.into(), summary: sums.summary() })
    }

    /// Returns the results of `commands` at the points of `part`, computed by `run`; `track`, from the part before, turns positions into poses of P.
    fn part_results<T>(
        &self,
        part: &Part<'_>,
        track: &mut PoseTracker<'_>,
        commands: &ProgramCommands<'_>,
        run: &dyn Fn(&Commands<'_>) -> T,
    ) -> T {
        match commands {
            ProgramCommands::Method(method) => run(&Commands::Method(*method)),
            ProgramCommands::Drives(drives) => run(&Commands::Drives(&drives[part.range()])),
            ProgramCommands::CommandedPath(sent) => run(&Commands::Program(&commanded_poses(part, track, sent))),
        }
    }

    /// Adds to `sums` the residuals of those points that count; `results` begin at point `first`.
    fn sum_up(&self, sums: &mut PathSums, first: usize, results: &[PathPointResult]) {
        let counted = results.iter().enumerate().filter(|(k, _)| self.is_counted(first + k));
        counted.for_each(|(_, result)| sums.add(&PointResidual::of(result, &self.machine)));
    }

    /// Simulates the commands of a compensation method over the whole program, see [`ProgramJob::pass`].
    ///
    /// # Errors
    /// As [`ProgramJob::pass`].
    pub fn pass_by(
        &self,
        method: Method,
        done: &(dyn Fn() + Sync),
        take: impl FnMut(&Part<'_>, &[PathPointResult]) -> Result<()>,
    ) -> Result<Pass> {
        self.pass(method.label(), &ProgramCommands::Method(method), done, take)
    }
}

/// Returns the poses of P that `sent` commands at the points of `part`; `track` as in [`ProgramJob::part_results`].
fn commanded_poses(part: &Part<'_>, track: &mut PoseTracker<'_>, sent: &CommandedPath) -> Vec<Pose> {
    let pose = |((k, point), task): ((usize, &PathPoint), &TaskPoint)| {
        let orientation = sent.orientations.as_ref().map(|orientations| &orientations[k]);
        let near = task.led.map(|_| &task.pose.rotation);
        track.pose(sent.positions[k], orientation.or(point.orientation.as_ref()), task.external, near)
    };
    part.range().zip(part.points).zip(part.tasks()).map(pose).collect()
}

/// Returns why loads of `program` are not known.
fn load_problem(fault: &LoadError, program: &ProgramFile) -> String {
    let haas = match program {
        ProgramFile::Gcode(program) if matches!(fault, LoadError::NoFeed { .. }) => Some(program.notes())
            .filter(|notes| notes.dialect == Dialect::Haas)
            .and_then(|own| own.turned_alone_lines.first()),
        _ => None,
    };
    haas.map_or_else(|| fault.to_string(), |line| {
        format!("{fault}. In line {line} rotary axes move alone: to Haas F is the feed at the diameter of settings 34 and 79 then, which the program does not say; expected G93 there")
    })
}

/// Returns whether the orientation of the tool is compensated: the target is the full pose, and the drives control a rotation.
fn is_full_pose(process: &Process) -> bool {
    let controls = &process.machine.controls;
    process.target == Target::FullPose && controls.iter().any(|c| matches!(c, Coordinate::Rotation(_)))
}

/// Checks that the unit of a program is known before it is corrected.
pub(super) fn check_unit(program: &ProgramFile, name: &str) -> Result<()> {
    let ProgramFile::Gcode(program) = program else { return Ok(()) };
    let Some((_, line)) = program.notes().assumed_unit else { return Ok(()) };
    let text = if program.notes().dialect == Dialect::Sinumerik { "G700 or G710" } else { "G20 or G21" };
    let problem = format!(
        "names no unit before line {line}: expected {text} there, or unit = \"mm\" or \"inch\" in [gcode] of the process file, as a \
         correction in the wrong one is 25.4 times too large or too small"
    );
    Err(Error::argument(name, problem))
}

/// Checks that the program gives the tool's orientation at each point, if orientations are to be compensated.
fn check_orientations(process: &Process, path: &Toolpath, name: &str) -> Result<()> {
    if !is_full_pose(process) || path.points().iter().all(|point| point.orientation.is_some()) {
        return Ok(());
    }
    let problem = "full_pose cannot be written: the program does not say how the tool stands at each point; expected one that does (a \
                   polyline with columns for it, a program of a robot, APT with the tool's axis, G-code with [[gcode.rotary]]), or \
                   tool_tip as compensate.target";
    Err(Error::argument(name, problem))
}
