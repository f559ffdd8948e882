//! The one error type: what failed, with file, key and value.
//!
//! A point that cannot be solved is not an error but a status of the result.

use std::path::PathBuf;

use crate::toml_file;

/// The error of wrong input or of a file that cannot be read or written.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A file cannot be read.
    #[error("{}: cannot be read: {source}", file.display())]
    Read {
        /// The file.
        file: PathBuf,
        /// The error of the operating system.
        source: std::io::Error,
    },
    /// A file cannot be written.
    #[error("{}: cannot be written: {source}", file.display())]
    Write {
        /// The file.
        file: PathBuf,
        /// The error of the operating system.
        source: std::io::Error,
    },
    /// Work was stopped from outside.
    #[error("stopped")]
    Stopped,
    /// Another shard of the work computes what is needed to go on; so end all shards but one.
    #[error("another part computes it")]
    OtherShard,
    /// An unfinished run is in the way, or cannot be gone on with.
    #[error("{}: {problem}", file.display())]
    Resume {
        /// The file that the unfinished run left.
        file: PathBuf,
        /// What is wrong with the unfinished run.
        problem: String,
        /// What can be done about it.
        remedy: Remedy,
    },
    /// A file is not of the expected form: bad syntax, a missing or an unknown key, a value of the wrong type.
    #[error("{file}{}: {}{problem}", line_suffix(*line), key_prefix(key))]
    Syntax {
        /// The file or built-in name.
        file: String,
        /// Line, from 1, where it is known.
        line: Option<usize>,
        /// Key path, empty where none applies.
        key: String,
        /// What is wrong and what was expected.
        problem: String,
    },
    /// A value is of the right type but makes no sense.
    #[error("{file}{}: {key}: {problem}", line_suffix(*line))]
    Value {
        /// The file, built-in name or command-line option.
        file: String,
        /// Line, from 1, where it is known.
        line: Option<usize>,
        /// Key path.
        key: String,
        /// What is wrong, with the value, and what was expected.
        problem: String,
    },
    /// Several errors of one cause.
    #[error("{problem}:{}", error_lines(errors))]
    Several {
        /// The cause.
        problem: String,
        /// The errors.
        errors: Vec<Error>,
    },
    /// A command-line argument makes no sense.
    #[error("{argument}: {problem}")]
    Argument {
        /// The option or argument.
        argument: String,
        /// What is wrong, with the value, and what was expected.
        problem: String,
    },
    /// A program or path cannot be read, followed or written; the message names the file and the line.
    #[error(transparent)]
    Program(Box<dyn std::error::Error + Send + Sync>),
    /// A figure cannot be drawn.
    #[error("figure {name}: {problem}")]
    Figure {
        /// File stem of the figure.
        name: String,
        /// Why the figure cannot be drawn.
        problem: String,
    },
    /// A page cannot be rendered: a fault of its template.
    #[error("page {template}: {problem}")]
    Page {
        /// The template.
        template: String,
        /// Why the page cannot be rendered.
        problem: String,
    },
}

/// What can be done about an unfinished run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Remedy {
    /// Going on with it, or beginning anew.
    ResumeOrRestart,
    /// Beginning anew: what it computed is lost.
    Restart,
    /// Another folder, or waiting for whoever uses it.
    Elsewhere,
}

impl Error {
    /// Creates the error of an `argument` that makes no sense: what is wrong with it and what was expected.
    pub fn argument(argument: impl Into<String>, problem: impl Into<String>) -> Self {
        Error::Argument { argument: argument.into(), problem: problem.into() }
    }

    /// Returns this error with the line of its value, from 1; `text` returns the text of a TOML file by its name in errors, or `None`.
    pub(crate) fn with_line<'a>(self, text: impl Fn(&str) -> Option<&'a str>) -> Self {
        let file_text = if let Error::Value { file, .. } = &self { text(file) } else { None };
        match file_text {
            Some(text) => self.in_toml(text),
            None => self,
        }
    }

    /// Returns this error with the line of its value in `text`, the TOML file at fault; other errors as they are.
    #[must_use]
    pub fn in_toml(mut self, text: &str) -> Self {
        if let Error::Value { line, key, .. } = &mut self {
            *line = toml_file::line_of(text, key);
        }
        self
    }

    /// Wraps the error of a program or path.
    pub fn program(source: impl std::error::Error + Send + Sync + 'static) -> Self {
        Error::Program(Box::new(source))
    }
}

/// The result of whatever fails with an [`Error`].
pub type Result<T> = std::result::Result<T, Error>;

/// Most errors of one cause that are told.
const MAX_TOLD: usize = 10;

/// Returns a line for each of the first errors, and how many more there are.
fn error_lines(errors: &[Error]) -> String {
    let lines: String = errors.iter().take(MAX_TOLD).map(|error| format!("\n  {error}")).collect();
    match errors.len().saturating_sub(MAX_TOLD) {
        0 => lines,
        more => format!("{lines}\n  and {more} more"),
    }
}

/// Returns a colon and the line for a message, or nothing where the line is not known.
fn line_suffix(line: Option<usize>) -> String {
    line.map_or_else(String::new, |line| format!(":{line}"))
}

/// Returns the key and a colon for a message, or nothing for the whole file.
fn key_prefix(key: &str) -> String {
    if key.is_empty() || key == "." { String::new() } else { format!("{key}: ") }
}
