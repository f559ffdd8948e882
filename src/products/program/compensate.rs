//! A program compensated: commands found, the program that sends them written, read back, and proved by simulating it.

use super::{
    Corrected, Part, Pass, ProgramCommands, ProgramJob, ProvedPart, Written,
    bounded::{Exceedances, Exceeded},
};
use crate::{
    compensation::{BoundedPath, Method},
    input::error::{Error, Result},
    simulation::{Sent, Source, along_path::PathAnswer},
    toolpath::gcode::CalledFile,
    work::{Event, Work},
};

/// How a program is to be compensated.
#[derive(Debug, Clone)]
pub struct Asked {
    /// How commands are found.
    pub way: Way,
    /// Methods whose commands are simulated for comparison, beside none.
    pub compared: Vec<Method>,
    /// Whether each source of errors is simulated alone, too.
    pub sources_apart: bool,
    /// Whether it ends with the first points that have no command, those to which the rigid machine cannot be tracked before anything is
    /// computed; else all of them are sought.
    pub ends_early: bool,
}

/// How commands are found.
#[derive(Debug, Clone)]
pub enum Way {
    /// By a method, point by point.
    Method(Method),
    /// For the whole path at once within limits.
    Bounded,
    /// From a measured pass, see [`ProgramJob::mirrored`].
    Mirror(Sent),
}

/// Where a compensated program goes, and what is proved of it.
pub trait Receiver {
    /// Finds out whether a `file` that the program calls may be beside it.
    ///
    /// # Errors
    /// It may not; the program is then written out.
    fn may_call(&self, file: &CalledFile) -> Result<()>;

    /// Takes the next part, of a path that was corrected within limits if it is `bounded`.
    ///
    /// # Errors
    /// It cannot be kept.
    fn take(&mut self, proved: &ProvedPart<'_>, bounded: Option<&BoundedPath>) -> Result<()>;
}

/// Of a program that stays in memory.
#[derive(Debug)]
pub struct InMemory;

impl Receiver for InMemory {
    /// The bytes are all there is: nothing stands beside them that they could call.
    fn may_call(&self, file: &CalledFile) -> Result<()> {
        Err(Error::argument(&file.name, "no files are written beside a program that is kept in memory"))
    }

    fn take(&mut self, _: &ProvedPart<'_>, _: Option<&BoundedPath>) -> Result<()> {
        Ok(())
    }
}

/// What became of a program.
#[derive(Debug)]
pub enum Compensated {
    /// It is written.
    Proved(Box<Proved>),
    /// There are points at which the tool cuts but that have no command.
    Refused(Refused),
}

/// A program that has been rewritten and proved.
#[derive(Debug)]
pub struct Proved {
    /// What each kind of commands leaves: none first, then others, those of the program, and the program as it is written.
    pub passes: Vec<Pass>,
    /// The program.
    pub written: Written,
    /// What limits do, if the path was corrected within them.
    pub bounded: Option<BoundedPath>,
    /// Limits that the program as written exceeds; `None` where nobody looked.
    pub exceeded: Option<Vec<Exceeded>>,
    /// Points not cut at (rapid moves) that could not be compensated and are left as they were.
    pub left_alone: usize,
}

impl Proved {
    /// The largest error that the commands leave, mm, before they are written.
    pub fn commanded_max_mm(&self) -> Option<f64> {
        self.passes.iter().rev().nth(1).and_then(|own| own.summary.max_mm)
    }
}

/// Why there is no program.
#[derive(Debug)]
pub struct Refused {
    /// Whether the rigid machine cannot be tracked there.
    pub is_out_of_reach: bool,
    /// Index of each point and reason.
    pub failures: Vec<(usize, String)>,
    /// How many points of the program were looked at.
    pub seen: usize,
    /// What the commands leave where there are some, if all points were looked at.
    pub pass: Option<Pass>,
}

impl Asked {
    /// By `method` alone, without comparison.
    pub fn by(method: Method) -> Self {
        Self { way: Way::Method(method), compared: Vec::new(), sources_apart: false, ends_early: false }
    }

    /// Passes over the points of `job` that are told of.
    pub fn passes(&self, job: &ProgramJob) -> usize {
        let sources = if self.sources_apart { Source::of(&job.machine).len() } else { 1 };
        usize::from(self.ends_early) + 1 + self.compared.len() + sources + 1
    }
}

/// Points named of those that are out of reach.
const NAMED: usize = 5;

impl ProgramJob {
    /// Finds commands as `asked`, writes the program, and proves it part by part, which `to` takes. `work` is told of each point of each pass.
    ///
    /// # Errors
    /// Those of [`ProgramJob::bounded_pass`], [`ProgramJob::write`], [`ProgramJob::prove`], of `to` and of `work`.
    pub fn compensate(&self, asked: &Asked, to: &mut impl Receiver, work: &Work) -> Result<Compensated> {
        if asked.ends_early {
            let failures = self.out_of_reach(NAMED, |points| work.tell(Event::Computed(points)))?;
            if !failures.is_empty() {
                return Ok(Compensated::Refused(Refused { is_out_of_reach: true, failures, seen: 0, pass: None }));
            }
        }
        let done = || work.tell(Event::Computed(1));
        // First what is asked for: where there is no command, the others are of no use.
        let (mut corrected, mut bounded) = (Corrected::new(self), None);
        let take = |part: &Part<'_>, answers: &[PathAnswer]| {
            corrected.add(self, part, answers);
            if asked.ends_early && !corrected.failures.is_empty() { Err(Error::Stopped) } else { work.check() }
        };
        let own = match &asked.way {
            Way::Mirror(sent) => self.pass("mirror of the measured pass", &ProgramCommands::Sent(sent), &done, take),
            Way::Method(method) => self.pass_by(*method, &done, take),
            Way::Bounded => self.bounded_pass(&done, take).map(|found| {
                bounded = Some(found.path);
                found.pass
            }),
        };
        work.check()?;
        if !corrected.failures.is_empty() {
            // What ended early has its reason in the failures.
            let (seen, pass) = (corrected.seen(), if asked.ends_early { own.ok() } else { Some(own?) });
            let failures = corrected.failures;
            return Ok(Compensated::Refused(Refused { is_out_of_reach: false, failures, seen, pass }));
        }
        let own = own?;
        let mut written = self.write(&corrected)?;
        written.call_beside_only_if(|file| to.may_call(file));
        let left_alone = corrected.left_alone;
        drop(corrected);
        let mut exceedances = bounded.as_ref().map(|bounded| Exceedances::new(self, bounded));
        let name = format!("{}, as written", own.name);
        let mut passes = self.prove((name, &written), asked, &done, |proved| {
            work.check()?;
            exceedances.iter_mut().for_each(|exceedances| exceedances.add(proved.part.first, proved.written));
            to.take(proved, bounded.as_ref())
        })?;
        let exceeded = exceedances.map(Exceedances::worst);
        passes.insert(passes.len() - 1, own);
        Ok(Compensated::Proved(Box::new(Proved { passes, written, bounded, exceeded, left_alone })))
    }
}
