//! The machine and the process of a command: `--machine`, `--hold`, `--branch`, `--process`.

use std::path::PathBuf;

use clap::Args;
use kinetostat::{
    input::error::Result,
    machine::{Branch, Machine},
    process::Process,
};

use super::{choice, set};

/// A machine and what it is to do.
#[derive(Debug, Args)]
pub struct OnMachine {
    /// Built-in machine or machine file
    #[arg(long, short)]
    pub machine: String,
    /// Hold a drive at a position, mm or degrees as a pendant shows it: one that the task does not need (a rail), or one under the
    /// workpiece; repeatable
    #[arg(long, value_parser = set::setting, value_name = "DRIVE=VALUE")]
    pub hold: Vec<set::Setting>,
    /// Branch on which an arm with a spherical wrist is to stand [default: the one of home, and others where it does not reach]
    #[arg(long, value_parser = choice::branch())]
    pub branch: Option<Branch>,
    /// Process file: placement, cutting force, chain errors, limits
    #[arg(long, short)]
    pub process: PathBuf,
}

impl OnMachine {
    /// The machine, its drives held.
    pub fn machine(&self) -> Result<Machine> {
        set::held(&set::machine(&self.machine, &[], self.branch)?.machine()?, &self.hold)
    }

    /// The process on this machine.
    pub fn process(&self) -> Result<Process> {
        Process::open(&self.process, &self.machine()?)
    }
}
