//! Reports of a superposition study; the map is gathered point by point, so that memory does not grow with the grid.

mod answer;
mod headline;
mod json;
mod page;
mod pictures;
mod summary;
mod tables;
mod text;

pub use json::summary_json;
pub use page::page;
pub use pictures::Pictures;
pub use summary::Summary;
pub use tables::{
    ablation_table, largest_factors_table, locations_table, map_table, safe_load_table, scaling_table, slopes_table,
};
pub use text::summary_text;

use crate::{
    files::exchange::{Image, Layer},
    questions::superposition::{
        LocationResult, SuperpositionStudy,
        ablation::{Ablation, Cause},
        departure::Followed,
    },
    simulation::ROUNDING_MM,
};

/// The maps as an image of [`map_table`] and [`safe_load_table`], called `map` and `safe_load`.
pub fn image(study: &SuperpositionStudy) -> Image {
    let departures = Layer { table: "map", keys: &["sum", "followed"], vectors: &["departure"] };
    let safe = Layer { table: "safe_load", keys: &[], vectors: &[] };
    Image { grid: study.grid.clone(), layers: vec![departures, safe] }
}

fn words(cause: Cause) -> &'static str {
    match cause {
        Cause::Point => "shift of the evaluation point",
        Cause::Chains => "chains turned and bent (another stiffness matrix)",
        Cause::Preload => "internal forces (geometric stiffness)",
        Cause::Load => "cutting force (geometric stiffness)",
        Cause::Interaction => "interaction of point and machine",
    }
}

/// The tool angle at which the departure of the tool tip is largest, and its parts there.
fn worst_ablation(location: &LocationResult) -> Option<&Ablation> {
    let size = |ablation: &Ablation| ablation.departure.tool.norm();
    let all = location.ablation.as_ref().ok()?.iter();
    all.fold(None, |worst, here| match worst {
        Some(worst) if size(worst) >= size(here) => Some(worst),
        _ => Some(here),
    })
}

/// How much each part contributes to the length of the departure, mm: its component along the departure. They add up to
/// the length; `None` where there is no departure.
fn contributions(ablation: &Ablation, followed: Followed) -> Option<[f64; 5]> {
    let departure = ablation.departure.of(followed);
    let direction = departure.try_normalize(ROUNDING_MM)?;
    Some(ablation.parts.map(|part| part.of(followed).dot(&direction)))
}
