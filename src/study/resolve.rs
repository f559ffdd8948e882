//! The keys that all study files have, and messages for those of the other schema.

use std::path::Path;

use super::spec::{Header, SCHEMA, SCHEMAS};
use crate::{
    input::{Folder, check::Check, error::Result},
    machine::{Machine, catalogue},
};

/// Checks the keys of a study of any kind; its machine and the text of the machine's file.
pub(super) fn header(header: &Header, folder: &Folder, check: &Check) -> Result<(Machine, String)> {
    if !SCHEMAS.contains(&header.schema) {
        let problem = format!("this program reads versions 1 and {SCHEMA}, got {}", header.schema);
        return check.key("schema").fail(problem);
    }
    if header.question.trim().is_empty() {
        return check.key("question").fail("must be a sentence, which is printed with the answer, got none".into());
    }
    dialect(header, check)?;
    machine(&header.machine, folder, &check.key("machine"))
}

/// Refuses keys of the other schema.
fn dialect(header: &Header, check: &Check) -> Result<()> {
    if header.schema != SCHEMA {
        let problem = format!("is a key of schema {SCHEMA}; `kinetostat upgrade` rewrites a file of schema 1");
        return if header.process.is_some() { check.key("process").fail(problem) } else { Ok(()) };
    }
    let old = [
        ("milling", header.milling.is_some(), "[process.force.path_frame]"),
        ("chain_error", header.chain_error.is_some(), "[[process.chain_error]]"),
    ];
    match old.iter().find(|(_, is_given, _)| *is_given) {
        Some((key, _, now)) => check.key(key).fail(format!("is a key of schema 1; expected {now} in schema {SCHEMA}")),
        None => Ok(()),
    }
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
