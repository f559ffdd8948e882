//! The program at the command line.

use std::process::{Command, Output};

pub fn kinetostat(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_kinetostat")).args(arguments).output().unwrap()
}

/// What a command that must end with 0 prints.
pub fn printed(arguments: &[&str]) -> String {
    let output = kinetostat(arguments);
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// Exit code, standard output and standard error.
pub fn told(arguments: &[&str]) -> (Option<i32>, String, String) {
    let output = kinetostat(arguments);
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (output.status.code(), text(output.stdout), text(output.stderr))
}
