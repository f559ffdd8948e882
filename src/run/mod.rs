//! Studies begun and run in folders, resumed, shared in parts and merged. What is refused before a run begins (an unfinished run that would be
//! lost, files that are not ours), kept piece by piece, gone on with after a stop, written whole.

mod examples;
pub mod new_study;
pub mod parts;

pub use examples::{EXAMPLES, Example};

use std::{
    path::{Path, PathBuf},
    sync::{Arc, atomic::AtomicBool},
};

use serde::Serialize;
use serde_json::Value;

use crate::{
    answer::{Output, Run},
    explore::Scene,
    figures::Colours,
    files::{
        Manifest, OutputLock, StatusCount,
        exchange::{Format, WrittenRows},
        lock_folder, prepare, remove,
    },
    input::error::{Error, Remedy, Result},
    page::{Interactive, PAGE, headline::Headline},
    questions::{Overrides, Study, StudyKind, page_kind},
    work::{
        Event, Work,
        checkpoint::{Checkpoint, ExistingPieces, Origin},
        part_file::{Part, Parts},
    },
};

/// How a study is run into a folder.
#[derive(Debug, Clone)]
pub struct RunOptions {
    /// Formats of tables and maps; without CSV there is no page.
    pub formats: Vec<Format>,
    /// Which rows of tables of path points are written as CSV.
    pub rows: WrittenRows,
    /// Whether figures are drawn.
    pub figures: bool,
    /// Colours of maps in figures.
    pub colours: Colours,
    /// What becomes of an unfinished run in the folder.
    pub begin: Start,
    /// The build of the program, whose pieces another one does not take over; the running executable if not given, which
    /// a program that loads this library otherwise (an extension of Python) must not rely on.
    pub program: Option<String>,
}

impl Default for RunOptions {
    /// Returns options for CSV tables, a page, and figures in viridis; an unfinished run is not lost.
    fn default() -> Self {
        let (colours, begin) = (Colours::Viridis, Start::default());
        Self { formats: vec![Format::Csv], rows: WrittenRows::default(), figures: true, colours, begin, program: None }
    }
}

/// How a run starts in a folder that holds an unfinished one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Start {
    /// It is refused.
    #[default]
    New,
    /// The unfinished run is gone on with; without one, a new run starts.
    Resume,
    /// A new run starts; the pieces of the unfinished one are lost.
    Restart,
}

/// Results of a run.
#[derive(Debug, Clone, Serialize)]
pub struct FinishedRun {
    /// The answer at a glance.
    pub headline: Headline,
    /// Everything it says, in sentences and small tables.
    pub details: String,
    /// Whether everything that was asked is answered; if not, the tables say what is not and why.
    pub is_complete: bool,
    /// Sentences on the tables whose files do not have all rows.
    pub rows: Vec<String>,
    /// How many rows ended how.
    pub statuses: Vec<StatusCount>,
    /// The files, manifest last.
    pub files: Vec<PathBuf>,
}

/// A run that may begin: its folder is there and can be written, and nothing in it would be lost.
#[derive(Debug)]
pub struct FolderRun<'a> {
    study: &'a Study,
    out: PathBuf,
    options: RunOptions,
    origin: Origin,
    /// Whether the folder was made for it.
    is_new: bool,
}

/// A run that keeps its pieces in the folder from here on.
#[derive(Debug)]
pub struct BegunRun<'a> {
    run: &'a FolderRun<'a>,
    checkpoint: Checkpoint,
    parts: Option<Parts>,
    lock: OutputLock,
}

impl BegunRun<'_> {
    /// Computes and writes everything, see [`Study::run_into`]. First `watch` is told what is taken over ([`Event::Resumed`]).
    ///
    /// # Errors
    /// [`Error::Stopped`], and whatever cannot be read, drawn or written; what was computed is then kept in the folder, see
    /// [`FolderRun::is_unfinished`].
    pub fn run(self, stop: Arc<AtomicBool>, watch: impl Fn(Event) + Send + Sync + 'static) -> Result<FinishedRun> {
        let Self { run, checkpoint, parts, lock: _lock } = self;
        let resumed = Event::Resumed { pieces: checkpoint.len(), lost: checkpoint.damaged_count() };
        let work = Work::with_parts(Some(checkpoint), parts, None, stop, Box::new(watch));
        work.tell(resumed);
        match run.answer(&work) {
            // Nothing is left to go on with once the results are written.
            Ok(finished) => remove(&run.out.join(STATE)).map(|()| finished),
            Err(Error::Stopped) => Err(Error::Stopped),
            Err(_) if !run.out.is_dir() => {
                let problem = "the folder was removed during the run, and with it what was computed";
                Err(Error::Write { file: run.out.clone(), source: std::io::Error::other(problem) })
            }
            Err(error) => {
                if work.pieces() == 0 {
                    remove(&run.out.join(STATE))?;
                }
                Err(error)
            }
        }
    }
}

