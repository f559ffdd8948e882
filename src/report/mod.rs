//! The answers: tables, figures, summaries and the manifest. Results in, bytes out; computes no physics.

mod amplification;
pub mod exchange;
pub mod figures;
mod grid_slices;
mod machine;
mod manifest;
pub mod page;
pub mod path;
pub mod placement;
mod point;
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
pub use visible::{visible, visible_json};
pub use words::counted;
pub use write::{OutputFile, clean, prepare, publish, remove, staging, temporary_file, write_all};

pub use crate::check::file_stem;
