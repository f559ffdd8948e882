//! Shared parts of the commands that write result folders: their options, running a study into its folder, and reporting it.

use std::{path::PathBuf, sync::Arc, time::Instant};

use clap::Args;
use kinetostat::{
    figures::Colours,
    files::exchange::{Format, WrittenRows},
    input::error::{Error, Remedy, Result},
    questions::{Overrides, Study},
    run::{BegunRun, FinishedRun, FolderRun, RunOptions, Start},
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
    /// Returns whether to resume a run, restart it, or begin a new one.
    pub fn begin(&self) -> Start {
        match (self.resume, self.restart) {
            (true, _) => Start::Resume,
            (_, true) => Start::Restart,
            _ => Start::New,
        }
    }

    /// Creates the thread pool of the computation.
    pub fn pool(&self) -> Result<ThreadPool> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(self.threads.map_or(0, usize::from)).build();
        pool.map_err(|e| Error::argument("--threads", e.to_string()))
    }

    /// Reports that `study` was stopped after `done`, or failed; `is_kept` if a failed run can be resumed.
    pub fn report_unfinished(
        &self,
        study: &Study,
        progress: &Progress,
        done: &str,
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
    /// Returns the options of a run: formats, rows, figures, colours, and how to begin.
    pub fn options(&self, computing: &Computing, rows: WrittenRows) -> RunOptions {
        RunOptions {
            formats: self.format.clone(),
            rows,
            figures: !self.no_figures,
            colours: self.colours,
            begin: computing.begin(),
            program: None,
        }
    }
}

/// Returns an error of the library in words of the command line.
pub fn as_option_error(error: Error) -> Error {
    match error {
        Error::Value { file, key, problem, .. } if file == Overrides::ORIGIN => {
            Error::argument(format!("--{key}"), problem)
        }
        Error::Resume { file, problem, remedy } => {
            let problem = match remedy {
                Remedy::ResumeOrRestart => format!("{problem}; --resume goes on, --restart begins anew"),
                Remedy::Restart => format!("{problem}; --restart begins anew"),
                Remedy::Elsewhere => problem,
            };
            Error::Resume { file, problem, remedy }
        }
        other => other,
    }
}

/// Returns the folder for the results of `study`: `out`, if it is given.
pub fn result_folder(out: Option<&PathBuf>, study: &Study) -> PathBuf {
    out.cloned().unwrap_or_else(|| PathBuf::from("results").join(&study.name))
}

/// Computes the study of `run`, begun by `begin`, and prints its results.
pub fn run_study<'a>(
    computing: &Computing,
    writing: &Writing,
    run: &'a FolderRun<'a>,
    begin: impl FnOnce() -> Result<BegunRun<'a>>,
) -> Result<Ending> {
    let (study, started) = (run.study(), Instant::now());
    let pool = computing.pool()?;
    let begun = begin().map_err(as_option_error)?;
    computing.reporting.print(&format!("{}\n\n", study.question))?;
    let (total, of) = study.kind.items();
    let progress = computing.reporting.progress(&study.name, total, of);
    let (watcher, stop) = (Arc::clone(&progress), stop_flag()?);
    let ended = pool.install(|| begun.run(stop, move |event| watcher.record(event)));
    let done = progress.end();
    match ended {
        Ok(finished) => {
            let seconds = started.elapsed().as_secs_f64();
            print_result(&computing.reporting, writing, run, &finished, seconds)?;
            let threads = pool.current_num_threads();
            log_finished(&progress, run, &finished, seconds, threads);
            Ok(Ending::of(finished.is_complete))
        }
        Err(error) => computing.report_unfinished(study, &progress, &done, run.is_unfinished(), error),
    }
}

/// Prints the main result and where the rest is; everything if verbose.
fn print_result(
    reporting: &Reporting,
    writing: &Writing,
    run: &FolderRun<'_>,
    finished: &FinishedRun,
    seconds: f64,
) -> Result<()> {
    reporting.print_styled(&headline::result_text(&finished.headline, &format!("{seconds:.1} s")))?;
    if reporting.is_verbose() {
        reporting.print(&format!("\n{}\n", finished.details))?;
    }
    for rows in &finished.rows {
        reporting.print(&format!("{rows}\n"))?;
    }
    reporting.print_written(run.out(), &finished.files, writing.format.contains(&Format::Csv))?;
    let has_image = finished.files.iter().any(|file| file.extension() == Some("vti".as_ref()));
    if writing.format.contains(&Format::Vti) && !has_image {
        reporting.print("No .vti: this kind of study has no map over the workspace.\n")?;
    }
    Ok(())
}

/// Reports the end of the run to the log and to programs that watch.
fn log_finished(progress: &Progress, run: &FolderRun<'_>, finished: &FinishedRun, seconds: f64, threads: usize) {
    let (study, out, statuses) = (run.study(), run.out(), &finished.statuses);
    let counts: Vec<String> = statuses.iter().map(|count| format!("{} {}", count.rows, count.status)).collect();
    let (counts, count, folder) = (counts.join(", "), finished.files.len(), out.display());
    log::info!("{}: {counts} in {seconds:.1} s, {count} files written to {folder}", study.name);
    progress.line(json!({
        "event": "finished",
        "study": study.name,
        "statuses": statuses,
        "wall_time_s": seconds,
        "threads": threads,
        "folder": out,
    }));
}
