//! Writes the folders of new studies: of templates, and of examples.

use std::{
    io::ErrorKind,
    path::{Path, PathBuf},
};

use super::Example;
use crate::{
    files::{OutputFile, write_all},
    input::error::{Error, Result},
    questions::{Overrides, Study, StudyMachine, Template},
};

const README: &str = include_str!("study_readme.md");

/// Writes the study folder `folder`, which must not exist, of a template for its own machine or for `machine`. Returns the names of its files.
///
/// # Errors
/// The question cannot be asked of the machine, or the folder cannot be made.
pub fn write_template(template: &Template, machine: Option<&StudyMachine>, folder: &Path) -> Result<Vec<String>> {
    let name = study_name(folder, "NAME")?;
    let readme = README.replace("{name}", name).replace("{folder}", &folder.display().to_string());
    let mut files = vec![OutputFile::new("README.md", readme)];
    files.extend(template.filled(machine)?.into_iter().map(|(name, text)| OutputFile::new(name, text)));
    write_folder(folder, files)
}

/// Writes the example into `folder`, which must not exist, byte for byte, and beside it the examples whose files it reads, unless they are
/// there. Returns the names of all files, with their folders.
///
/// # Errors
/// A folder cannot be made.
pub fn write_example(example: &Example, folder: &Path) -> Result<Vec<PathBuf>> {
    study_name(folder, "--out")?;
    let files = |of: &Example| of.files.iter().map(|(name, bytes)| OutputFile::new(*name, *bytes)).collect();
    let mut written = Vec::new();
    let mut write = |folder: &Path, of: &Example| -> Result<()> {
        written.extend(write_folder(folder, files(of))?.into_iter().map(|name| folder.join(name)));
        Ok(())
    };
    write(folder, example)?;
    for other in example.neighbours() {
        let beside = folder.with_file_name(other.name);
        if !beside.exists() {
            write(&beside, other)?;
        }
    }
    Ok(written)
}

/// Makes `folder`, which must not exist, with these files; returns their names.
fn write_folder(folder: &Path, files: Vec<OutputFile>) -> Result<Vec<String>> {
    if let Some(parent) = folder.parent() {
        let created = std::fs::create_dir_all(parent);
        created.map_err(|source| Error::Write { file: parent.to_path_buf(), source })?;
    }
    // Fails where anything of this name exists.
    std::fs::create_dir(folder).map_err(|source| match source.kind() {
        ErrorKind::AlreadyExists => {
            let problem = "exists already and was left as it is: expected the name of a new folder";
            Error::argument(folder.display().to_string(), problem)
        }
        _ => Error::Write { file: folder.to_path_buf(), source },
    })?;
    let names = files.iter().map(|file| file.name.clone()).collect();
    write_all(folder, files)?;
    Ok(names)
}

/// Opens the study in `path` as [`Study::open`] does; where nothing is there, the error says how to get an example.
///
/// # Errors
/// As [`Study::open`].
pub fn open(path: &Path, overrides: &Overrides) -> Result<Study> {
    match Study::open(path, overrides) {
        Err(Error::Read { file, source }) if source.kind() == ErrorKind::NotFound && !path.exists() => {
            let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
            let example = Example::named(name).map_or("01_workspace_map", |example| example.name);
            let problem = format!(
                "there is no such study, neither a folder with study.toml nor a file; example studies are not installed with the program: \
                 kinetostat new --example {example} writes one"
            );
            Err(Error::Read { file, source: std::io::Error::new(ErrorKind::NotFound, problem) })
        }
        opened => opened,
    }
}

/// Device names of Windows, reserved in any case and with any extension.
const DEVICES: [&str; 4] = ["con", "prn", "aux", "nul"];
/// Device names of Windows that are followed by a digit.
const NUMBERED_DEVICES: [&str; 2] = ["com", "lpt"];

/// Returns whether `name` is reserved for a device on Windows.
fn is_device(name: &str) -> bool {
    let stem = name.split('.').next().unwrap_or_default().to_ascii_lowercase();
    let is_numbered = |device: &&str| matches!(stem.strip_prefix(*device).map(str::as_bytes), Some([digit]) if digit.is_ascii_digit());
    DEVICES.contains(&stem.as_str()) || NUMBERED_DEVICES.iter().any(is_numbered)
}

/// Returns the last part of `folder`, the study's name, if it is valid on any system: letters, digits, `_`, `-` and `.`, not beginning with
/// the last two, not ending with a dot, and no device of Windows. An error names the `argument`.
fn study_name<'a>(folder: &'a Path, argument: &str) -> Result<&'a str> {
    let name = folder.file_name().and_then(|name| name.to_str()).unwrap_or_default();
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "_-.".contains(c);
    let problem = if name.is_empty() || name.starts_with(['-', '.']) || !name.chars().all(is_plain) {
        "does not name a study: expected a last part of letters, digits, \"_\", \"-\" and \".\", beginning with a letter, digit or \"_\""
    } else if name.ends_with('.') || is_device(name) {
        "cannot be the name of a folder on Windows, where others may want to run the study: expected a last part that does not end with \
         \".\" and that, up to its first \".\", is not con, prn, aux, nul, com0 to com9 or lpt0 to lpt9"
    } else {
        return Ok(name);
    };
    Err(Error::argument(argument, format!("\"{}\" {problem}", folder.display())))
}
