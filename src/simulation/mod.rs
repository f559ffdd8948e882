//! A path through the loaded machine: sources of error, tracking, commands, residual errors. Which machine answers for each source,
//! where it is tracked, what is commanded and what is left, block after block.

pub mod along_path;
#[cfg(not(target_family = "wasm"))]
pub mod clearance;
pub(crate) mod drawn_forces;
pub(crate) mod external_axes;
mod load_case;
pub(crate) mod path_blocks;
mod path_sums;
pub mod play;
pub(crate) mod settled;
pub(crate) mod sources;
pub mod spread;
pub mod spread_along;
mod status;
pub mod tasks;
mod tracked_path;
pub(crate) mod tracking;
pub(crate) mod within_limits;

pub use external_axes::with_drives_left;
pub use load_case::LoadCase;
pub use sources::{BySource, Machines, ROUNDING_MM, Source, settings};
pub use status::{Failure, SOLVED, status_of};
#[cfg(feature = "report")]
pub(crate) use status::{STATUSES, is_result_status, is_solved_status};
pub use tracked_path::TrackedPath;
