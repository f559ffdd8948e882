//! `kinetostat run`: computes a study and writes its tables, figures and page.

mod kinds;
mod map;
mod output;
mod path;
mod superposition;

use std::{
    io::Write,
    path::{Path, PathBuf},
    sync::{Arc, atomic::Ordering},
    time::Instant,
};

use clap::Args;
use kinetostat::{
    input::error::{Error, Result},
    report::{Manifest, StatusCount, clean, counted, exchange, prepare, remove},
    study::{Overrides, Study, StudyKind, validation},
    work::{
        Work,
        checkpoint::{Checkpoint, Found, Origin},
    },
};
use serde_json::{Value, json};

use super::{
    Ending,
    output_choice::{ColourMap, Format},
    progress::Progress,
    report::PAGE,
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
  kinetostat run studies/01_workspace_map --format csv,parquet,vti --colours cividis
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
    #[arg(long, value_enum, value_delimiter = ',', default_value = "csv")]
    format: Vec<Format>,
    /// Colours of maps in figures
    #[arg(long, value_enum, default_value = "viridis")]
    colours: ColourMap,
    #[command(flatten)]
    reporting: Reporting,
}

/// What a run has computed so far, in its result folder.
const STATE: &str = "unfinished_run.state";

fn grid(text: &str) -> std::result::Result<[usize; 3], String> {
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
    let overrides = Overrides { grid: arguments.grid, points: arguments.points };
    let studies: Vec<Study> =
        arguments.studies.iter().map(|path| Study::open(path, &overrides)).collect::<Result<_>>()?;
    for (i, study) in studies.iter().enumerate() {
        if studies[..i].iter().any(|other| other.name == study.name) {
            let problem = format!("two studies are called \"{}\" and would share a result folder", study.name);
            return Err(Error::Argument { argument: arguments.studies[i].display().to_string(), problem });
        }
        check_formats(arguments, study)?;
    }
    let program = program()?;
    let origin = |study: &Study| Origin { program: program.clone(), inputs: study.inputs.clone() };
    let studies: Vec<(Origin, Study)> = studies.into_iter().map(|study| (origin(&study), study)).collect();
    for (origin, study) in &studies {
        let out = folder(arguments, study);
        prepare(&out)?;
        Manifest::may_write(&out, main_files(arguments, study).iter().map(String::as_str))?;
        refuse_to_lose(arguments, &out, origin)?;
    }
    if stop_flag()?.load(Ordering::Relaxed) {
        arguments.reporting.print("Stopped before anything was computed.\n")?;
        return Ok(Ending::Stopped);
    }
    let mut ending = Ending::Complete;
    for (origin, study) in &studies {
        match run_study(arguments, study, origin)? {
            Ending::Complete => {}
            Ending::SomeUnsolved => ending = Ending::SomeUnsolved,
            Ending::Stopped => return Ok(Ending::Stopped),
        }
    }
    Ok(ending)
}

/// Most points of a VTK image, which is made in one piece.
const MOST_IMAGE_POINTS: usize = 2_000_000;

/// Only maps can be images, and not of any size.
fn check_formats(arguments: &RunArguments, study: &Study) -> Result<()> {
    let map_points = match &study.kind {
        StudyKind::WorkspaceMap(map) => Some(map.grid.len()),
        StudyKind::Superposition(study) => Some(study.grid.len()),
        _ => None,
    };
    let wants_image = arguments.format.iter().any(|format| matches!(format, Format::Vti));
    if let Some(points) = map_points.filter(|&points| wants_image && points > MOST_IMAGE_POINTS) {
        let problem = format!("an image has at most {MOST_IMAGE_POINTS} points, the grid of {} {points}", study.name);
        return Err(Error::Argument { argument: "--format vti".into(), problem });
    }
    if map_points.is_none() && arguments.format.iter().all(|format| matches!(format, Format::Vti)) {
        let problem = format!("study {} has no map over the workspace; expected csv or parquet, too", study.name);
        return Err(Error::Argument { argument: "--format vti".into(), problem });
    }
    Ok(())
}

/// The main files of a study: what must not be in their places is told before anything is computed. The others are held
/// against the folder before the first of all is written.
fn main_files(arguments: &RunArguments, study: &Study) -> Vec<String> {
    let tables: &[&str] = match &study.kind {
        StudyKind::WorkspaceMap(_) => &["map"],
        StudyKind::Path(_) => &["points", "methods"],
        StudyKind::Placement(_) => &["candidates", "sweep", "refinements", "pareto"],
        StudyKind::Superposition(_) => {
            &["map", "safe_load", "locations", "largest_factors", "scaling", "slopes", "ablation"]
        }
        StudyKind::Validation(_) => &["summary", "variants"],
    };
    let endings = arguments.format.iter().map(|format| format.ending());
    let tables = endings.flat_map(|ending| tables.iter().map(move |table| format!("{table}.{ending}")));
    tables.chain(["summary.json", "report.json", PAGE].map(String::from)).collect()
}

/// The folder for the results of `study`.
fn folder(arguments: &RunArguments, study: &Study) -> PathBuf {
    arguments.out.clone().unwrap_or_else(|| PathBuf::from("results").join(&study.name))
}

/// This program, its very build: pieces of another one are not taken over.
fn program() -> Result<String> {
    let fault = |file: &Path, source| Error::Read { file: file.to_path_buf(), source };
    let file = std::env::current_exe().map_err(|source| fault(Path::new("this program"), source))?;
    let bytes = std::fs::read(&file).map_err(|source| fault(&file, source))?;
    Ok(format!("version {} (build {:08x})", env!("CARGO_PKG_VERSION"), crc32fast::hash(&bytes)))
}

