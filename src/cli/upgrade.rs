//! `kinetostat upgrade`: rewrites study files of an older schema.

use std::{
    fs,
    path::{Path, PathBuf},
};

use clap::Args;
use kinetostat::{
    input::{
        error::{Error, Result},
        toml_file,
    },
    report::{OutputFile, prepare_beside, write_beside},
    study::upgrade::{Upgraded, upgrade as upgraded},
};

use super::{Ending, print};

/// Rewrite study files of schema 1 in schema 2, in their place; comments stay.
#[derive(Debug, Args)]
#[command(after_help = "\
In schema 2 a study names a process file (process = \"process.toml\") or holds the tables of one ([process.force.path_frame],
[[process.chain_error]], …). Files of schema 1 are still read; process and machine files are as they were.

Examples:
  kinetostat upgrade studies/my_map
  kinetostat upgrade studies/*/study.toml")]
pub struct UpgradeArguments {
    /// Study files, or folders with a study.toml
    #[arg(required = true)]
    files: Vec<PathBuf>,
}

pub fn upgrade(arguments: &UpgradeArguments) -> Result<Ending> {
    let mut rewritten = Vec::new();
    for path in &arguments.files {
        let file = if path.is_dir() { path.join("study.toml") } else { path.clone() };
        let text = toml_file::read(&file)?;
        let folder = file.parent().map(Path::to_path_buf).unwrap_or_default();
        let found = upgraded(&text, &file.display().to_string(), folder)?;
        if matches!(found, Upgraded::Study(_)) {
            may_rewrite(&file)?;
        }
        rewritten.push((found, file));
    }
    for (found, file) in rewritten {
        let shown = file.display();
        match found {
            Upgraded::Study(text) => {
                let fault = |source| Error::Write { file: file.clone(), source };
                let mode = fs::metadata(&file).map_err(fault)?.permissions();
                write_beside(&file, vec![OutputFile::new(prepare_beside(&file)?, text)])?;
                fs::set_permissions(&file, mode).map_err(fault)?;
                print(&format!("{shown}: rewritten in schema 2\n"))?;
            }
            Upgraded::Current(why) => print(&format!("{shown}: left as it is, {why}\n"))?,
        }
    }
    Ok(Ending::Complete)
}

/// Whether `file` may be replaced: it is no link and has no other name, its owner may write it, and so may we its folder.
fn may_rewrite(file: &Path) -> Result<()> {
    let fault = |problem: &str| Error::Write { file: file.to_path_buf(), source: std::io::Error::other(problem) };
    let found = fs::symlink_metadata(file).map_err(|source| Error::Read { file: file.to_path_buf(), source })?;
    if found.is_symlink() {
        return Err(fault("is a link: name the file that it leads to"));
    }
    #[cfg(unix)]
    if std::os::unix::fs::MetadataExt::nlink(&found) > 1 {
        return Err(fault("has other names (hard links), which would keep the old text"));
    }
    if found.permissions().readonly() {
        return Err(fault("is read-only"));
    }
    prepare_beside(file).map(drop)
}
