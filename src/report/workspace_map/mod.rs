//! Reports of a workspace map.

mod page;
mod pictures;
mod summary;
mod table;

pub use page::page;
pub(in crate::report) use page::source_group;
pub use pictures::figures;
pub use summary::{summary_json, summary_text};
pub use table::csv;
