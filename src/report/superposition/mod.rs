//! Reports of a superposition study.

mod extremes;
mod json;
mod page;
mod pictures;
mod tables;
mod text;

pub use json::summary_json;
pub use page::page;
pub use pictures::figures;
pub use tables::{ablation_csv, largest_factors_csv, locations_csv, map_csv, safe_load_csv, scaling_csv, slopes_csv};
pub use text::summary_text;

use crate::study::superposition::{
    LocationResult,
    ablation::{Ablation, Cause},
    departure::Followed,
    growth::ROUNDING_MM,
};

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
