//! `kinetostat completions`: what a shell needs to complete commands, options and their values.

use clap::{Args, CommandFactory};
use clap_complete::{Shell, generate};
use kinetostat::input::error::Result;

use super::{Arguments, Ending, print};

/// Print what a shell needs to complete commands, options and their values.
#[derive(Debug, Args)]
#[command(after_help = "\
A new shell has them where its start reads the file: bash-completion looks into ~/.local/share/bash-completion/completions, fish into
~/.config/fish/completions, zsh into the folders of $fpath for a file _kinetostat.

Examples:
  kinetostat completions bash > ~/.local/share/bash-completion/completions/kinetostat
  kinetostat completions fish > ~/.config/fish/completions/kinetostat.fish
  kinetostat completions zsh > ~/.zfunc/_kinetostat")]
pub struct CompletionsArguments {
    /// The shell
    shell: Shell,
}

pub fn completions(arguments: &CompletionsArguments) -> Result<Ending> {
    let mut script = Vec::new();
    generate(arguments.shell, &mut Arguments::command(), "kinetostat", &mut script);
    print(&String::from_utf8_lossy(&script))?;
    Ok(Ending::Complete)
}
