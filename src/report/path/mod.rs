//! Reports of a path study.

mod page;
mod pictures;
mod program;
mod summary;
mod tables;

pub use page::page;
pub use pictures::figures;
pub use program::{bounded_text, program_csv, program_json};
pub use summary::{methods_table, summary_json, summary_text};
pub use tables::{methods_csv, points_csv};
