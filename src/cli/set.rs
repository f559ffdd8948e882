//! `--set NAME=VALUE`, `--branch` and `--hold DRIVE=VALUE`: other numbers of a machine than its file has, the branch on which it
//! stands, and drives that stay where they are told.

use kinetostat::{
    input::error::{Error, Result},
    machine::{Branch, Geometry, Machine},
};

use super::number;

/// Name and value.
pub type Setting = (String, f64);

/// One setting, as the command line gives it.
pub fn setting(text: &str) -> std::result::Result<Setting, String> {
    let Some((name, value)) = text.rsplit_once('=') else {
        return Err(format!("\"{text}\" is not of the form NAME=VALUE"));
    };
    let value = number(value)?;
    Ok((name.trim().into(), value))
}

/// The machine called so, or of this file, with these numbers and on this branch.
pub fn machine(name: &str, settings: &[Setting], branch: Option<Branch>) -> Result<Geometry> {
    let geometry = Geometry::named_or_file(name)?;
    let geometry = if settings.is_empty() {
        geometry
    } else {
        geometry.with_parameters(settings).map_err(|error| named(error, "--set"))?
    };
    match branch {
        Some(branch) => geometry.on_branch(branch).map_err(in_branch),
        None => Ok(geometry),
    }
}

/// The machine with these drives held, mm or degrees.
pub fn held(machine: &Machine, settings: &[Setting]) -> Result<Machine> {
    machine.with_drives_held(settings).map_err(|error| named(error, "--hold"))
}

/// What is wrong with a name given to `option`.
fn named(error: Error, option: &str) -> Error {
    match error {
        Error::Argument { argument, problem } => {
            Error::Argument { argument: option.into(), problem: format!("{argument}: {problem}") }
        }
        other => other,
    }
}

fn in_branch(error: Error) -> Error {
    match error {
        Error::Argument { problem, .. } => Error::Argument { argument: "--branch".into(), problem },
        other => other,
    }
}
