//! A study run into a folder: what is refused before it begins (an unfinished run that would be lost, files that are
//! not ours), kept piece by piece, gone on with after a stop, written whole.

use std::{
    path::{Path, PathBuf},
    sync::{Arc, atomic::AtomicBool},
};

use serde::Serialize;

use super::Study;
use crate::{
    input::error::{Error, Result},
    report::{
        Manifest, Run, StatusCount, clean,
        exchange::{Format, NotBuilt},
        figures::Colours,
        page::PAGE,
        prepare, remove,
    },
    work::{
        Event, Work,
        checkpoint::{Checkpoint, Found, Origin},
    },
};

/// How a study is run into a folder.
#[derive(Debug, Clone)]
pub struct RunOptions {
    /// Formats of tables and maps; without CSV there is no page.
    pub formats: Vec<Format>,
    /// Whether figures are drawn.
    pub figures: bool,
    /// Colours of maps in figures.
    pub colours: Colours,
    /// What becomes of an unfinished run in the folder.
    pub begin: Begin,
}

impl Default for RunOptions {
    /// CSV tables, a page, and figures in viridis; refuses to lose an unfinished run.
    fn default() -> Self {
        Self { formats: vec![Format::Csv], figures: true, colours: Colours::Viridis, begin: Begin::default() }
    }
}

/// What becomes of an unfinished run in the folder.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Begin {
    /// It is refused to begin.
    #[default]
    New,
    /// It is gone on with; without one, the run begins.
    Resume,
    /// Its pieces are lost.
    Restart,
}

/// What a run has left.
#[derive(Debug, Clone, Serialize)]
pub struct Finished {
    /// The answer in sentences and small tables.
    pub answer: String,
    /// Whether everything that was asked is answered; if not, the tables say what is not and why.
    pub is_complete: bool,
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
}

/// What a run has computed so far, in its result folder.
const STATE: &str = "unfinished_run.state";
/// Most points of a VTK image, which is made in one piece.
const MOST_IMAGE_POINTS: usize = 2_000_000;

impl Study {
    /// Runs the study on the current rayon pool and writes tables, figures, summary, page and manifest into the folder
    /// `out`. Whoever sets `stop` stops it; `watch` is told how far it is, by any thread. The same study gives the same
    /// bytes on any number of threads, stopped and resumed or not.
    ///
    /// # Errors
    /// As [`Study::may_run_into`] and [`FolderRun::run`].
    pub fn run_into(
        &self,
        out: &Path,
        options: &RunOptions,
        stop: Arc<AtomicBool>,
        watch: impl Fn(Event) + Send + Sync + 'static,
    ) -> Result<Finished> {
        self.may_run_into(out, options)?.run(stop, watch)
    }

    /// Finds out, before anything is computed, whether the study can be run into the folder `out`, and makes the folder.
    ///
    /// # Errors
    /// A format that the study does not have, a folder that cannot be written, files in it that are not ours to replace, or
    /// an unfinished run that is not to be gone on with.
    pub fn may_run_into(&self, out: &Path, options: &RunOptions) -> Result<FolderRun<'_>> {
        let origin = Origin::of(self.inputs.clone())?;
        let run = FolderRun { study: self, out: out.to_path_buf(), options: options.clone(), origin };
        run.check_formats()?;
        prepare(out)?;
        Manifest::may_write(out, run.main_files().iter().map(String::as_str))?;
        run.refuse_to_lose()?;
        Ok(run)
    }

    /// Says whether the folder `out` holds what an unfinished run has computed.
    pub fn is_unfinished_in(out: &Path) -> bool {
        out.join(STATE).is_file()
    }
}

