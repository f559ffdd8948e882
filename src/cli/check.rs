//! `kinetostat check`: validates a machine file and prints what a designer wants to see.

use clap::Args;
use kinetostat::{
    input::error::Result,
    machine::Machine,
    study::machine_check::{self, report::machine_text},
};

use super::{Ending, print};

/// Validate a machine file and show mobility, reach, round-trip error, stiffness and warnings.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  kinetostat check orthoglide
  kinetostat check my_machine.toml")]
pub struct CheckArguments {
    /// Machine file, or name of a built-in machine
    machine: String,
}

pub fn check(arguments: &CheckArguments) -> Result<Ending> {
    let machine = Machine::named_or_file(&arguments.machine)?;
    let findings = machine_check::check(&machine);
    print(&machine_text(&machine, &findings))?;
    Ok(Ending::Complete)
}
