//! What is cut: cutting forces.

mod milling;
pub mod toolpath;

pub use milling::{ForceLaw, MillingForce};
