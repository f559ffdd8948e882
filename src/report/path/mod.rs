//! Reports of a path study, gathered part by part: memory does not grow with the path.

mod command;
mod page;
mod pictures;
mod program;
mod summary;
mod tables;
mod thinned;

pub use page::page;
pub(in crate::report) use page::points_view;
pub use pictures::Pictures;
pub use program::{bounded_text, exceeded_text, program_columns, program_json, program_table};
pub use summary::{Summary, facts_text, failures_text, methods_text};
pub use tables::{methods_table, points_columns, points_table};
