//! The process: cutting forces along a toolpath, where the workpiece stands, whether a machine can follow, the process file.

mod cut_path;
pub mod cutting;
mod cutting_rule;
pub mod feed;
pub mod file;
#[cfg(feature = "report")]
pub mod machined;
mod milling;
mod not_followed;
#[cfg(not(target_family = "wasm"))]
mod part;
mod placement;
mod program_file;
mod redundancy;
#[cfg(not(target_family = "wasm"))]
mod robot_file;
#[cfg_attr(target_family = "wasm", path = "no_stock.rs")]
pub mod stock;
pub(crate) mod tilt;
mod tool_direction;
pub mod uncertainty;
mod unknown_force;
mod verdict_basis;
mod verdict_force;
mod workpiece;

pub use cut_path::{Bend, BentWall, CutPath, Engaged, UnknownForce};
pub use cutting_rule::CuttingRule;
pub use file::Process;
pub use milling::{ForceLaw, MillingForce};
pub use placement::{PathReference, PlacedWorkpiece, Placement};
pub use program_file::program_inputs;
pub use redundancy::{GammaChoice, RedundancyCost, RedundancyObjective, RedundancySettings};
pub use unknown_force::{ForceText, KnownForce};
pub use verdict_basis::{Basis, VerdictTable};
pub(crate) use verdict_basis::{TemperatureSpec, VerdictSpec};
pub use verdict_force::{RightForce, VerdictForce};
pub use workpiece::{Extent, Feature, ForbiddenBox};
