//! `kinetostat new`: writes a study folder to start from.

use std::{
    io::ErrorKind,
    path::{Path, PathBuf},
};

use clap::Args;
use kinetostat::{
    files::{OutputFile, write_all},
    input::error::{Error, Result},
    questions::Template,
};

use super::{Ending, choice, print};

/// Write a commented study folder that runs at once.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  kinetostat new map studies/11_stiff_corner
  kinetostat new placement where_to_clamp
  kinetostat run where_to_clamp")]
pub struct NewArguments {
    /// What the study asks
    #[arg(value_parser = choice::template())]
    kind: Template,
    /// Folder to write, which must not exist; its last part names the study
    name: PathBuf,
}

const README: &str = include_str!("templates/README.md");

pub fn new(arguments: &NewArguments) -> Result<Ending> {
    let folder = &arguments.name;
    let name = study_name(folder)?;
    if let Some(parent) = folder.parent() {
        let made = std::fs::create_dir_all(parent);
        made.map_err(|source| Error::Write { file: parent.to_path_buf(), source })?;
    }
    // Fails where anything of this name exists.
    std::fs::create_dir(folder).map_err(|source| match source.kind() {
        ErrorKind::AlreadyExists => {
            let problem = "exists already and was left as it is: expected the name of a new folder";
            Error::argument(folder.display().to_string(), problem)
        }
        _ => Error::Write { file: folder.clone(), source },
    })?;
    let shown = folder.display().to_string();
    let readme = README.replace("{name}", name).replace("{folder}", &shown);
    let mut files = vec![OutputFile::new("README.md", readme)];
    files.extend(arguments.kind.files.iter().map(|(name, content)| OutputFile::new(*name, *content)));
    let names: String = files.iter().map(|file| format!("  {}\n", file.name)).collect();
    let said = format!("Written to {shown}:\n{names}");
    write_all(folder, files)?;
    print(&format!("{said}Next: edit {}, then\n  kinetostat run {shown}\n", folder.join("study.toml").display()))?;
    Ok(Ending::Complete)
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
/// the last two, not ending with a dot, and no device of Windows.
fn study_name(folder: &Path) -> Result<&str> {
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
    Err(Error::argument("NAME", format!("\"{}\" {problem}", folder.display())))
}
