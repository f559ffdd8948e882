//! Reports of a workspace map.

mod pictures;
mod summary;
mod table;

pub use pictures::figures;
pub use summary::{summary_json, summary_text};
pub use table::csv;
