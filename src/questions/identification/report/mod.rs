//! Reports of an identification.

mod answer;
mod headline;
mod page;
mod pictures;
pub mod predicted;
mod summary;
mod tables;
mod text;

pub(crate) use text::{ANYTHING, half_width};
