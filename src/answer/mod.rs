//! What every question is made with, and of which its answer is derived: a scene, a list of quantities, tables and maps of them.
//!
//! A question names each number that it computes once, as a `Quantity` with unit, meaning and how it is had of what was found.
//! Columns of tables (`TableOf`), layers of pages, labels of figures (`GridMap`), extremes and their JSON (`Extremes`) follow
//! from that; setting, cautions and description follow from the [`Scene`].

#[cfg(feature = "report")]
pub mod cautions;
#[cfg(feature = "report")]
pub(crate) mod command_columns;
#[cfg(feature = "report")]
pub(crate) mod deflected_pose;
#[cfg(feature = "report")]
mod drives;
#[cfg(feature = "report")]
mod extremes;
#[cfg(feature = "report")]
mod grid_map;
pub(crate) mod halton;
#[cfg(feature = "report")]
mod of_sources;
#[cfg(feature = "report")]
mod output;
mod overlapped;
#[cfg(feature = "report")]
pub(crate) mod point_words;
#[cfg(feature = "report")]
mod quantity;
#[cfg(feature = "report")]
mod said;
mod scene;
#[cfg(feature = "report")]
mod setting;
#[cfg(feature = "report")]
mod table_of;
#[cfg(feature = "report")]
mod tolerance;

#[cfg(feature = "report")]
pub(crate) use drives::OfDrives;
#[cfg(feature = "report")]
pub(crate) use extremes::{Extremes, Found, OfQuantities};
#[cfg(feature = "report")]
pub(crate) use grid_map::{Drawn, GridMap};
#[cfg(feature = "report")]
pub(crate) use of_sources::{acting, source_group};
#[cfg(feature = "report")]
pub use output::{Output, Run};
pub(crate) use overlapped::overlapped;
#[cfg(feature = "report")]
pub(crate) use quantity::{FoundOr, Quantity, layers};
#[cfg(feature = "report")]
pub use said::Said;
pub use scene::{Scene, Shown};
#[cfg(feature = "report")]
pub(crate) use setting::{direction, facts_of, size_words, tool_axis_words};
#[cfg(feature = "report")]
pub(crate) use table_of::{Streams, TableOf, status_cells};
#[cfg(feature = "report")]
pub(crate) use tolerance::{ShareWithin, Tolerance};
