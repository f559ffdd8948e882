//! `kinetostat upgrade`: rewrites study files of an older schema.

use std::path::{Path, PathBuf};

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
        is_own(&file)?;
        let text = toml_file::read(&file)?;
        rewritten.push((upgraded(&text, &file.display().to_string())?, file));
    }
    for (found, file) in rewritten {
        let shown = file.display();
        match found {
            Upgraded::Study(text) => {
                let name = prepare_beside(&file)?;
                write_beside(&file, vec![OutputFile::new(name, text)])?;
                print(&format!("{shown}: rewritten in schema 2\n"))?;
            }
            Upgraded::Current(why) => print(&format!("{shown}: left as it is, {why}\n"))?,
        }
    }
    Ok(Ending::Complete)
}

/// What a link leads to may be used by others.
fn is_own(file: &Path) -> Result<()> {
    if file.is_symlink() {
        let source = std::io::Error::other("is a link: name the file that it leads to");
        return Err(Error::Write { file: file.to_path_buf(), source });
    }
    Ok(())
}
