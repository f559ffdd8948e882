//! How anything is read: what machine files are read with ([`kinetostat_input`]), folders of files, rows of CSV, and what results were
//! computed from.

pub(crate) mod csv_rows;
mod folder;
mod inputs;

pub use folder::Folder;
pub use inputs::Inputs;
pub use kinetostat_input::{check, error, file, toml_file};
