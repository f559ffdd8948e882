//! `kinetostat run`: computes a study and writes its tables, figures and page.

use std::{
    io::Write,
    path::PathBuf,
    sync::{Arc, atomic::Ordering},
    time::Instant,
};

use clap::Args;
use kinetostat::{
    input::error::{Error, Result, Way},
    machine::Branch,
    process::Redundancy,
    report::{exchange::Format, figures::Colours, page::PAGE},
    study::{Begin, Finished, FolderRun, Overrides, RunOptions, Study},
};
use serde_json::json;

use super::{
    Ending, choice, headline,
    progress::Progress,
    reporting::{Reporting, stop_flag},
};

/// Compute a study: its tables, figures, a summary of its answer and a page that shows them.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  kinetostat run studies/01_workspace_map
  kinetostat run studies/*                                     (all of them, one after another)
  kinetostat run studies/01_workspace_map --grid 21            (21 points along each axis)
  kinetostat run studies/01_workspace_map --grid 5,5,3 --out /tmp/quick --threads 1
  kinetostat run studies/07_robot_arm --branch front-up-flip
  kinetostat run my_robot_path --redundancy best               (the turn about the tool's axis that deflects least)
  kinetostat run studies/01_workspace_map --colours cividis
  kinetostat run studies/01_workspace_map --format csv,parquet,vti  (built with --features parquet,vtk)
  kinetostat run studies/01_workspace_map --grid 101 --resume  (go on where Ctrl-C, or a power cut, stopped it)
  kinetostat run studies/* --progress json --log night.log 2> progress.jsonl

Beside its tables a result folder has summary.json and manifest.json. csv-metadata.json describes the columns of CSV files,
map.vti.json the arrays and status numbers of map.vti. What is computed is kept in unfinished_run.state until the results are
written: with --resume a run that was stopped or killed ends with the same bytes as one that was not.")]
pub struct RunArguments {
    /// Study folders (with a study.toml), or study files
    #[arg(required = true)]
    studies: Vec<PathBuf>,
    /// Grid points along x,y,z, or one number for all, instead of the study's
    #[arg(long, value_parser = grid, allow_hyphen_values = true)]
    grid: Option<[usize; 3]>,
    /// Points along the circle of a path study, instead of the study's
    #[arg(long)]
    points: Option<usize>,
    /// Branch on which an arm with a spherical wrist is to stand, instead of the study's
    #[arg(long, value_parser = choice::branch())]
    branch: Option<Branch>,
    /// Turn about the tool's axis along the path of a path study, instead of that of [tool_turn] of the process
    #[arg(long, value_parser = choice::redundancy())]
    redundancy: Option<Redundancy>,
    /// Folder for the results of a single study [default: results/<name of the study's folder>]
    #[arg(long)]
    out: Option<PathBuf>,
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
    /// Write tables and the page only
    #[arg(long)]
    no_figures: bool,
    /// Formats of tables and maps, separated by commas; without csv there is no page
    #[arg(long, value_parser = choice::format(), value_delimiter = ',', default_value = "csv")]
    format: Vec<Format>,
    /// Colours of maps in figures
    #[arg(long, value_parser = choice::colours(), default_value = "viridis")]
    colours: Colours,
    #[command(flatten)]
    reporting: Reporting,
}

/// Counts along three axes, or one for all.
pub(super) fn grid(text: &str) -> std::result::Result<[usize; 3], String> {
    let parse = |part: &str| part.trim().parse::<usize>().map_err(|_| format!("\"{part}\" is not a count"));
    match text.split(',').map(parse).collect::<std::result::Result<Vec<_>, _>>()?.as_slice() {
        [n] => Ok([*n; 3]),
        [x, y, z] => Ok([*x, *y, *z]),
        other => Err(format!("expected one count or three, got {}", other.len())),
    }
}

pub fn run(arguments: &RunArguments) -> Result<Ending> {
    arguments.reporting.start_log()?;
    if let (Some(out), [_, _, ..]) = (&arguments.out, arguments.studies.as_slice()) {
        let problem = format!("{} can hold the results of one study, got {}", out.display(), arguments.studies.len());
        return Err(Error::Argument { argument: "--out".into(), problem });
    }
    let overrides = Overrides {
        grid: arguments.grid,
        points: arguments.points,
        branch: arguments.branch,
        redundancy: arguments.redundancy,
        ..Overrides::default()
    };
    let opened = arguments.studies.iter().map(|path| Study::open(path, &overrides));
    let studies: Vec<Study> = opened.collect::<Result<_>>().map_err(in_options)?;
    for (i, study) in studies.iter().enumerate() {
        if studies[..i].iter().any(|other| other.name == study.name) {
            let problem = format!("two studies are called \"{}\" and would share a result folder", study.name);
            return Err(Error::Argument { argument: arguments.studies[i].display().to_string(), problem });
        }
    }
    let options = options(arguments);
    studies.iter().try_for_each(|study| study.check_formats(&options)).map_err(in_options)?;
    let runs = studies.iter().map(|study| study.may_run_into(&folder(arguments, study), &options));
    let runs: Vec<FolderRun<'_>> = runs.collect::<Result<_>>().map_err(in_options)?;
    if stop_flag()?.load(Ordering::Relaxed) {
        arguments.reporting.print("Stopped before anything was computed.\n")?;
        return Ok(Ending::Stopped);
    }
    let mut ending = Ending::Complete;
    for run in &runs {
        match run_study(arguments, run)? {
            Ending::Complete => {}
            Ending::SomeUnsolved => ending = Ending::SomeUnsolved,
            Ending::Stopped => return Ok(Ending::Stopped),
        }
    }
    Ok(ending)
}

fn options(arguments: &RunArguments) -> RunOptions {
    RunOptions {
        formats: arguments.format.clone(),
        figures: !arguments.no_figures,
        colours: arguments.colours,
        begin: match (arguments.resume, arguments.restart) {
            (true, _) => Begin::Resume,
            (_, true) => Begin::Restart,
            _ => Begin::New,
        },
        program: None,
    }
}

/// An error of the library in words of the command line.
fn in_options(error: Error) -> Error {
    match error {
        Error::Value { file, key, problem } if file == Overrides::ORIGIN => {
            Error::Argument { argument: format!("--{key}"), problem }
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

/// The folder for the results of `study`.
fn folder(arguments: &RunArguments, study: &Study) -> PathBuf {
    arguments.out.clone().unwrap_or_else(|| PathBuf::from("results").join(&study.name))
}

fn run_study(arguments: &RunArguments, run: &FolderRun<'_>) -> Result<Ending> {
    let (study, started) = (run.study(), Instant::now());
    let threads = arguments.threads.map_or(0, usize::from);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    let pool = pool.map_err(|e| Error::Argument { argument: "--threads".into(), problem: e.to_string() })?;
    let begun = run.begin().map_err(in_options)?;
    arguments.reporting.print(&format!("{}\n\n", study.question))?;
    let (total, of) = study.kind.items();
    let progress = arguments.reporting.progress(&study.name, total, of);
    let (watcher, stop) = (Arc::clone(&progress), stop_flag()?);
    let ended = pool.install(|| begun.run(stop, move |event| watcher.tell(event)));
    let done = progress.end();
    match ended {
        Ok(finished) => {
            let seconds = started.elapsed().as_secs_f64();
            tell_answer(arguments, run, &finished, seconds)?;
            let threads = pool.current_num_threads();
            tell(&progress, run, &finished, (seconds, threads));
            Ok(if finished.is_complete { Ending::Complete } else { Ending::SomeUnsolved })
        }
        Err(Error::Stopped) => {
            let name = &study.name;
            log::info!("{name}: stopped after {done}");
            progress.line(json!({ "event": "stopped", "study": name }));
            let text = format!("{name}: stopped after {done}. The same command with --resume goes on.\n");
            arguments.reporting.print(&text)?;
            Ok(Ending::Stopped)
        }
        Err(error) => {
            if run.is_unfinished() {
                log::info!("{}: what was computed is kept; --resume goes on", study.name);
                let _ =
                    writeln!(std::io::stderr(), "What was computed is kept; the same command with --resume goes on.");
            }
            progress.line(json!({ "event": "failed", "study": study.name, "message": error.to_string() }));
            Err(error)
        }
    }
}

/// The answer at a glance and where more of it stands; all of it where everything is wanted.
fn tell_answer(arguments: &RunArguments, run: &FolderRun<'_>, finished: &Finished, seconds: f64) -> Result<()> {
    let reporting = &arguments.reporting;
    reporting.print_styled(&headline::words(&finished.headline, &format!("{seconds:.1} s")))?;
    let names = finished.files.iter().map(|path| path.file_name().unwrap_or_default().to_string_lossy());
    let out = run.out();
    let mut closing = String::new();
    if reporting.is_verbose() {
        closing += &format!("\n{}\nWritten to {}:\n", finished.details, out.display());
        names.clone().for_each(|name| closing += &format!("  {name}\n"));
    } else if arguments.format.contains(&Format::Csv) {
        closing += &format!("Results in {}, to read as {}\n", out.display(), out.join(PAGE).display());
    } else {
        closing += &format!("Results in {}\n", out.display());
    }
    if arguments.format.contains(&Format::Vti) && !names.into_iter().any(|name| name.ends_with(".vti")) {
        closing += "No .vti: this kind of study has no map over the workspace.\n";
    }
    reporting.print(&closing)
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
