//! Reports of a validation study.

mod agreement;
mod answer;
mod headline;
mod page;
mod pictures;
mod summary;
mod tables;

pub use page::page;
pub use pictures::figures;
pub(crate) use summary::summary_table;
pub use summary::{differences, summary_json};
pub use tables::{quoted_table, variants_table};
