//! The tests of poses, screws and frames, in one binary.

#[path = "../../../engine/tests/it/cases.rs"]
mod cases;
mod poses;
