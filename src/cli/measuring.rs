//! `kinetostat identify`, `kinetostat predict` and `kinetostat design-measurements`: studies of measurements.

use std::path::{Path, PathBuf};

use clap::Args;
use kinetostat::{
    files::{
        OutputFile,
        exchange::{WrittenRows, csv},
        write_beside,
    },
    input::{
        Folder,
        error::{Error, Result},
    },
    questions::{Overrides, Study, StudyKind, identification::report::predicted},
    work::Work,
};

use super::{
    Ending,
    machines::new_file,
    print,
    results::{Computing, Writing, as_option_error},
    run, say,
};

#[derive(Debug, Args)]
struct OneStudy {
    /// Study folder (with a study.toml), or study file
    study: PathBuf,
    /// Folder for the results [default: results/<name of the study's folder>]
    #[arg(long)]
    out: Option<PathBuf>,
    #[command(flatten)]
    writing: Writing,
    #[command(flatten)]
    computing: Computing,
}

/// Find the parameters of a machine from measurements under load: values, 95 % intervals, what is not identifiable, and a machine file
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  kinetostat new identification mine      (a study, and measurements to replace by yours)
  kinetostat identify mine --out found
  kinetostat machines fanuc_r2000ic --parameters                  (names of what may be sought)
  kinetostat run my_map                   (whose machine is \"../found/machine.toml\", with what was identified)

The study says which parameters are sought from which measurements; kinetostat run computes the same.")]
pub struct IdentifyArguments {
    #[command(flatten)]
    one: OneStudy,
}

/// Predict readings at poses that an identification has not seen, each with its 95 % interval
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  kinetostat predict mine --poses others.csv
  kinetostat predict mine --poses others.csv --out predicted.csv

The file of poses has the columns of the study's measurements. Its readings are set beside their predictions; for a row without readings,
displacements of the tool tip are predicted. The interval holds what is known of the parameters, the residual of the model and the noise.")]
pub struct PredictArguments {
    /// Study folder (with a study.toml) of an identification, or study file
    study: PathBuf,
    /// CSV file of poses and loads, with or without readings
    #[arg(long)]
    poses: PathBuf,
    /// CSV file for the answer, a new one [default: standard output]
    #[arg(long)]
    out: Option<PathBuf>,
}

/// Choose the next measurements: the poses and loads most informative about a machine's parameters, and a measurement sheet to fill in
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  kinetostat new measurements next        (a study to change)
  kinetostat design-measurements next --out plan
  kinetostat identify mine                (whose data is \"../plan/sheet.csv\", filled in)

The study says what may be measured and what is to be known; kinetostat run computes the same.")]
pub struct DesignArguments {
    #[command(flatten)]
    one: OneStudy,
}

/// Runs `kinetostat identify`: computes an identification study into its result folder.
pub fn identify(arguments: &IdentifyArguments) -> Result<Ending> {
    run_study_of(&arguments.one, "[identification]", |kind| matches!(kind, StudyKind::Identification(..)))
}

/// Runs `kinetostat predict`: prints or writes the predicted readings of an identified machine.
pub fn predict(arguments: &PredictArguments) -> Result<Ending> {
    arguments.out.as_deref().map(new_file).transpose().map(drop)?;
    let opened = Study::open(&arguments.study, &Overrides::default()).map_err(as_option_error)?;
    let StudyKind::Identification(study, ()) = &opened.kind else {
        return Err(wrong_kind(&arguments.study, "[identification]"));
    };
    let file = arguments.poses.display().to_string();
    let bytes = Folder::from(PathBuf::new()).bytes(&file)?;
    let predictions = predicted::predict_rows(study, &bytes, &file, &Work::default())?;
    let rows = csv(&predictions.table).map_err(|e| Error::Write { file: "the answer".into(), source: e.into() })?;
    match &arguments.out {
        None => print(&String::from_utf8_lossy(&rows))?,
        Some(out) => {
            let (name, _lock) = new_file(out)?;
            write_beside(out, vec![OutputFile::new(name, rows)])?;
        }
    }
    if !predictions.words.is_empty() {
        say(&predictions.words);
    }
    Ok(Ending::of(predictions.is_complete))
}

/// Returns the error of a study that has another table than `table`.
fn wrong_kind(study: &Path, table: &str) -> Error {
    let problem = format!("is a study of another kind: expected one with {table}; kinetostat run computes any");
    Error::argument(study.display().to_string(), problem)
}

/// Runs `kinetostat design-measurements`: computes a study of a measurement design into its result folder.
pub fn design(arguments: &DesignArguments) -> Result<Ending> {
    run_study_of(&arguments.one, "[measurement_design]", |kind| matches!(kind, StudyKind::MeasurementDesign(..)))
}

/// Computes the study of the arguments if `is_one` accepts its kind, whose table is called `table`.
fn run_study_of(one: &OneStudy, table: &str, is_one: impl Fn(&StudyKind) -> bool) -> Result<Ending> {
    one.computing.reporting.start_log()?;
    let study = Study::open(&one.study, &Overrides::default()).map_err(as_option_error)?;
    if !is_one(&study.kind) {
        return Err(wrong_kind(&one.study, table));
    }
    run::compute(&[study], one.out.as_ref(), &one.writing, &one.computing, WrittenRows::default())
}
