//! `kinetostat run`: computes a study and writes its tables, figures and page; with --part, one part of it, for `merge`.

use std::{
    path::{Path, PathBuf},
    sync::Arc,
    time::Instant,
};

use clap::Args;
use kinetostat::{
    Event,
    files::{
        counted,
        exchange::{Points, WrittenRows},
    },
    input::error::{Error, Result},
    machine::Branch,
    process::GammaChoice,
    questions::{Overrides, Study},
    run::{
        FolderRun, new_study,
        parts::{PartInFolder, PartOptions, StudySource},
    },
    work::share::Share,
};
use serde_json::json;

use super::{
    Ending, choice,
    reporting::{heed_stops, stop_flag},
    results::{Computing, Writing, as_option_error, result_folder, run_study},
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
  kinetostat run my_robot_path --redundancy best               (the rotation about the tool axis that deflects least)
  kinetostat run studies/01_workspace_map --colours cividis
  kinetostat run studies/01_workspace_map --format csv,parquet,vti  (built with --features parquet,vtk)
  kinetostat run studies/01_workspace_map --grid 101 --resume  (go on where Ctrl-C, or a power cut, stopped it)
  kinetostat run studies/01_workspace_map --grid 101 --part 3/10 --out parts   (the third of ten parts, for merge)
  kinetostat run studies/* --progress json --log night.log 2> progress.jsonl

Beside its tables a result folder has summary.json and manifest.json. csv-metadata.json describes the columns of CSV files,
map.vti.json the arrays and status numbers of map.vti. What is computed is kept in unfinished_run.state until the results are
written: with --resume a run that was stopped or killed ends with the same bytes as one that was not.")]
pub struct RunArguments {
    /// Study folders (with a study.toml), or study files
    #[arg(required = true)]
    studies: Vec<PathBuf>,
    /// Grid points along x,y,z, or one number for all, instead of the study's
    #[arg(long, value_parser = parse_grid, allow_hyphen_values = true)]
    grid: Option<[usize; 3]>,
    /// Points along the circle of a path study, instead of the study's; or all: all rows of long tables of path points are
    /// written [default: at most 50000 rows: the worst points, and points at equal steps]
    #[arg(long, value_name = "N|all")]
    points: Option<Points>,
    /// Branch on which an arm with a spherical wrist is to stand, instead of the study's
    #[arg(long, value_parser = choice::branch())]
    branch: Option<Branch>,
    /// Rotation about the tool axis along the path of a path study, instead of that of [redundancy] of the process
    #[arg(long, value_parser = choice::redundancy())]
    redundancy: Option<GammaChoice>,
    /// Folder for the results of a single study, or for parts [default: results/<name of the study's folder>, or
    /// parts/<the same>]
    #[arg(long)]
    out: Option<PathBuf>,
    /// Compute part i of n of a single study, and leave a file for merge: on each of n machines another i from 1 to n
    #[arg(long, value_name = "I/N", value_parser = str::parse::<Share>, allow_hyphen_values = true)]
    #[arg(conflicts_with_all = ["no_figures", "format", "colours"])]
    part: Option<Share>,
    /// Round of a study that goes in rounds (placements): it goes on from all parts of the rounds before, in the same
    /// folder
    #[arg(long, requires = "part", default_value = "1", value_parser = clap::value_parser!(u32).range(1..=1000))]
    round: u32,
    #[command(flatten)]
    writing: Writing,
    #[command(flatten)]
    computing: Computing,
}

/// Parses counts along three axes, or one for all.
pub(super) fn parse_grid(text: &str) -> std::result::Result<[usize; 3], String> {
    let parse = |part: &str| part.trim().parse::<usize>().map_err(|_| format!("\"{part}\" is not a count"));
    match text.split(',').map(parse).collect::<std::result::Result<Vec<_>, _>>()?.as_slice() {
        [n] => Ok([*n; 3]),
        [x, y, z] => Ok([*x, *y, *z]),
        other => Err(format!("expected one count or three, got {}", other.len())),
    }
}

/// Runs `kinetostat run`: computes the studies one after another, or one part of a single study.
pub fn run(arguments: &RunArguments) -> Result<Ending> {
    let RunArguments { computing, writing, .. } = arguments;
    computing.reporting.start_log()?;
    let refuse = |argument: &str, problem: String| Err(Error::argument(argument, problem));
    if let (Some(out), [_, _, ..]) = (&arguments.out, arguments.studies.as_slice()) {
        let problem = format!("{} can hold the results of one study, got {}", out.display(), arguments.studies.len());
        return refuse("--out", problem);
    }
    let (count, rows) = match arguments.points {
        Some(Points::All) => (None, WrittenRows::All),
        Some(Points::Count(count)) => (Some(count), WrittenRows::default()),
        None => (None, WrittenRows::default()),
    };
    let overrides = Overrides {
        grid: arguments.grid,
        points: count,
        branch: arguments.branch,
        redundancy: arguments.redundancy,
        ..Overrides::default()
    };
    if let Some(share) = arguments.part {
        if rows == WrittenRows::All {
            return refuse("--points", "all is for merge, which writes the tables".into());
        }
        let [path] = arguments.studies.as_slice() else {
            return refuse("--part", format!("is of one study, got {}", arguments.studies.len()));
        };
        let request = PartRequest { path, overrides, share, round: arguments.round, out: arguments.out.as_deref() };
        return compute_part(&request, computing);
    }
    let opened = arguments.studies.iter().map(|path| new_study::open(path, &overrides));
    let studies: Vec<Study> = opened.collect::<Result<_>>().map_err(as_option_error)?;
    for (i, study) in studies.iter().enumerate() {
        if studies[..i].iter().any(|other| other.name == study.name) {
            let problem = format!("two studies are called \"{}\" and would share a result folder", study.name);
            return refuse(&arguments.studies[i].display().to_string(), problem);
        }
    }
    compute(&studies, arguments.out.as_ref(), writing, computing, rows)
}

/// Computes `studies`, one after another, into the folder `out` or folders of their names; of long tables of path points the `rows`.
pub fn compute(
    studies: &[Study],
    out: Option<&PathBuf>,
    writing: &Writing,
    computing: &Computing,
    rows: WrittenRows,
) -> Result<Ending> {
    let options = writing.options(computing, rows);
    heed_stops();
    studies.iter().try_for_each(|study| study.check_formats(&options)).map_err(as_option_error)?;
    let runs = studies.iter().map(|study| study.prepare_run(&result_folder(out, study), &options));
    let runs: Vec<FolderRun<'_>> = runs.collect::<Result<_>>().map_err(as_option_error)?;
    if computing.reporting.is_stopped()? {
        return Ok(Ending::Stopped);
    }
    let mut ending = Ending::Complete;
    for run in &runs {
        match run_study(computing, writing, run, || run.begin())? {
            Ending::Complete => {}
            Ending::SomeUnsolved => ending = Ending::SomeUnsolved,
            Ending::Stopped => return Ok(Ending::Stopped),
        }
    }
    Ok(ending)
}

/// A part of a study to compute.
struct PartRequest<'a> {
    /// Path of the study.
    path: &'a Path,
    overrides: Overrides,
    share: Share,
    round: u32,
    out: Option<&'a Path>,
}

/// Computes a part and writes its file.
fn compute_part(asked: &PartRequest<'_>, computing: &Computing) -> Result<Ending> {
    let (share, round, started) = (asked.share, asked.round, Instant::now());
    let study = new_study::open(asked.path, &asked.overrides).map_err(as_option_error)?;
    let fault = |source| Error::Read { file: asked.path.to_path_buf(), source };
    let opened = StudySource { study: asked.path.canonicalize().map_err(fault)?, overrides: asked.overrides.clone() };
    if round > 1 && !study.kind.goes_in_rounds() {
        let problem = format!("expected 1, got {round}: study {} is shared in one round", study.name);
        return Err(Error::argument("--round", problem));
    }
    let out = asked.out.map_or_else(|| PathBuf::from("parts").join(&study.name), Path::to_path_buf);
    heed_stops();
    if computing.reporting.is_stopped()? {
        return Ok(Ending::Stopped);
    }
    let pieces = study.kind.pieces();
    // How many pieces a later round has is not known before.
    let share_size = if round == 1 { share.count(pieces) } else { 0 };
    let options = PartOptions { begin: computing.begin(), program: None, opened, round };
    let pool = computing.pool()?;
    let name = format!("{} part {share}", study.name);
    let progress = computing.reporting.progress(&name, share_size, "pieces");
    let (watcher, stop) = (Arc::clone(&progress), stop_flag()?);
    let watch = move |event| match event {
        Event::Shard { is_kept: true } => watcher.record(Event::Kept(1)),
        Event::Shard { is_kept: false } => watcher.record(Event::Computed(1)),
        Event::Resumed { .. } => watcher.record(event),
        _ => {}
    };
    let ended = pool.install(|| study.part_into(share, &out, &options, stop, watch));
    let done = progress.end();
    match ended {
        Ok(part) => {
            let seconds = started.elapsed().as_secs_f64();
            log::info!("{name}: {done} in {seconds:.1} s, written to {}", part.file.display());
            progress.line(json!({
                "event": "finished",
                "study": study.name,
                "part": share.part(),
                "parts": share.of(),
                "round": round,
                "is_complete": part.is_complete,
                "wall_time_s": seconds,
                "threads": pool.current_num_threads(),
                "file": part.file,
            }));
            computing.reporting.print(&part_report(&study, asked, &out, &part, pieces, seconds))?;
            Ok(Ending::Complete)
        }
        Err(error) => computing.report_unfinished(&study, &progress, &done, false, error).map_err(as_option_error),
    }
}

/// Returns the message about a computed part: its file, and the commands that come next.
fn part_report(
    study: &Study,
    request: &PartRequest<'_>,
    out: &Path,
    part: &PartInFolder,
    pieces: usize,
    seconds: f64,
) -> String {
    let (share, round, file) = (request.share, request.round, part.file.display());
    if part.was_there {
        return format!("Part {share} of {} is there already: {file}. Use --restart to compute anew.\n", study.name);
    }
    let mut text = match round {
        1 => {
            let share_size = counted(share.count(pieces), "piece");
            format!("Part {share} of {}, {share_size} of {pieces}, in {seconds:.1} s: {file}\n", study.name)
        }
        _ => format!("Part {share} of round {round} of {} in {seconds:.1} s: {file}\n", study.name),
    };
    if pieces < share.of() as usize && round == 1 {
        text += &format!("The study has {}: more parts than that have nothing to do.\n", counted(pieces, "piece"));
    }
    text += &format!("With all {} parts: kinetostat merge {}\n", share.of(), out.display());
    if study.kind.goes_in_rounds() && !part.is_complete {
        text += &format!(
            "merge computes what comes next, too; to share that as well, first all parts with --round {}\n",
            round + 1
        );
    }
    text
}
