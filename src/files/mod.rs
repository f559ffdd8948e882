//! Output files: tables in every format, written whole or not at all, with a manifest; and their words.

pub mod exchange;
mod manifest;
mod recorded;
mod replace;
pub(crate) mod table;
pub mod text_table;
pub(crate) mod visible;
pub(crate) mod words;
pub(crate) mod write;

pub(crate) use manifest::record_in;
pub use manifest::{Manifest, StatusCount};
pub use recorded::Recorded;
pub use replace::{Foreign, may_replace};
pub use visible::{shown_json, visible, visible_json};
pub use words::{counted, if_any, millimetres, millimetres_in_table, per_second, position, signed};
pub(crate) use write::temporary_beside;
pub use write::{
    OutputFile, PreparedFolder, Step, Transaction, clean, prepare, prepare_beside, remove, staging, staging_beside,
    temporary_file, write_all, write_beside,
};

pub(crate) use crate::input::check::file_stem;
