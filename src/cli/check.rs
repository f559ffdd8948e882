//! `kinetostat check`: validates a machine file and prints what a designer wants to see.

use clap::Args;
use kinetostat::{
    input::error::{Error, Result},
    inspect::machine_check::{
        check as check_machine, check_geometry,
        report::{geometry_text, machine_text},
    },
    machine::Branch,
};
use serde_json::json;

use super::{
    Ending, choice,
    on_machine::{self, Setting},
    print, print_json,
};

/// Validate a machine file and show mobility, characteristic length, branches, round-trip error, stiffness and warnings.
#[derive(Debug, Args)]
#[command(after_help = "\
Of a machine with drives of unknown stiffness, geometry and workspace are shown, and what is needed to go on (exit code 2).

Examples:
  kinetostat check orthoglide
  kinetostat check my_machine.toml
  kinetostat check my_machine.toml --json
  kinetostat check my_machine.toml --set arm.A2.stiffness=3e9
  kinetostat check kr270 --branch front-up-flip")]
pub struct CheckArguments {
    /// Machine file, or name of a built-in machine
    machine: String,
    /// Another value of a parameter of the machine, by its name (kinetostat machines NAME --parameters); repeatable
    #[arg(long, value_parser = on_machine::parse_setting, value_name = "NAME=VALUE")]
    set: Vec<Setting>,
    /// Branch on which an arm with a spherical wrist is to stand [default: the one of home, and others where it does not reach]
    #[arg(long, value_parser = choice::branch())]
    branch: Option<Branch>,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// Runs `kinetostat check`: prints the findings about a machine; an error if stiffnesses of its drives are unknown.
pub fn check(arguments: &CheckArguments) -> Result<Ending> {
    let geometry = on_machine::geometry(&arguments.machine, &arguments.set, arguments.branch)?;
    if !geometry.kinematics().parameter_errors().is_empty() {
        let problem = "check looks at the machine without errors of its chains: set numbers of its file";
        return Err(Error::argument("--set", problem));
    }
    let only_geometry = (!geometry.unknown().is_empty()).then(|| check_geometry(&geometry)).transpose()?;
    if arguments.json {
        let kinematics = geometry.kinematics().clone();
        let machine = geometry.machine();
        let findings = only_geometry.map_or_else(|| check_machine(&kinematics), Ok)?;
        let error = machine.as_ref().err().map(ToString::to_string);
        print_json(
            &json!({ "machine": kinematics.name, "title": kinematics.title, "findings": findings, "error": error }),
        )?;
        return machine.map(|_| Ending::Complete);
    }
    if let Some(findings) = only_geometry {
        print(&geometry_text(&geometry, &findings))?;
    }
    let machine = geometry.machine()?;
    print(&machine_text(&machine, &check_machine(&machine)?))?;
    Ok(Ending::Complete)
}
