//! `kinetostat identify` and `kinetostat design-measurements`: studies of measurements, by what a person asks of them.

use std::path::PathBuf;

use clap::Args;
use kinetostat::{
    input::error::{Error, Result},
    study::{Overrides, Study, StudyKind},
};

use super::{
    Ending,
    results::{Computing, Writing, in_options},
    run,
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

/// Find the numbers of a machine from measurements under load: values, 95 % intervals, what is not told, and a machine file
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  kinetostat new identification mine      (a study, and measurements to replace by yours)
  kinetostat identify mine --out found
  kinetostat machines fanuc_r2000ic --parameters                  (names of what may be sought)
  kinetostat run my_map                   (whose machine is \"../found/machine.toml\", with what was identified)

The study says which numbers are sought from which measurements; kinetostat run computes the same.")]
pub struct IdentifyArguments {
    #[command(flatten)]
    one: OneStudy,
}

/// Choose the next measurements: poses and loads that tell most of a machine's numbers, and a sheet to fill in
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

pub fn identify(arguments: &IdentifyArguments) -> Result<Ending> {
    let is_one = |kind: &StudyKind| matches!(kind, StudyKind::Identification(..));
    run_if(&arguments.one, is_one, "[identification]")
}

pub fn design(arguments: &DesignArguments) -> Result<Ending> {
    let is_one = |kind: &StudyKind| matches!(kind, StudyKind::MeasurementDesign(..));
    run_if(&arguments.one, is_one, "[measurement_design]")
}

fn run_if(one: &OneStudy, is_one: impl Fn(&StudyKind) -> bool, table: &str) -> Result<Ending> {
    one.computing.reporting.start_log()?;
    let study = Study::open(&one.study, &Overrides::default()).map_err(in_options)?;
    if !is_one(&study.kind) {
        let problem = format!("is a study of another kind: expected one with {table}; kinetostat run computes any");
        return Err(Error::Argument { argument: one.study.display().to_string(), problem });
    }
    run::compute(&[study], one.out.as_ref(), (&one.writing, &one.computing))
}
