//! A machine looked at: at one point, and as a whole.

pub mod machine_check;
pub mod point;
