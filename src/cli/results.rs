//! What the commands that leave result folders have in common: their options, a study run into its folder, what is told
//! of it.

use std::{path::PathBuf, sync::Arc, time::Instant};

use clap::Args;
use kinetostat::{
    figures::Colours,
    files::exchange::Format,
    input::error::{Error, Result, Way},
    questions::{Overrides, Study},
    run::{Begin, BegunRun, Finished, FolderRun, RunOptions},
};
use rayon::ThreadPool;
use serde_json::json;

use super::{
    Ending, choice, headline,
    progress::Progress,
    reporting::{Reporting, stop_flag},
};

/// Threads and folder of a computation that keeps its pieces.
#[derive(Debug, Args)]
pub struct Computing {
    /// Threads [default: all processors]
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// Go on with the run that was stopped or killed in the same folder; without one, begin. Studies whose results are
    /// complete are computed again
    #[arg(long, conflicts_with = "restart")]
    resume: bool,
    /// Begin anew although the folder holds an unfinished run, whose pieces are lost
    #[arg(long)]
    restart: bool,
    #[command(flatten)]
    pub reporting: Reporting,
}

/// What is written into a result folder.
#[derive(Debug, Args)]
pub struct Writing {
    /// Write tables and the page only
    #[arg(long)]
    no_figures: bool,
    /// Formats of tables and maps, separated by commas; without csv there is no page
    #[arg(long, value_parser = choice::format(), value_delimiter = ',', default_value = "csv")]
    format: Vec<Format>,
    /// Colours of maps in figures
    #[arg(long, value_parser = choice::colours(), default_value = "viridis")]
    colours: Colours,
}

impl Computing {
    pub fn begin(&self) -> Begin {
        match (self.resume, self.restart) {
            (true, _) => Begin::Resume,
            (_, true) => Begin::Restart,
            _ => Begin::New,
        }
    }

    pub fn pool(&self) -> Result<ThreadPool> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(self.threads.map_or(0, usize::from)).build();
        pool.map_err(|e| Error::argument("--threads", e.to_string()))
    }

    /// Says that `study` was stopped after `done`, or failed; `is_kept` where a failed one can be gone on with.
    pub fn tell_unfinished(
        &self,
        study: &Study,
        (progress, done): (&Progress, &str),
        is_kept: bool,
        error: Error,
    ) -> Result<Ending> {
        let name = &study.name;
        if matches!(error, Error::Stopped) {
            log::info!("{name}: stopped after {done}");
            progress.line(json!({ "event": "stopped", "study": name }));
            self.reporting
                .print(&format!("{name}: stopped after {done}. The same command with --resume goes on.\n"))?;
            return Ok(Ending::Stopped);
        }
        if is_kept {
            log::info!("{name}: what was computed is kept; --resume goes on");
            super::say("What was computed is kept; the same command with --resume goes on.");
        }
        progress.line(json!({ "event": "failed", "study": name, "message": error.to_string() }));
        Err(error)
    }
}

impl Writing {
    pub fn options(&self, computing: &Computing) -> RunOptions {
        RunOptions {
            formats: self.format.clone(),
            figures: !self.no_figures,
            colours: self.colours,
            begin: computing.begin(),
            program: None,
        }
    }
}

/// An error of the library in words of the command line.
pub fn in_options(error: Error) -> Error {
    match error {
        Error::Value { file, key, problem } if file == Overrides::ORIGIN => {
            Error::argument(format!("--{key}"), problem)
        }
        Error::Resume { file, problem, way } => {
            let problem = match way {
                Way::ResumeOrRestart => format!("{problem}; --resume goes on, --restart begins anew"),
                Way::Restart => format!("{problem}; --restart begins anew"),
                Way::Elsewhere => problem,
            };
            Error::Resume { file, problem, way }
        }
        other => other,
    }
}

/// The folder for the results of `study`: `out`, if it is given.
pub fn folder(out: Option<&PathBuf>, study: &Study) -> PathBuf {
    out.cloned().unwrap_or_else(|| PathBuf::from("results").join(&study.name))
}

/// Computes the study of `run` as `begin` does, and says what it has found.
pub fn run_study<'a>(
    computing: &Computing,
    writing: &Writing,
    run: &'a FolderRun<'a>,
    begin: impl FnOnce() -> Result<BegunRun<'a>>,
) -> Result<Ending> {
    let (study, started) = (run.study(), Instant::now());
    let pool = computing.pool()?;
    let begun = begin().map_err(in_options)?;
    computing.reporting.print(&format!("{}\n\n", study.question))?;
    let (total, of) = study.kind.items();
    let progress = computing.reporting.progress(&study.name, total, of);
    let (watcher, stop) = (Arc::clone(&progress), stop_flag()?);
    let ended = pool.install(|| begun.run(stop, move |event| watcher.tell(event)));
    let done = progress.end();
    match ended {
        Ok(finished) => {
            let seconds = started.elapsed().as_secs_f64();
            tell_answer(&computing.reporting, writing, run, &finished, seconds)?;
            let threads = pool.current_num_threads();
            tell(&progress, run, &finished, (seconds, threads));
            Ok(Ending::of(finished.is_complete))
        }
        Err(error) => computing.tell_unfinished(study, (&progress, &done), run.is_unfinished(), error),
    }
}

/// The answer at a glance and where more of it stands; all of it where everything is wanted.
fn tell_answer(
    reporting: &Reporting,
    writing: &Writing,
    run: &FolderRun<'_>,
    finished: &Finished,
    seconds: f64,
) -> Result<()> {
    reporting.print_styled(&headline::words(&finished.headline, &format!("{seconds:.1} s")))?;
    if reporting.is_verbose() {
        reporting.print(&format!("\n{}\n", finished.details))?;
    }
    reporting.print_written(run.out(), &finished.files, writing.format.contains(&Format::Csv))?;
    if writing.format.contains(&Format::Vti)
        && !finished.files.iter().any(|file| file.extension() == Some("vti".as_ref()))
    {
        reporting.print("No .vti: this kind of study has no map over the workspace.\n")?;
    }
    Ok(())
}

/// The end of the run for the log and for programs that watch.
fn tell(progress: &Progress, run: &FolderRun<'_>, finished: &Finished, (seconds, threads): (f64, usize)) {
    let (study, out, statuses) = (run.study(), run.out(), &finished.statuses);
    let counts: Vec<String> = statuses.iter().map(|count| format!("{} {}", count.rows, count.status)).collect();
    log::info!(
        "{}: {} in {seconds:.1} s, {} files written to {}",
        study.name,
        counts.join(", "),
        finished.files.len(),
        out.display()
    );
    progress.line(json!({
        "event": "finished",
        "study": study.name,
        "statuses": statuses,
        "wall_time_s": seconds,
        "threads": threads,
        "folder": out,
    }));
}
