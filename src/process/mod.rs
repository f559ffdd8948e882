//! What is cut: toolpaths, the cutting force at each of their points, and where the workpiece stands.

mod csv_rows;
pub mod cutting;
mod cutting_rule;
mod milling;
mod placement;
pub mod toolpath;
mod workpiece;

pub use cutting_rule::CuttingRule;
pub use milling::{ForceLaw, MillingForce};
pub use placement::{PathReference, Placed, Placement};
pub use workpiece::{Extent, Feature, ForbiddenBox};
