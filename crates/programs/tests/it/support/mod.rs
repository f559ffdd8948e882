//! Shared by the tests of programs.

#[path = "../../../../engine/tests/it/cases.rs"]
pub mod cases;
pub mod programs;
pub mod rs274;
