//! Reports of a workspace map.

mod page;
mod pictures;
mod summary;
mod table;

pub use page::page;
pub(in crate::report) use page::source_group;
pub use pictures::figures;
pub use summary::{summary_json, summary_text};
pub use table::table;

use super::exchange::{Image, Layer};
use crate::study::workspace_map::WorkspaceMap;

/// The map as an image of [`table()`], called `map`.
pub fn image(map: &WorkspaceMap) -> Image {
    let layer = Layer { table: "map", keys: &["source"], vectors: &["deflection", "departure"] };
    Image { grid: map.study.grid.clone(), layers: vec![layer] }
}
