//! The tests of the engine that need nothing private, in one binary; those over whole machines are the root package's.

mod bodies;
mod cases;
mod conditioning;
mod counted;
mod lanes;
mod linear_algebra;
mod machines;
mod one_step;
mod operations;
mod sections;
mod side_by_side;
mod singularities;
mod solver;
mod stiffness;
