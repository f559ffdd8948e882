//! The command line: parse → resolve → run → report.

mod cli;

use std::{
    panic::{UnwindSafe, catch_unwind},
    process::ExitCode,
};

use clap::Parser;
use cli::Ending;
use kinetostat::input::error::{Error, Result};

/// Exit code for bad input, and files that cannot be read or written.
const BAD_INPUT: u8 = 2;
/// Exit code for a fault of the program itself.
const INTERNAL: u8 = 3;

fn main() -> ExitCode {
    exit_code(|| {
        // First of all: a signal that comes before it would end the program without a word.
        cli::listen()?;
        cli::dispatch(cli::Arguments::parse())
    })
    .into()
}

/// Runs a command and says on standard error and in the log what went wrong.
fn exit_code(command: impl FnOnce() -> Result<Ending> + UnwindSafe) -> u8 {
    match catch_unwind(command) {
        Ok(Ok(ending)) => ending.exit_code(),
        Ok(Err(Error::Stopped)) => {
            cli::say("stopped");
            cli::STOPPED
        }
        Ok(Err(error)) => {
            log::error!("{error}");
            cli::say(&format!("error: {error}"));
            // Pictures and pages that cannot be made are faults of the program.
            let is_internal = matches!(error, Error::Figure { .. } | Error::Page { .. });
            if is_internal { INTERNAL } else { BAD_INPUT }
        }
        // The panic has said what it is.
        Err(_) => {
            log::error!("internal error");
            eprintln!(
                "error: this is a fault of kinetostat, not of its input: please report it with the message above"
            );
            INTERNAL
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faults_of_the_program_have_a_code_of_their_own() {
        assert_eq!(exit_code(|| Ok(Ending::Complete)), 0);
        assert_eq!(exit_code(|| Ok(Ending::SomeUnsolved)), 1);
        assert_eq!(exit_code(|| Err(Error::Argument { argument: "--out".into(), problem: "is wrong".into() })), 2);
        assert_eq!(exit_code(|| Err(Error::Figure { name: "map".into(), problem: "is wrong".into() })), 3);
        assert_eq!(exit_code(|| panic!("a fault for a test")), 3);
    }
}
