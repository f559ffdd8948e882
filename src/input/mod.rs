//! Reads files and checks values, with file, line and key in errors; the one error type. What machine files need is in the crate
//! [`kinetostat_input`]; here are folders of files, and the inputs that results were computed from.

mod folder;
mod inputs;

pub use folder::Folder;
pub use inputs::Inputs;
#[cfg(feature = "report")]
pub(crate) use inputs::to_hex;
pub use kinetostat_input::{check, csv_rows, error, file, names, toml_file};
