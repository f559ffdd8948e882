//! How far a loaded machine leaves its path, what to tell the drives instead, and where to put the workpiece.
pub mod check;
pub mod compensation;
pub mod error;
pub mod machine;
pub mod process;
pub mod report;
pub mod spatial;
pub mod statics;
pub mod study;
mod toml_file;
