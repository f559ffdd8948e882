//! Programs of poses, written back with moved points.

mod blend;
mod circle;
#[cfg(not(target_family = "wasm"))]
mod fold;
mod listing;
mod rewrite;
mod split;
mod target_text;

pub(crate) use {blend::*, listing::*, split::*, target_text::*};
