//! Quantities, each declared once, of which tables, maps and pages of all questions follow; what a run leaves.
//!
//! A question names each number that it computes once, as a `Quantity` with unit, meaning and how it is had of what was found.
//! Columns of tables (`QuantityTable`), layers of pages, labels of figures (`GridMap`), extremes and their JSON (`Extremes`) follow
//! from that; setting, cautions and description follow from the [`LoadCase`](crate::simulation::LoadCase).

pub(crate) mod budget;
pub mod cautions;
#[cfg(not(target_family = "wasm"))]
pub mod clearance;
pub(crate) mod command_columns;
pub mod deflected_pose;
pub(crate) mod drive_columns;
mod drives;
mod extremes;
mod grid_map;
pub mod machine;
mod of_sources;
mod output;
pub(crate) mod play;
pub mod point_text;
mod quantity;
mod report_text;
mod setting;
mod table_of;
mod tolerance;

pub(crate) use drives::DriveQuantities;
pub(crate) use extremes::{Extremes, QuantityExtremes, ValueAt};
pub(crate) use grid_map::{GridMap, MapLayer, thinned_indices};
pub(crate) use of_sources::{acting_text, force_text, source_group};
pub use output::{Output, Run};
pub(crate) use quantity::{FoundOr, Quantity, layers};
pub use report_text::ReportText;
pub(crate) use setting::{direction, facts_of, grid_view, locked_fact, size_text, tool_axis_text};
pub(crate) use table_of::{QuantityTable, Streams, status_cells};
pub(crate) use tolerance::{ShareWithin, Tolerance};
