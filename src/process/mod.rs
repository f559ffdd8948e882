//! What is cut: cutting forces.

mod milling;

pub use milling::{ForceLaw, MillingForce};
