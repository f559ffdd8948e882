//! How anything is read: files, bounded; TOML with line and key in errors; values checked; and the one error type.

pub mod check;
pub(crate) mod csv_rows;
pub mod error;
pub mod file;
pub(crate) mod toml_file;
