//! Tests of bodies: distances that are known, sweeps against samples, meshes against their pieces.

mod closed_forms;
mod spec;
mod sweeps;
