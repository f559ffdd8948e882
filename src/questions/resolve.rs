//! Checks of the keys that all study files have: schema, question, machine, branch and locked drives.

use std::path::Path;

use super::{
    Overrides,
    spec::{Header, check_schema},
};
use crate::{
    input::{
        Folder,
        check::Check,
        error::{Error, Result},
    },
    machine::{Branch, Machine, catalogue},
};

/// Checks the keys of a study of any kind; returns its machine and the text of the machine's file.
pub(crate) fn resolve_header(
    header: &Header,
    folder: &Folder,
    overrides: &Overrides,
    check: &Check,
) -> Result<(Machine, String)> {
    check_schema(header.schema, check)?;
    if header.question.trim().is_empty() {
        return check.key("question").fail("must be a sentence, which is printed with the answer, got none".into());
    }
    let (machine, text) = load_machine(&header.machine, folder, &check.key("machine"))?;
    let machine = with_parameters(machine, overrides)?;
    let machine = on_branch(machine, header.branch.as_deref(), overrides, &check.key("branch"))?;
    Ok((with_locked_drives(&machine, header, &check.key("locked"))?, text))
}

/// Returns the machine with the parameters that are overridden for this run. `Err` for a chain error.
fn with_parameters(machine: Machine, overrides: &Overrides) -> Result<Machine> {
    if overrides.parameters.is_empty() {
        return Ok(machine);
    }
    let changed = machine.with_parameters(&overrides.parameters)?;
    match changed.parameter_errors().is_empty() {
        true => Ok(changed),
        false => Overrides::location("parameters").fail("errors of chains are those of the process".into()),
    }
}

/// Returns the machine with the drives locked that the study lists. `Err` for an unknown drive, or a position that it cannot take.
fn with_locked_drives(machine: &Machine, header: &Header, check: &Check) -> Result<Machine> {
    let mut positions: Vec<(&String, f64)> = Vec::new();
    for (name, value) in &header.locked {
        let position = machine.drive_label(name).map(|_| Some((name, *value)));
        positions.extend(position.or_else(|error| argument_misfit(check, error, None))?);
    }
    machine.with_locked_drives(&positions).or_else(|error| argument_misfit(check, error, machine.clone()))
}

/// Returns [`Check::misfit`] at the key that a rejected argument names, with `instead` as the value to go on with; other errors unchanged.
fn argument_misfit<T>(check: &Check, error: Error, instead: T) -> Result<T> {
    match error {
        Error::Argument { argument, problem } => check.key(&argument).misfit(problem, instead),
        other => Err(other),
    }
}

/// Returns the machine on the branch of inverse kinematics of the override, or else of the study (`word`); unchanged without either.
fn on_branch(machine: Machine, word: Option<&str>, overrides: &Overrides, check: &Check) -> Result<Machine> {
    let (place, chosen) = match (overrides.branch, word) {
        (Some(branch), _) => (Overrides::location("branch"), Ok(branch)),
        (None, Some(word)) => (check.clone(), word.parse()),
        (None, None) => return Ok(machine),
    };
    let problem = |error| match error {
        Error::Argument { problem, .. } => Ok(problem),
        other => Err(other),
    };
    let branch: Branch = chosen.or_else(|error| place.fail(problem(error)?))?;
    machine.on_branch(branch).or_else(|error| place.misfit(problem(error)?, machine.clone()))
}

/// Reads the built-in machine or the machine file `name`; returns it and the text of its file.
fn load_machine(name: &str, folder: &Folder, check: &Check) -> Result<(Machine, String)> {
    if let Some(entry) = catalogue::find(name) {
        return Ok((Machine::from_toml(entry.toml, entry.name)?, entry.toml.to_string()));
    }
    if !folder.has_file(name) {
        let names = catalogue::names().collect::<Vec<_>>().join(", ");
        return check
            .fail(format!("\"{name}\" is neither a built-in machine ({names}) nor a file in the study's folder"));
    }
    let text = folder.text(name)?;
    Ok((Machine::from_toml(&text, &folder.path(name).display().to_string())?, text))
}

/// Returns the name of the study's folder, "study" if it has none.
pub(super) fn folder_name(folder: &Path) -> String {
    let path = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let named = match path.file_name() {
        Some(_) => path.to_path_buf(),
        // Such as `.` and `..`.
        None => path.canonicalize().unwrap_or_default(),
    };
    named.file_name().map_or_else(|| "study".into(), |name| name.to_string_lossy().into_owned())
}
