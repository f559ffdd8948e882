//! The answers: tables, figures, summaries and the manifest. Results in, bytes out; computes no physics.

mod amplification;
pub mod cautions;
pub mod exchange;
pub mod figures;
mod grid_slices;
mod machine;
mod manifest;
pub mod page;
pub mod path;
pub mod placement;
mod point;
mod program_files;
mod replace;
pub mod superposition;
mod table;
pub mod validation;
mod visible;
mod words;
pub mod workspace_map;
mod write;

pub use machine::machine_text;
pub use manifest::{Manifest, StatusCount};
pub use point::{point_json, point_text, unreachable_json};
pub use program_files::ProgramFiles;
pub use replace::may_replace;
pub use visible::{visible, visible_json};
pub use words::{counted, if_any};
pub use write::{
    OutputFile, clean, prepare, prepare_beside, publish, remove, staging, temporary_file, write_all, write_beside,
};

pub use crate::check::file_stem;
