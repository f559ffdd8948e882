//! The command line: parse → resolve → run → report.

mod cli;

use std::process::ExitCode;

use kinetostat::ending::exit_code;

fn main() -> ExitCode {
    let command = || {
        // First of all: a signal that comes before it would end the program without a word.
        cli::listen()?;
        cli::dispatch(cli::parse()?)
    };
    exit_code(command, cli::fail).into()
}
