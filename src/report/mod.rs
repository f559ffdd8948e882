//! The answers: tables, figures, summaries and the manifest. Results in, bytes out; computes no physics.

pub(crate) mod amplification;
pub mod cautions;
pub mod exchange;
pub mod figures;
pub(crate) mod grid_slices;
pub mod headline;
mod manifest;
mod output;
pub mod page;
pub(crate) mod point_words;
mod prepared;
mod recorded;
mod replace;
mod said;
pub(crate) mod table;
pub mod text_table;
mod visible;
pub(crate) mod words;
pub(crate) mod write;

pub use manifest::{Manifest, StatusCount};
pub use output::{Output, Run};
pub use prepared::PreparedFolder;
pub use recorded::Recorded;
pub use replace::{Foreign, may_replace};
pub use said::Said;
pub use visible::{visible, visible_json};
pub use words::{counted, if_any, millimetres, millimetres_in_table};
pub use write::{OutputFile, prepare, prepare_beside, remove, staging, write_all, write_beside};
pub(crate) use write::{clean, publish, staging_beside, temporary_file};

pub(crate) use crate::input::check::file_stem;
