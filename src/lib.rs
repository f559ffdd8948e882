pub mod check;
pub mod compensation;
pub mod error;
pub mod machine;
pub mod process;
pub mod spatial;
pub mod statics;
mod toml_file;
