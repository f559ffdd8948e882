//! The keys that all study files have.

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

/// Checks the keys of a study of any kind; its machine and the text of the machine's file.
pub(crate) fn header(
    header: &Header,
    folder: &Folder,
    overrides: &Overrides,
    check: &Check,
) -> Result<(Machine, String)> {
    check_schema(header.schema, check)?;
    if header.question.trim().is_empty() {
        return check.key("question").fail("must be a sentence, which is printed with the answer, got none".into());
    }
    let (machine, text) = machine(&header.machine, folder, &check.key("machine"))?;
    let machine = with_parameters(machine, overrides)?;
    let machine = on_branch(machine, header.branch.as_deref(), overrides, &check.key("branch"))?;
    Ok((locked(&machine, header, &check.key("locked"))?, text))
}

/// The machine with the numbers that are set for one run.
fn with_parameters(machine: Machine, overrides: &Overrides) -> Result<Machine> {
    if overrides.parameters.is_empty() {
        return Ok(machine);
    }
    let changed = machine.with_parameters(&overrides.parameters)?;
    match changed.parameter_errors().is_empty() {
        true => Ok(changed),
        false => Overrides::place("parameters").fail("errors of chains are those of the process".into()),
    }
}

/// The machine with the drives locked that the study holds.
fn locked(machine: &Machine, header: &Header, check: &Check) -> Result<Machine> {
    let positions: Vec<(&String, f64)> = header.locked.iter().map(|(name, value)| (name, *value)).collect();
    machine.with_locked_drives(&positions).or_else(|error| match error {
        Error::Argument { argument, problem } => check.key(&argument).fail(problem),
        other => Err(other),
    })
}

/// The machine on the branch of the study, or on that which is set for one run.
fn on_branch(machine: Machine, word: Option<&str>, overrides: &Overrides, check: &Check) -> Result<Machine> {
    let (place, chosen) = match (overrides.branch, word) {
        (Some(branch), _) => (Overrides::place("branch"), Ok(branch)),
        (None, Some(word)) => (check.clone(), word.parse()),
        (None, None) => return Ok(machine),
    };
    chosen.and_then(|branch: Branch| machine.on_branch(branch)).or_else(|error| match error {
        Error::Argument { problem, .. } => place.fail(problem),
        other => Err(other),
    })
}

/// The machine and its file's text.
fn machine(name: &str, folder: &Folder, check: &Check) -> Result<(Machine, String)> {
    if let Some(entry) = catalogue::find(name) {
        return Ok((Machine::from_toml(entry.toml, entry.name)?, entry.toml.to_string()));
    }
    if !folder.has(name) {
        let names = catalogue::names().collect::<Vec<_>>().join(", ");
        return check
            .fail(format!("\"{name}\" is neither a built-in machine ({names}) nor a file in the study's folder"));
    }
    let text = folder.text(name)?;
    Ok((Machine::from_toml(&text, &folder.path(name).display().to_string())?, text))
}

/// Name of the folder a study stands in.
pub(super) fn folder_name(folder: &Path) -> String {
    let whole = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let named = match whole.file_name() {
        Some(_) => whole.to_path_buf(),
        // Such as `.` and `..`.
        None => whole.canonicalize().unwrap_or_default(),
    };
    named.file_name().map_or_else(|| "study".into(), |name| name.to_string_lossy().into_owned())
}