/// What a run has computed so far, in its result folder.
const STATE: &str = "unfinished_run.state";
/// Most points of a VTK image, which is made in one piece.
const MAX_IMAGE_POINTS: usize = 2_000_000;

impl Study {
    /// Runs the study on the current rayon pool and writes tables, figures, summary, page and manifest into the folder
    /// `out`. Whoever sets `stop` stops it; `watch` is told how far it is, by any thread. The same study gives the same
    /// bytes on any number of threads, stopped and resumed or not.
    ///
    /// # Errors
    /// As [`Study::prepare_run`], [`FolderRun::begin`] and [`BegunRun::run`].
    pub fn run_into(
        &self,
        out: &Path,
        options: &RunOptions,
        stop: Arc<AtomicBool>,
        watch: impl Fn(Event) + Send + Sync + 'static,
    ) -> Result<FinishedRun> {
        self.prepare_run(out, options)?.begin()?.run(stop, watch)
    }

    /// Checks that the study has the formats of `options`, and that this program can write them.
    ///
    /// # Errors
    /// Only maps can be images, and not of any size.
    pub fn check_formats(&self, options: &RunOptions) -> Result<()> {
        let (name, map_points, formats) = (&self.name, self.kind.image_points(), &options.formats);
        let refuse = |problem| Overrides::location("format").fail(problem);
        if let Some(not_built) = formats.iter().find_map(|format| format.check_built().err()) {
            return refuse(not_built.to_string());
        }
        match map_points {
            _ if formats.is_empty() => refuse("expected at least one".into()),
            Some(points) if formats.contains(&Format::Vti) && points > MAX_IMAGE_POINTS => {
                refuse(format!("an image has at most {MAX_IMAGE_POINTS} points, the grid of {name} {points}"))
            }
            None if formats.iter().all(|format| *format == Format::Vti) => {
                refuse(format!("study {name} has no map over the workspace for vti; expected csv or parquet, too"))
            }
            _ => Ok(()),
        }
    }

    /// Checks, before anything is computed, that the study can be run into the folder `out`, and makes the folder.
    ///
    /// # Errors
    /// A format that the study does not have, a folder that cannot be written, files in it that are not ours to replace, or
    /// an unfinished run that is not to be gone on with.
    pub fn prepare_run(&self, out: &Path, options: &RunOptions) -> Result<FolderRun<'_>> {
        self.check_formats(options)?;
        let origin = Origin::of(options.program.as_deref(), self.inputs.clone())?;
        let is_new = !out.exists();
        let run = FolderRun { study: self, out: out.to_path_buf(), options: options.clone(), origin, is_new };
        prepare(out)?;
        Manifest::check_may_write(out, run.main_files().iter().map(String::as_str))?;
        protect_unfinished_run(&out.join(STATE), &run.origin, options.begin)?;
        Ok(run)
    }
}

/// Why places are not tried where bodies may be in the way.
const NO_BODIES: &str = "the engine in the page does not look at bodies";

/// Returns the scene in which a reader of the page can try the workpiece at other places, or why none can; `None` without a workpiece.
fn interactive_scene(study: &Study, best: Option<Value>) -> Result<Option<Interactive>> {
    let nothing = |why: &str| Ok(Some(Interactive::Nothing(format!("Other places cannot be tried here: {why}."))));
    match &study.kind {
        StudyKind::Path(path, _) if path.gamma_search.is_some() => {
            return nothing("the rotation about the tool axis was sought for this one");
        }
        StudyKind::Placement(placement, _) if placement.features.iter().any(|job| job.gamma_search.is_some()) => {
            return nothing("this study seeks the rotation about the tool axis at each place, which the page cannot");
        }
        StudyKind::Placement(placement, _)
            if placement.features.iter().any(|job| !job.feature.path.engagements().is_empty()) =>
        {
            return nothing("the engine in the page cannot cut stock");
        }
        StudyKind::Placement(placement, _) if placement.features.iter().any(|job| job.bodies.is_some()) => {
            return nothing(NO_BODIES);
        }
        StudyKind::Path(path, _) if path.cell.is_some() => return nothing(NO_BODIES),
        _ => {}
    }
    let scene = match Scene::from_study(study) {
        Ok(Some(scene)) => scene,
        Ok(None) => return Ok(None),
        // The study has an answer all the same.
        Err(reason) => return nothing(&reason.to_string()),
    };
    let fault = |fault: serde_json::Error| Error::Page { template: PAGE.into(), problem: fault.to_string() };
    let mut scene = serde_json::to_value(&scene).map_err(fault)?;
    if let Some(best) = best {
        scene["best"] = best;
    }
    Ok(Some(Interactive::Scene(scene)))
}

