//! G-code programs, written back with moved points.

mod check;
mod even;
#[cfg(not(target_family = "wasm"))]
pub(crate) mod feeds;
pub(crate) mod fit;
pub(crate) mod fold;
mod place;
mod rewrite;
mod split;
mod turn_words;
mod write_holes;
mod writer;

pub(crate) use {check::*, fit::*, fold::*, place::*, split::*, turn_words::*, write_holes::*, writer::*};