fn run_study(arguments: &RunArguments, study: &Study, origin: &Origin) -> Result<Ending> {
    let threads = arguments.threads.map_or(0, usize::from);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    let pool = pool.map_err(|e| Error::Argument { argument: "--threads".into(), problem: e.to_string() })?;
    let out = folder(arguments, study);
    let checkpoint = checkpoint(arguments, study, &out.join(STATE), origin)?;
    clean(&out)?;
    arguments.reporting.print(&format!("{}\n\n", study.question))?;
    let (total, of) = items(study);
    let progress = arguments.reporting.progress(&study.name, total, of);
    let watcher = Arc::clone(&progress);
    let work = Work::new(Some(checkpoint), stop_flag()?, Box::new(move |event| watcher.tell(event)));
    let run = Run { arguments, study, out: &out, work, progress, started: Instant::now() };
    let ended = pool.install(|| match &study.kind {
        StudyKind::WorkspaceMap(map) => map::run(&run, map),
        StudyKind::Path(path) => path::run(&run, path),
        StudyKind::Placement(placement) => kinds::placement(&run, placement),
        StudyKind::Superposition(superposition) => superposition::run(&run, superposition),
        StudyKind::Validation(validation) => kinds::validation(&run, validation),
    });
    match ended {
        Err(Error::Stopped) => run.stopped(),
        // Nothing is left to go on with once the results are written.
        Ok(ending) => remove(&out.join(STATE)).map(|()| ending),
        Err(_) if !out.is_dir() => {
            run.progress.end();
            let source = std::io::Error::other("the folder was removed during the run, and with it what was computed");
            Err(Error::Write { file: out, source })
        }
        Err(error) => {
            run.progress.end();
            if run.work.pieces() == 0 {
                remove(&out.join(STATE))?;
            } else {
                log::info!("{}: what was computed is kept; --resume goes on", study.name);
                let _ =
                    writeln!(std::io::stderr(), "What was computed is kept; the same command with --resume goes on.");
            }
            run.progress.line(json!({ "event": "failed", "study": study.name, "message": error.to_string() }));
            Err(error)
        }
    }
}

/// What an unfinished run has computed is not replaced unless that is asked for.
fn refuse_to_lose(arguments: &RunArguments, out: &Path, origin: &Origin) -> Result<()> {
    if arguments.resume || arguments.restart {
        return Ok(());
    }
    let file = out.join(STATE);
    let problem = match Checkpoint::find(&file, origin)? {
        Found::Nothing => return Ok(()),
        Found::Same => "holds what an unfinished run has computed; --resume goes on, --restart begins anew".into(),
        Found::Other(change) => {
            format!("holds what an unfinished run of something else has computed ({change}); --restart begins anew")
        }
    };
    Err(Error::Resume { file, problem })
}

/// The pieces of this run: those of the one before, if it is to go on.
fn checkpoint(arguments: &RunArguments, study: &Study, state: &Path, origin: &Origin) -> Result<Checkpoint> {
    if !arguments.resume || !state.is_file() {
        return Checkpoint::create(state, origin);
    }
    let checkpoint = Checkpoint::resume(state, origin)?;
    log::info!("{}: going on with {} pieces", study.name, checkpoint.len());
    if checkpoint.damaged() > 0 {
        let lost = counted(checkpoint.damaged(), "damaged piece");
        log::warn!("{}: {lost} of the unfinished run to compute again", study.name);
        arguments.reporting.print(&format!("{lost} of the unfinished run to compute again.\n"))?;
    }
    Ok(checkpoint)
}

/// How many items a study computes, and what they are called.
fn items(study: &Study) -> (usize, &'static str) {
    match &study.kind {
        StudyKind::WorkspaceMap(map) => (map.grid.len(), "points"),
        StudyKind::Path(path) => (path.stations.len() * kinetostat::study::path::passes(path), "points"),
        StudyKind::Placement(placement) => (placement.grid.len(), "places"),
        StudyKind::Superposition(study) => (study.grid.len() + study.locations.len(), "points"),
        StudyKind::Validation(validation) => (validation::work(validation), "points"),
    }
}

/// A study being run.
struct Run<'a> {
    arguments: &'a RunArguments,
    study: &'a Study,
    out: &'a Path,
    work: Work,
    progress: Arc<Progress>,
    started: Instant,
}

impl Run<'_> {
    fn formats(&self) -> Vec<exchange::Format> {
        self.arguments.format.iter().map(|format| (*format).into()).collect()
    }

    fn manifest(&self, settings: Value, statuses: Vec<StatusCount>) -> Manifest {
        Manifest {
            program: env!("CARGO_PKG_NAME"),
            version: env!("CARGO_PKG_VERSION"),
            study: self.study.name.clone(),
            input_sha256: self.study.inputs.sha256(),
            seed: None,
            settings,
            statuses,
            files: Vec::new(),
            publishing: false,
        }
    }

    fn stopped(&self) -> Result<Ending> {
        let (name, done) = (&self.study.name, self.progress.end());
        log::info!("{name}: stopped after {done}");
        self.progress.line(json!({ "event": "stopped", "study": name }));
        let text = format!("{name}: stopped after {done}. The same command with --resume goes on.\n");
        self.arguments.reporting.print(&text)?;
        Ok(Ending::Stopped)
    }
}
