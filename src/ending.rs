//! How a command of the program ends: its exit code, and what is said of what went wrong.

use std::panic::{UnwindSafe, catch_unwind};

use crate::input::error::{Error, Result};

/// How a command ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ending {
    /// Everything that was asked is answered.
    Complete,
    /// Some points could not be solved; the tables say which and why.
    SomeUnsolved,
    /// It was stopped and can be gone on with.
    Stopped,
}

/// Exit code of a command that was stopped, as shells have it for Ctrl-C.
pub const STOPPED: u8 = 130;
/// Exit code for bad input, and files that cannot be read or written.
const BAD_INPUT: u8 = 2;
/// Exit code for a fault of the program itself.
const INTERNAL: u8 = 3;

impl Ending {
    /// Of what is answered as a whole or not.
    pub fn of(is_complete: bool) -> Self {
        if is_complete { Ending::Complete } else { Ending::SomeUnsolved }
    }

    fn exit_code(self) -> u8 {
        match self {
            Ending::Complete => 0,
            Ending::SomeUnsolved => 1,
            Ending::Stopped => STOPPED,
        }
    }
}

/// Runs a command and tells what went wrong by `say` and in the log. The exit code.
pub fn exit_code(command: impl FnOnce() -> Result<Ending> + UnwindSafe, say: impl Fn(&str)) -> u8 {
    match catch_unwind(command) {
        Ok(Ok(ending)) => ending.exit_code(),
        Ok(Err(Error::Stopped)) => {
            say("stopped");
            STOPPED
        }
        Ok(Err(error)) => {
            log::error!("{error}");
            say(&format!("error: {error}"));
            // Pictures and pages that cannot be made are faults of the program.
            let is_internal = matches!(error, Error::Figure { .. } | Error::Page { .. });
            if is_internal { INTERNAL } else { BAD_INPUT }
        }
        // The panic has said what it is.
        Err(_) => {
            log::error!("internal error");
            say("error: this is a fault of kinetostat, not of its input: please report it with the message above");
            INTERNAL
        }
    }
}
