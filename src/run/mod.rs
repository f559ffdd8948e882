//! Studies run into folders, and shared out in parts.

mod into_folder;
pub mod parts;

pub use into_folder::{Begin, BegunRun, Finished, FolderRun, RunOptions};
