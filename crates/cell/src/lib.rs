//! Named bodies on frames: how far apart they are, and how near they come while the frames move. Knows no machine.
//!
//! Lengths are mm. A [`Cell`] holds [`Body`]s, each of convex [`Shape`]s and fixed to a frame; poses of the frames come from outside.
//! [`Cell::nearest`] measures one state, [`Cell::sweep`] a motion between two, by conservative advancement: what lies between two states that were
//! looked at is cleared by a bound on how far a point can move, not by a sample.

#![warn(missing_docs)]

mod body;
mod mesh;
mod separation;
mod shape;
pub mod spec;
mod stl;
mod sweep;

pub use body::{Body, BodyFault, BodyGrade, Cell, Separation};
pub use mesh::{MAX_TRIANGLES, MeshFault, pieces_of_mesh};
pub use shape::{Shape, ShapeFault};
pub use stl::{Mesh, read_stl};
pub use sweep::{Ball, Motion, Nearest, SweepEnd, SweepOptions};

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
