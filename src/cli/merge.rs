//! `kinetostat merge`: computes the results of a study from the part files that `run --part` wrote.

use std::path::PathBuf;

use clap::Args;
use kinetostat::{
    files::{counted, exchange::WrittenRows},
    input::error::{Error, Result},
    questions::{Overrides, Study},
    run::parts::{StudySource, read_parts},
    work::part_file::{Part, PartSource},
};

use super::{
    Ending,
    reporting::heed_stops,
    results::{Computing, Writing, as_option_error, result_folder, run_study},
};

/// Merge the parts of a study that run --part has left: the results are those of a single run, byte for byte.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  for i in 1 2 3; do kinetostat run studies/01_workspace_map --part $i/3 --out parts; done    (each on a machine of its own)
  kinetostat merge parts --out results/01_workspace_map
  kinetostat merge node1/parts node2/parts/part_0002_of_0003.kpart node3/parts
  kinetostat merge parts --study /home/me/01_workspace_map     (where the study is here, if it was elsewhere there)

All parts must be there, each once, computed by this very program from the study as it is now; any other file is refused by
name. A placement goes in rounds, each of which needs all parts of the one before: merge computes what no part has, and
run --part I/N --round 2 shares the second round, and so on.")]
pub struct MergeArguments {
    /// Folders of parts, or files of parts
    #[arg(required = true)]
    parts: Vec<PathBuf>,
    /// The study [default: where it was when the parts were computed]
    #[arg(long)]
    study: Option<PathBuf>,
    /// Folder for the results [default: results/<name of the study's folder>]
    #[arg(long)]
    out: Option<PathBuf>,
    /// Write all rows of long tables of path points [default: at most 50000: the worst points, and points at equal steps]
    #[arg(long, value_name = "all")]
    points: Option<WrittenRows>,
    #[command(flatten)]
    writing: Writing,
    #[command(flatten)]
    computing: Computing,
}

/// Runs `kinetostat merge`: computes what no part has, and writes and prints the results of the study.
pub fn merge(arguments: &MergeArguments) -> Result<Ending> {
    let MergeArguments { writing, computing, .. } = arguments;
    computing.reporting.start_log()?;
    let mut parts: Vec<Part> = Vec::new();
    for path in &arguments.parts {
        match path.is_dir() {
            true => parts.extend(read_parts(path)?),
            false => parts.push(Part::read(PartSource::File(path.clone()))?),
        }
    }
    let study = study_of_parts(arguments, &parts)?;
    let options = writing.options(computing, arguments.points.unwrap_or_default());
    study.check_formats(&options).map_err(as_option_error)?;
    heed_stops();
    let run = study.prepare_run(&result_folder(arguments.out.as_ref(), &study), &options).map_err(as_option_error)?;
    if study.kind.goes_in_rounds() && !parts.iter().any(|part| part.head().is_complete) {
        let rounds = counted(parts.iter().map(|part| part.head().round).max().unwrap_or_default() as usize, "round");
        let text = format!("{rounds} of {}; what comes next is computed here.\n", study.name);
        computing.reporting.print(&text)?;
    }
    run_study(computing, writing, &run, || {
        run.begin_from(parts).map_err(|refused| with_part_paths(refused, &arguments.parts))
    })
}

/// Returns the error `refused` with the `paths` of the parts before its argument.
fn with_part_paths(refused: Error, paths: &[PathBuf]) -> Error {
    match refused {
        Error::Argument { argument, problem } => {
            let paths: Vec<String> = paths.iter().map(|path| path.display().to_string()).collect();
            Error::argument(format!("{}: {argument}", paths.join(", ")), problem)
        }
        other => other,
    }
}

/// Opens the study that the parts belong to: the one of `--study`, or where it was when they were computed.
fn study_of_parts(arguments: &MergeArguments, parts: &[Part]) -> Result<Study> {
    let refuse = |problem: String| Err(Error::argument("--study", problem));
    let opened = parts.first().map(StudySource::of).transpose()?.flatten();
    let (path, overrides) = match (&arguments.study, opened) {
        (Some(path), opened) => (path.clone(), opened.unwrap_or_default().overrides),
        (None, Some(opened)) => (opened.study, opened.overrides),
        (None, None) => return refuse("is missing: the parts do not say where their study is".into()),
    };
    match Study::open(&path, &overrides) {
        Err(Error::Read { file, source }) if arguments.study.is_none() => refuse(format!(
            "the parts are of {}, and {} cannot be read: {source}; say where the study is now",
            path.display(),
            file.display()
        )),
        Err(error @ (Error::Read { .. } | Error::Syntax { .. })) => Err(as_option_error(error)),
        Err(error) if arguments.study.is_some() && overrides != Overrides::default() => {
            refuse(format!("{} does not take the settings that the parts were computed with: {error}", path.display()))
        }
        opened => opened.map_err(as_option_error),
    }
}
