//! Compensates a program: finds the commands, writes the program that gives them, reads it back and verifies it by simulation.

use super::deflected::{DeflectedCut, MAX_POINTS};
use super::{
    CorrectedPath, ForceCheck, Part, Pass, ProgramAsWritten, ProgramCommands, ProgramJob, Verification, VerifiedPart,
    WithoutForce,
    bounded::{ExcessSearch, LimitExcess},
};
use crate::{
    compensation::{BoundedPath, Method},
    input::error::{Error, Result},
    simulation::{Source, along_path::PathPointResult, spread_along::PathSpread},
    toolpath::{CommandedPath, gcode::CalledFile},
    work::{Event, Work},
};

/// Options for compensating a program.
#[derive(Debug, Clone)]
pub struct CompensateOptions {
    /// Source of the drive commands.
    pub commands: CommandSource,
    /// Methods simulated for comparison, besides no compensation.
    pub compared: Vec<Method>,
    /// Whether each error source is also simulated alone.
    pub sources_apart: bool,
    /// Whether to stop at the first points without command, and to look for untrackable points first; otherwise all such points are found.
    pub ends_early: bool,
}

/// Source of the commands of a compensated program.
#[derive(Debug, Clone)]
pub enum CommandSource {
    /// A compensation method, point by point.
    Method(Method),
    /// An optimisation of the whole path within limits.
    Bounded,
    /// A measured pass, see [`ProgramJob::mirrored_path`].
    Mirror(CommandedPath),
}

/// Receives the compensated program part by part.
pub trait PartSink: Send {
    /// Checks that a `file` that the program calls may be written beside it.
    ///
    /// # Errors
    /// It may not; the calls are then written out in the program.
    fn may_call(&self, file: &CalledFile) -> Result<()>;

    /// Takes the next verified part; `bounded` is the path corrected within limits, if it was.
    ///
    /// # Errors
    /// The part cannot be stored.
    fn take(&mut self, verified: &VerifiedPart<'_>, bounded: Option<&BoundedPath>) -> Result<()>;
}

/// A receiver for a program that stays in memory: it stores nothing.
#[derive(Debug)]
pub struct NoFiles;

impl PartSink for NoFiles {
    /// Refuses every called file, since nothing is written beside the program.
    fn may_call(&self, file: &CalledFile) -> Result<()> {
        Err(Error::argument(&file.name, "no files are written beside a program that is kept in memory"))
    }

    /// Accepts the part without storing it.
    fn take(&mut self, _: &VerifiedPart<'_>, _: Option<&BoundedPath>) -> Result<()> {
        Ok(())
    }
}

/// Outcome of compensating a program.
#[derive(Debug)]
pub enum Compensated {
    /// The program was written and verified.
    Verified(Box<VerifiedProgram>),
    /// The tool cuts at points that have no command.
    Refused(NotWritten),
}

/// A rewritten program and its simulated residual errors.
#[derive(Debug)]
pub struct VerifiedProgram {
    /// Simulated passes: no compensation, the compared methods, the commands themselves, and last the program as written.
    pub passes: Vec<Pass>,
    /// The program as written.
    pub written: ProgramAsWritten,
    /// The path corrected within limits, if it was.
    pub bounded: Option<BoundedPath>,
    /// Limits that the program as written exceeds; `None` where limits were not checked.
    pub exceeded: Option<Vec<LimitExcess>>,
    /// How sure it is that drive forces stay within their limits; `None` where inputs are taken as exact or no force is limited.
    pub forces: Option<ForceCheck>,
    /// What the program as written does if the cutting force is absent.
    pub without_force: WithoutForce,
    /// The tool without compensation in the cut that it makes; `None` without stock, for long programs, and where nothing bends.
    pub deflected_cut: Option<DeflectedCut>,
    /// Distributions of the largest error over the points that count, without compensation and as written; `None` where inputs are taken as exact.
    pub spread: Option<PathSpread>,
    /// Number of non-cutting points (rapid moves) that have no correction and keep their position.
    pub uncorrected: usize,
    /// Whether its commands take back the play of drives that are pressed to a side: those of a compensation method.
    pub takes_play_back: bool,
}

impl VerifiedProgram {
    /// Returns the largest residual error of the commands before they are written, mm; `None` if no point was solved.
    pub fn commanded_max_mm(&self) -> Option<f64> {
        self.passes.iter().rev().nth(1).and_then(|pass| pass.summary.max_mm)
    }
}

/// Reasons why no program was written.
#[derive(Debug)]
pub struct NotWritten {
    /// Whether the rigid machine cannot be tracked to these points.
    pub is_out_of_reach: bool,
    /// Index of each failed point and the reason.
    pub failures: Vec<(usize, String)>,
    /// Number of points visited.
    pub visited: usize,
    /// Residual errors at the points that have commands, if all points were visited.
    pub pass: Option<Pass>,
}

impl CompensateOptions {
    /// Returns options for commands by one `method`, without comparison.
    pub fn by(method: Method) -> Self {
        Self { commands: CommandSource::Method(method), compared: Vec::new(), sources_apart: false, ends_early: false }
    }

