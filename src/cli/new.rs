//! `kinetostat new`: writes a study folder to start from, or an example study.

use std::path::{Path, PathBuf};

use clap::Args;
use kinetostat::{
    input::error::{Error, Result},
    questions::{StudyMachine, Template},
    run::{
        Example,
        new_study::{write_example, write_template},
    },
};

use super::{Ending, choice, print};

/// Write a commented study folder that runs at once, for a machine of yours, or one of the example studies.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  kinetostat new map studies/13_stiff_corner
  kinetostat new placement where_to_clamp
  kinetostat run where_to_clamp
  kinetostat new map my_map --machine kr270                  (with chains, box and points of a built-in machine)
  kinetostat new identification mine --machine robot.toml    (of a machine file, which is copied into the folder)
  kinetostat new --example 01                                (an example study, to the folder 01_workspace_map)
  kinetostat new --example 02_groove_50mm --out groove")]
#[command(
    override_usage = "kinetostat new KIND NAME [--machine MACHINE]\n       kinetostat new --example EXAMPLE [--out FOLDER]"
)]
pub struct NewArguments {
    /// What the study asks
    #[arg(value_parser = choice::template(), required_unless_present = "example")]
    kind: Option<Template>,
    /// Folder to write, which must not exist; its last part names the study
    #[arg(required_unless_present = "example")]
    name: Option<PathBuf>,
    /// Built-in machine, or machine file, for which the study is written [default: the machine of the template]
    #[arg(long, short)]
    machine: Option<String>,
    /// Write this example study instead: its name, or how that begins
    #[arg(long, conflicts_with_all = ["kind", "name", "machine"])]
    example: Option<String>,
    /// Folder to write for the example, which must not exist [default: its name]
    #[arg(long, requires = "example")]
    out: Option<PathBuf>,
}

/// Runs `kinetostat new`: writes a study folder or an example, and prints what to do next.
pub fn new(arguments: &NewArguments) -> Result<Ending> {
    match (arguments, &arguments.example) {
        (NewArguments { out, .. }, Some(example)) => {
            let example = Example::named(example)?;
            let folder = out.clone().unwrap_or_else(|| example.name.into());
            let files = write_example(example, &folder)?;
            say_written(&folder, files.iter().map(|file| file.display().to_string()), "Next:")?;
        }
        (NewArguments { kind: Some(kind), name: Some(folder), machine, .. }, None) => {
            let machine = machine.as_deref().map(StudyMachine::named_or_file).transpose()?;
            let files = write_template(kind, machine.as_ref(), folder)?;
            let next = format!("Next: edit {}, then", folder.join("study.toml").display());
            say_written(folder, files.into_iter(), &next)?;
        }
        _ => {
            return Err(Error::argument(
                "KIND",
                "expected the kind of a study and a folder, such as `kinetostat new map mine`, or --example",
            ));
        }
    }
    Ok(Ending::Complete)
}

/// Prints which files were written, and the command that comes `next`.
fn say_written(folder: &Path, files: impl Iterator<Item = String>, next: &str) -> Result<()> {
    let (names, folder): (String, _) = (files.map(|name| format!("  {name}\n")).collect(), folder.display());
    print(&format!("Written to {folder}:\n{names}{next}\n  kinetostat run {folder}\n"))
}
