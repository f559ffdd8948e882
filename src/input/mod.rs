//! How anything is read: files, bounded; TOML with line and key in errors; values checked; and the one error type.

pub mod check;
pub(crate) mod csv_rows;
pub mod error;
#[cfg(feature = "study")]
pub mod file;
mod folder;
mod inputs;
pub mod toml_file;

pub use folder::Folder;
pub use inputs::Inputs;
