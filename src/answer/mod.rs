//! What every answer is made with: the run and its output, cautions, and words for sources of error.

#[cfg(feature = "report")]
pub mod cautions;
#[cfg(feature = "report")]
pub(crate) mod command_columns;
#[cfg(feature = "report")]
pub(crate) mod deflected_pose;
#[cfg(feature = "report")]
pub(crate) mod grid_slices;
pub(crate) mod halton;
#[cfg(feature = "report")]
mod output;
#[cfg(feature = "report")]
pub(crate) mod point_words;
#[cfg(feature = "report")]
mod said;
#[cfg(feature = "report")]
pub(crate) mod source_group;
#[cfg(feature = "report")]
pub(crate) mod source_words;

#[cfg(feature = "report")]
pub use output::{Output, Run};
#[cfg(feature = "report")]
pub use said::Said;
