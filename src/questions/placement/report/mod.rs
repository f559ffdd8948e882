//! Reports of a placement study.

mod advice;
mod answer;
mod compromises;
mod headline;
mod page;
mod pictures;
mod recommended;
mod summary;
mod tables;

pub use page::page;
pub use pictures::figures;
pub use summary::{entries_table, summary_json, summary_text};

pub use headline::known;
pub use tables::{candidates_table, sweep_table};
pub(crate) use tables::{cell_status, front_table, refinements_table};
