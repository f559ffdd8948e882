//! The tests of the engine that need nothing private, in one binary; those over whole machines are the root package's.

#[path = "../../src/cases.rs"]
mod cases;
mod lanes;
mod machines;
mod sections;
mod side_by_side;
mod spatial;
mod stiffness;
