//! Reports of a path study.

mod page;
mod pictures;
mod program;
mod summary;
mod tables;

pub use page::page;
pub(in crate::report) use page::points_view;
pub use pictures::figures;
pub use program::{bounded_text, program_json, program_table};
pub use summary::{methods_text, summary_json, summary_text};
pub use tables::{methods_table, points_table};
