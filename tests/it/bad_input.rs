//! Broken input and its exact messages.
//!
//! Every file in `tests/bad_input/machines`, `processes` and `studies` is broken in one way. Its first line says what the
//! program must answer: `# expects: <message>`, with the path of the file itself reduced to what follows its folder.

use std::{
    fs,
    path::{Path, PathBuf},
};

use kinetostat::{
    input::error::Error,
    machine::Machine,
    process::Process,
    questions::{Overrides, Study},
};

/// Fewer files than this in a folder means that files were lost.
const LEAST_FILES: usize = 30;

/// The broken files of one kind; the test fails if they are missing.
fn files(kind: &str) -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/bad_input").join(kind);
    let entries = fs::read_dir(&folder).unwrap_or_else(|e| panic!("{} is missing: {e}", folder.display()));
    let mut files: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    files.retain(|file| file.extension().is_some_and(|extension| extension == "toml"));
    files.sort();
    assert!(files.len() >= LEAST_FILES, "{} holds only {} files", folder.display(), files.len());
    files
}

/// The message announced in the first line.
fn expected(file: &Path) -> String {
    let bytes = fs::read(file).unwrap();
    let text = String::from_utf8_lossy(&bytes);
    let first = text.lines().next().unwrap_or_default();
    let message = first.strip_prefix("# expects: ");
    message.unwrap_or_else(|| panic!("{}: no \"# expects: \" in the first line", file.display())).to_string()
}

/// Opens all files of a kind and reports every wrong message at once.
fn check_messages<T>(kind: &str, open: impl Fn(&Path) -> Result<T, Error>) {
    let mut wrong = String::new();
    for file in files(kind) {
        let found = match open(&file) {
            Ok(_) => "accepted".to_string(),
            Err(error) => error.to_string().replace(&format!("{}/", file.parent().unwrap().display()), ""),
        };
        let expected = expected(&file);
        if found != expected {
            wrong += &format!("{}\n  expected: {expected}\n  found:    {found}\n", file.display());
        }
    }
    assert!(wrong.is_empty(), "\n{wrong}");
}

#[test]
fn broken_machine_files_are_refused_with_their_message() {
    check_messages("machines", Machine::from_file);
}

#[test]
fn broken_process_files_are_refused_with_their_message() {
    let machine = Machine::named_or_file("orthoglide").unwrap();
    check_messages("processes", |file| Process::open(file, &machine));
}

#[test]
fn broken_study_files_are_refused_with_their_message() {
    check_messages("studies", |file| Study::open(file, &Overrides::default()));
}