    /// Returns the number of passes over the points of `job` for which progress is reported.
    pub fn pass_count(&self, job: &ProgramJob) -> usize {
        let sources = if self.sources_apart { Source::of(&job.machine).len() } else { 1 };
        let uncertain = usize::from(job.uncertainty.is_some());
        usize::from(self.ends_early) + 1 + self.compared.len() + sources + 2 + uncertain
    }
}

/// Most untrackable points that are named.
const NAMED: usize = 5;

impl ProgramJob {
    /// Finds commands as `asked`, writes the program and verifies it part by part, which `to` receives; `work` is told of each point of each pass.
    ///
    /// # Errors
    /// Those of [`ProgramJob::bounded_pass`], [`ProgramJob::write`], [`ProgramJob::verify`], of `to` and of `work`.
    pub fn compensate(&self, asked: &CompensateOptions, to: &mut impl PartSink, work: &Work) -> Result<Compensated> {
        if let (CommandSource::Mirror(_), Some(table)) = (&asked.commands, &self.process.uncertainty) {
            // What was measured has in it what the model leaves out.
            let problem = "is not computed for a measured pass: expected a method, or no such table";
            table.check.fail::<()>(problem.into())?;
        }
        if let (CommandSource::Mirror(_), Some(limits)) = (&asked.commands, &self.process.feed) {
            let problem =
                "changes feeds, and a measured pass is of the program as it was: expected a method, or no such table";
            limits.check.fail::<()>(problem.into())?;
        }
        if asked.ends_early {
            let failures = self.untrackable_points(NAMED, |points| work.tell(Event::Computed(points)))?;
            if !failures.is_empty() {
                return Ok(Compensated::Refused(NotWritten {
                    is_out_of_reach: true,
                    failures,
                    visited: 0,
                    pass: None,
                }));
            }
        }
        let done = || work.tell(Event::Computed(1));
        // First what is asked for: where there is no command, the others are of no use.
        let (mut corrected, mut bounded, mut tightened) = (CorrectedPath::new(self), None, None);
        let take = |part: &Part<'_>, results: &[PathPointResult]| {
            corrected.add(self, part, results);
            if asked.ends_early && !corrected.failures.is_empty() { Err(Error::Stopped) } else { work.check() }
        };
        let sought = match &asked.commands {
            CommandSource::Mirror(sent) => {
                self.pass("mirror of the measured pass", &ProgramCommands::CommandedPath(sent), &done, take)
            }
            CommandSource::Method(method) => self.pass_by(*method, &done, take),
            CommandSource::Bounded => self.bounded_pass(work, take).map(|found| {
                (bounded, tightened) = (Some(found.path), found.forces);
                found.pass
            }),
        };
        work.check()?;
        if !corrected.failures.is_empty() {
            // What ended early has its reason in the failures.
            let (visited, pass) = (corrected.point_count(), if asked.ends_early { sought.ok() } else { Some(sought?) });
            let failures = corrected.failures;
            return Ok(Compensated::Refused(NotWritten { is_out_of_reach: false, failures, visited, pass }));
        }
        let sought = sought?;
        let mut written = self.write(&corrected)?;
        written.keep_calls_only_if(|file| to.may_call(file));
        let uncorrected = corrected.uncorrected;
        drop(corrected);
        let forces = match (tightened, &bounded) {
            (Some(tightened), Some(path)) => self.check_forces(tightened, path, &written, work)?,
            _ => None,
        };
        let mut excess = bounded.as_ref().map(|bounded| ExcessSearch::new(self, bounded));
        let name = format!("{}, as written", sought.name);
        let mut errors_before = Vec::new();
        let Verification { mut passes, without_force, spread } =
            self.verify(name, &written, asked, work, |verified| {
                work.check()?;
                excess.iter_mut().for_each(|excess| excess.add(verified.part.first, &verified.written));
                if self.process.stock.is_some() && self.path.len() <= MAX_POINTS {
                    errors_before.extend_from_slice(&verified.before[Source::All]);
                }
                to.take(verified, bounded.as_ref())
            })?;
        let exceeded = excess.map(ExcessSearch::worst);
        passes.insert(passes.len() - 1, sought);
        Ok(Compensated::Verified(Box::new(VerifiedProgram {
            passes,
            written,
            bounded,
            exceeded,
            forces,
            without_force,
            deflected_cut: self.deflected_cut(errors_before, work)?,
            spread,
            uncorrected,
            takes_play_back: matches!(asked.commands, CommandSource::Method(method) if method != Method::None),
        })))
    }
}
