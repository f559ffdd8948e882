//! Reports of a workspace map, gathered point by point: memory does not grow with the grid.

mod answer;
mod bent;
mod headline;
mod page;
mod pictures;
mod summary;
mod table;
mod text;

pub use answer::answer;
pub use page::page;
pub use pictures::Pictures;
pub use summary::Summary;
pub use table::table;
pub use text::text;

use crate::{
    files::exchange::{Image, Layer},
    questions::map::WorkspaceMapStudy,
};

/// The map as an image of [`table()`], called `map`.
pub fn image(study: &WorkspaceMapStudy) -> Image {
    let layer = Layer { table: "map", keys: &["source"], vectors: &["deflection", "departure"] };
    Image { grid: study.grid.clone(), layers: vec![layer] }
}
