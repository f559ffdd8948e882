//! The machine and the process of a command: `--machine`, `--lock`, `--branch`, `--process`.

use std::path::PathBuf;

use clap::Args;
use kinetostat::{
    input::error::{Error, Result},
    machine::{Branch, Geometry, Machine},
    process::Process,
};

use super::{choice, number};

/// A machine and what it is to do.
#[derive(Debug, Args)]
pub struct OnMachine {
    /// Built-in machine or machine file
    #[arg(long, short)]
    pub machine: String,
    /// Lock a drive at a position, mm or degrees as a pendant shows it: one that the task does not need (a rail), or one under the
    /// workpiece; repeatable
    #[arg(long, value_parser = parse_setting, value_name = "DRIVE=VALUE")]
    pub lock: Vec<Setting>,
    /// Branch on which an arm with a spherical wrist is to stand [default: the one of home, and others where it does not reach]
    #[arg(long, value_parser = choice::branch())]
    pub branch: Option<Branch>,
    /// Process file: placement, cutting force, chain errors, limits
    #[arg(long, short)]
    pub process: PathBuf,
}

impl OnMachine {
    /// Returns the machine with its drives locked.
    pub fn machine(&self) -> Result<Machine> {
        lock_drives(&geometry(&self.machine, &[], self.branch)?.machine()?, &self.lock)
    }

    /// Reads the process on this machine.
    pub fn process(&self) -> Result<Process> {
        Process::open(&self.process, &self.machine()?)
    }
}

/// Name and value of a parameter or drive.
pub type Setting = (String, f64);

/// Parses one setting, NAME=VALUE.
pub fn parse_setting(text: &str) -> std::result::Result<Setting, String> {
    let Some((name, value)) = text.rsplit_once('=') else {
        return Err(format!("\"{text}\" is not of the form NAME=VALUE"));
    };
    let value = number(value)?;
    Ok((name.trim().into(), value))
}

/// Returns the geometry of the machine called `name`, or of this file, with these parameters and on this branch.
pub fn geometry(name: &str, settings: &[Setting], branch: Option<Branch>) -> Result<Geometry> {
    let geometry = Geometry::named_or_file(name)?;
    let geometry = match settings {
        [] => geometry,
        some => geometry.with_parameters(some).map_err(|error| with_option(error, "--set"))?,
    };
    match branch {
        Some(branch) => geometry.on_branch(branch).map_err(|error| match error {
            Error::Argument { problem, .. } => Error::argument("--branch", problem),
            other => other,
        }),
        None => Ok(geometry),
    }
}

/// Returns the machine with these drives locked, mm or degrees.
pub fn lock_drives(machine: &Machine, settings: &[Setting]) -> Result<Machine> {
    machine.with_locked_drives(settings).map_err(|error| with_option(error, "--lock"))
}

/// Returns `error` with the name of the option that caused it.
fn with_option(error: Error, option: &str) -> Error {
    match error {
        Error::Argument { argument, problem } => Error::argument(option, format!("{argument}: {problem}")),
        other => other,
    }
}