impl FolderRun<'_> {
    /// The study.
    pub fn study(&self) -> &Study {
        self.study
    }

    /// The folder.
    pub fn out(&self) -> &Path {
        &self.out
    }

    /// Computes and writes, see [`Study::run_into`].
    ///
    /// # Errors
    /// [`Error::Stopped`], and whatever cannot be read, drawn or written; what was computed is then kept in the folder.
    pub fn run(&self, stop: Arc<AtomicBool>, watch: impl Fn(Event) + Send + Sync + 'static) -> Result<Finished> {
        let (out, state) = (&self.out, self.out.join(STATE));
        let checkpoint = match self.options.begin {
            Begin::Resume if state.is_file() => Checkpoint::resume(&state, &self.origin)?,
            _ => Checkpoint::create(&state, &self.origin)?,
        };
        clean(out)?;
        let found = Event::Resumed { pieces: checkpoint.len(), lost: checkpoint.damaged() };
        let work = Work::new(Some(checkpoint), stop, Box::new(watch));
        work.tell(found);
        match self.answer(&work) {
            // Nothing is left to go on with once the results are written.
            Ok(finished) => remove(&state).map(|()| finished),
            Err(Error::Stopped) => Err(Error::Stopped),
            Err(_) if !out.is_dir() => {
                let problem = "the folder was removed during the run, and with it what was computed";
                Err(Error::Write { file: out.clone(), source: std::io::Error::other(problem) })
            }
            Err(error) => {
                if work.pieces() == 0 {
                    remove(&state)?;
                }
                Err(error)
            }
        }
    }

    fn answer(&self, work: &Work) -> Result<Finished> {
        let Self { study, out, options, .. } = self;
        let run = Run { out, formats: &options.formats, figures: options.figures, work };
        let mut output = study.kind.answer(&run)?;
        (output.page.name, output.page.question) = (study.name.clone(), study.question.clone());
        let manifest = Manifest {
            program: env!("CARGO_PKG_NAME"),
            version: env!("CARGO_PKG_VERSION"),
            study: study.name.clone(),
            input_sha256: study.inputs.sha256(),
            seed: None,
            settings: output.settings.clone(),
            statuses: output.statuses.clone(),
            files: Vec::new(),
            publishing: false,
        };
        let files = output.write(&run, options.colours, manifest)?;
        Ok(Finished { answer: output.answer, is_complete: output.is_answered, statuses: output.statuses, files })
    }

    /// Only maps can be images, and not of any size.
    fn check_formats(&self) -> Result<()> {
        let (name, map_points) = (&self.study.name, self.study.kind.image_points());
        let refuse = |problem| Err(Error::Argument { argument: "--format vti".into(), problem });
        let formats = &self.options.formats;
        for format in formats {
            let fault = |not_built: NotBuilt| Error::Argument {
                argument: format!("--format {}", format.label()),
                problem: not_built.to_string(),
            };
            format.check_built().map_err(fault)?;
        }
        match map_points {
            Some(points) if formats.contains(&Format::Vti) && points > MOST_IMAGE_POINTS => {
                refuse(format!("an image has at most {MOST_IMAGE_POINTS} points, the grid of {name} {points}"))
            }
            None if formats.iter().all(|format| *format == Format::Vti) => {
                refuse(format!("study {name} has no map over the workspace; expected csv or parquet, too"))
            }
            _ => Ok(()),
        }
    }

    /// The main files of the study. The others are held against the folder before the first of all is written.
    fn main_files(&self) -> Vec<String> {
        let stems = self.study.kind.tables();
        let endings = self.options.formats.iter().map(|format| format.label());
        let tables = endings.flat_map(|ending| stems.iter().map(move |table| format!("{table}.{ending}")));
        tables.chain(["summary.json", "report.json", PAGE].map(String::from)).collect()
    }

    /// What an unfinished run has computed is not replaced unless that is asked for.
    fn refuse_to_lose(&self) -> Result<()> {
        if self.options.begin != Begin::New {
            return Ok(());
        }
        let file = self.out.join(STATE);
        let problem = match Checkpoint::find(&file, &self.origin)? {
            Found::Nothing => return Ok(()),
            Found::Same => "holds what an unfinished run has computed; --resume goes on, --restart begins anew".into(),
            Found::Other(change) => {
                format!("holds what an unfinished run of something else has computed ({change}); --restart begins anew")
            }
        };
        Err(Error::Resume { file, problem })
    }
}
