//! Output files: tables in every format, written whole or not at all, with a manifest; and their words.

pub mod exchange;
mod manifest;
mod recorded;
mod replace;
pub mod text_table;
mod unfinished;
pub(crate) mod visible;
pub(crate) mod words;
pub(crate) mod write;

pub(crate) use manifest::read_record;
pub use manifest::{Manifest, StatusCount};
pub use recorded::Recorded;
pub use replace::{Foreign, check_may_replace};
pub use unfinished::{OutputLock, PartialFile, Staging, remove_unfinished};
pub use visible::{display_json, visible, visible_json};
pub use words::{counted, millimetres, millimetres_in_table, or_dash, per_second, position, with_minus_signs};
pub(crate) use write::temporary_beside;
pub use write::{
    OutputFile, PreparedFolder, Step, Transaction, lock_folder, prepare, prepare_beside, remove, staging,
    staging_beside, temporary_file, write_all, write_beside,
};

pub(crate) use crate::input::check::file_stem;
