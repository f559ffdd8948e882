//! Reports of a path study, gathered part by part: memory does not grow with the path.

mod answer;
pub(crate) mod cutting_force;
mod headline;
mod magnified;
mod page;
mod pictures;
mod summary;
mod tables;
mod text;
mod thinned;

pub use page::page;
pub(crate) use page::{ANGLE, along_columns, points_view};
pub use pictures::Pictures;
pub(crate) use summary::methods_text;
pub use summary::{Summary, facts_text, failures_text};
pub(crate) use tables::{methods_table, points_columns, points_table};
pub use text::text;
pub(crate) use thinned::{Curve, drawn};
