//! Reports of a validation study.

mod agreement;
mod answer;
mod page;
mod pictures;
mod summary;
mod tables;

pub use answer::answer;
pub use page::page;
pub use pictures::figures;
pub(crate) use summary::summary_table;
pub use summary::{summary_json, summary_text};
pub use tables::{quoted_table, variants_table};
