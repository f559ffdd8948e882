//! Commands and their arguments.

mod check;
mod machines;
mod point;
mod run;

use std::process::ExitCode;

use clap::{Parser, Subcommand};
use kinetostat::error::Result;

/// How far a loaded machine leaves its path, what to tell the drives instead, and where to put the workpiece.
#[derive(Debug, Parser)]
#[command(version, propagate_version = true, after_help = EXAMPLES)]
pub struct Arguments {
    #[command(subcommand)]
    command: Command,
}

const EXAMPLES: &str = "\
Examples:
  kinetostat run studies/01_workspace_map
  kinetostat point --machine orthoglide --at Q1 --phi 130 --assembly 1,-1,1
  kinetostat check my_machine.toml

Exit codes: 0 all points solved, 1 some points could not be solved (their status says why), 2 bad input.";

#[derive(Debug, Subcommand)]
enum Command {
    Run(run::RunArguments),
    Point(point::PointArguments),
    Machines(machines::MachinesArguments),
    Check(check::CheckArguments),
}

/// How a command ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ending {
    /// Everything that was asked is answered.
    Complete,
    /// Some points could not be solved; the tables say which and why.
    SomeUnsolved,
}

impl Ending {
    pub fn exit_code(self) -> ExitCode {
        match self {
            Ending::Complete => ExitCode::SUCCESS,
            Ending::SomeUnsolved => ExitCode::from(1),
        }
    }
}

/// Runs the command.
pub fn dispatch(arguments: Arguments) -> Result<Ending> {
    match arguments.command {
        Command::Run(arguments) => run::run(&arguments),
        Command::Point(arguments) => point::point(&arguments),
        Command::Machines(arguments) => machines::machines(&arguments),
        Command::Check(arguments) => check::check(&arguments),
    }
}

/// Comma-separated numbers, as many as `count`.
fn numbers<const COUNT: usize>(text: &str) -> std::result::Result<[f64; COUNT], String> {
    let values = text.split(',').map(|part| {
        let value: f64 = part.trim().parse().map_err(|_| format!("\"{part}\" is not a number"))?;
        if value.is_finite() { Ok(value) } else { Err(format!("\"{part}\" is not finite")) }
    });
    let values = values.collect::<std::result::Result<Vec<_>, _>>()?;
    let found = values.len();
    values.try_into().map_err(|_| format!("expected {COUNT} numbers separated by commas, got {found}"))
}

/// Any number of comma-separated numbers.
fn any_numbers(text: &str) -> std::result::Result<Vec<f64>, String> {
    text.split(',').map(|part| numbers::<1>(part).map(|[value]| value)).collect()
}
