//! The one error type: what was being done, with which file, key and value.
//!
//! A point that cannot be solved is not an error but a status of the result; see [`crate::statics::Status`].

use std::path::PathBuf;

use crate::{
    compensation::BoundedError,
    process::{
        cutting::LoadError,
        toolpath::{FormatError, PositionsError, gcode, polyline},
    },
};

/// Wrong input or a broken file.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A file cannot be read.
    #[error("{}: cannot be read: {source}", file.display())]
    Read {
        /// The file.
        file: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A file cannot be written.
    #[error("{}: cannot be written: {source}", file.display())]
    Write {
        /// The file.
        file: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// Work was stopped from outside.
    #[error("stopped")]
    Stopped,
    /// An unfinished run cannot be gone on with.
    #[error("{}: {problem}", file.display())]
    Resume {
        /// The file it left.
        file: PathBuf,
        /// Why not.
        problem: String,
    },
    /// A file is not of the expected form: bad syntax, a missing or an unknown key, a value of the wrong type.
    #[error("{file}{}: {}{problem}", line.map(|l| format!(":{l}")).unwrap_or_default(), key_prefix(key))]
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
    #[error("{file}: {key}: {problem}")]
    Value {
        /// The file, built-in name or command-line option.
        file: String,
        /// Key path.
        key: String,
        /// What is wrong, with the value, and what was expected.
        problem: String,
    },
    /// A command-line argument makes no sense.
    #[error("{argument}: {problem}")]
    Argument {
        /// The option or argument.
        argument: String,
        /// What is wrong, with the value, and what was expected.
        problem: String,
    },
    /// A G-code program cannot be read or followed.
    #[error(transparent)]
    Gcode(#[from] gcode::GcodeError),
    /// A G-code program cannot be written.
    #[error(transparent)]
    GcodeWriting(#[from] gcode::RewriteError),
    /// A polyline cannot be read.
    #[error(transparent)]
    Polyline(#[from] polyline::PolylineError),
    /// Corrected positions do not fit their path.
    #[error(transparent)]
    Positions(#[from] PositionsError),
    /// Numbers cannot be written with so many decimals.
    #[error(transparent)]
    Format(#[from] FormatError),
    /// Corrections cannot keep their limits.
    #[error("limits: {0}")]
    Bounded(#[from] BoundedError),
    /// A path lacks what its cutting force needs.
    #[error("{file}: {source}")]
    Load {
        /// The path's file, or what else it is.
        file: String,
        /// What it lacks.
        source: LoadError,
    },
    /// A figure cannot be drawn.
    #[error("figure {name}: {problem}")]
    Figure {
        /// File stem of the figure.
        name: String,
        /// Why.
        problem: String,
    },
    /// A page cannot be rendered: a fault of its template.
    #[error("page {template}: {problem}")]
    Page {
        /// The template.
        template: String,
        /// Why.
        problem: String,
    },
}

/// Shorthand used throughout.
pub type Result<T> = std::result::Result<T, Error>;

fn key_prefix(key: &str) -> String {
    if key.is_empty() || key == "." { String::new() } else { format!("{key}: ") }
}
