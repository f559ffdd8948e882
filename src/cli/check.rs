//! `kinetostat check`: validates a machine file and prints what a designer wants to see.

use clap::Args;
use kinetostat::{
    input::error::Result,
    machine::Geometry,
    study::machine_check::{
        check as check_machine, check_geometry,
        report::{geometry_text, machine_text},
    },
};

use super::{Ending, print};

/// Validate a machine file and show mobility, reach, round-trip error, stiffness and warnings.
#[derive(Debug, Args)]
#[command(after_help = "\
Of a machine with drives of unknown stiffness, geometry and reach are shown, and what is needed to go on (exit code 2).

Examples:
  kinetostat check orthoglide
  kinetostat check my_machine.toml")]
pub struct CheckArguments {
    /// Machine file, or name of a built-in machine
    machine: String,
}

pub fn check(arguments: &CheckArguments) -> Result<Ending> {
    let geometry = Geometry::named_or_file(&arguments.machine)?;
    if !geometry.unknown().is_empty() {
        print(&geometry_text(&geometry, &check_geometry(&geometry)))?;
    }
    let machine = geometry.machine()?;
    print(&machine_text(&machine, &check_machine(&machine)))?;
    Ok(Ending::Complete)
}
