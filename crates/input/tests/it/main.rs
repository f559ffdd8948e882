//! The tests of what files are read with, in one binary.

mod names;
mod toml_files;