impl FolderRun<'_> {
    /// Returns the study that is run.
    pub fn study(&self) -> &Study {
        self.study
    }

    /// Returns the folder into which it is run.
    pub fn out(&self) -> &Path {
        &self.out
    }

    /// Returns whether the folder holds what an unfinished run has computed.
    pub fn is_unfinished(&self) -> bool {
        self.out.join(STATE).is_file()
    }

    /// Opens the checkpoint: that of an unfinished run, if it is to be resumed, or a new one.
    ///
    /// # Errors
    /// An unfinished run that cannot be resumed, or a file that cannot be written.
    pub fn begin(&self) -> Result<BegunRun<'_>> {
        let checkpoint = open_checkpoint(&self.out.join(STATE), &self.origin, self.options.begin)?;
        let lock = lock_folder(&self.out)?;
        Ok(BegunRun { run: self, checkpoint, parts: None, lock })
    }

    /// Opens the checkpoint as [`FolderRun::begin`], with the pieces that `parts` have computed.
    ///
    /// # Errors
    /// As [`Parts::new`] and [`FolderRun::begin`].
    pub fn begin_from(&self, parts: Vec<Part>) -> Result<BegunRun<'_>> {
        let parts = Parts::new(parts, &self.origin).or_else(|refused| {
            // Nothing is in it yet.
            if self.is_new {
                std::fs::remove_dir(&self.out).map_err(|source| Error::Write { file: self.out.clone(), source })?;
            }
            Err(refused)
        })?;
        Ok(BegunRun { parts: Some(parts), ..self.begin()? })
    }

    /// Computes the study with `work` and writes its results into the folder.
    fn answer(&self, work: &Work) -> Result<FinishedRun> {
        let Self { study, out, options, .. } = self;
        let run = Run { out, formats: &options.formats, rows: options.rows, figures: options.figures, work };
        let mut output = study.kind.answer(&run)?;
        (output.page.name, output.page.question) = (study.name.clone(), study.question.clone());
        output.page.interactive = interactive_scene(study, output.best_place.take())?;
        let rows = output.streamed.1.iter().filter_map(|(_, table)| table.note().map(String::from)).collect();
        let files = output.write(&run, page_kind(&output.page.kind), options.colours, &study.inputs)?;
        let is_complete = output.is_complete();
        let Output { page, details, statuses, .. } = output;
        Ok(FinishedRun { headline: page.headline, details, is_complete, rows, statuses, files })
    }

    /// Returns the names of the study's main result files. The others are checked against the folder before the first of all is written.
    fn main_files(&self) -> Vec<String> {
        let stems = self.study.kind.tables();
        let endings = self.options.formats.iter().map(|format| format.label());
        let tables = endings.flat_map(|ending| stems.iter().map(move |table| format!("{table}.{ending}")));
        tables.chain(["summary.json", "report.json", PAGE].map(String::from)).collect()
    }
}

/// Opens the checkpoint `state`, if an unfinished run is to be resumed, or creates it anew.
pub(crate) fn open_checkpoint(state: &Path, origin: &Origin, begin: Start) -> Result<Checkpoint> {
    match begin {
        Start::Resume if state.is_file() => Checkpoint::resume(state, origin),
        _ => Checkpoint::create(state, origin),
    }
}

/// Returns an error if `state` holds what an unfinished run has computed, unless `begin` says what becomes of that.
pub(crate) fn protect_unfinished_run(state: &Path, origin: &Origin, begin: Start) -> Result<()> {
    if begin != Start::New {
        return Ok(());
    }
    let (problem, remedy) = match Checkpoint::find(state, origin)? {
        ExistingPieces::Nothing => return Ok(()),
        ExistingPieces::Same => ("holds what an unfinished run has computed".into(), Remedy::ResumeOrRestart),
        ExistingPieces::Other(change) => {
            (format!("holds what an unfinished run of something else has computed ({change})"), Remedy::Restart)
        }
    };
    Err(Error::Resume { file: state.to_path_buf(), problem, remedy })
}
