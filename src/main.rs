//! The command line: parse → resolve → run → report.

mod cli;

use std::{panic::catch_unwind, process::ExitCode};

use clap::Parser;
use kinetostat::error::Error;

/// Exit code for a fault of the program itself.
const INTERNAL: u8 = 3;

fn main() -> ExitCode {
    let arguments = cli::Arguments::parse();
    match catch_unwind(|| cli::dispatch(arguments)) {
        Ok(Ok(outcome)) => outcome.exit_code(),
        Ok(Err(error)) => {
            log::error!("{error}");
            eprintln!("error: {error}");
            ExitCode::from(if is_internal(&error) { INTERNAL } else { 2 })
        }
        // The panic has said what it is.
        Err(_) => {
            log::error!("internal error");
            eprintln!(
                "error: this is a fault of kinetostat, not of its input: please report it with the message above"
            );
            ExitCode::from(INTERNAL)
        }
    }
}

/// Pictures and pages that cannot be made are faults of the program.
fn is_internal(error: &Error) -> bool {
    matches!(error, Error::Figure { .. } | Error::Page { .. })
}
