//! What to command instead: actuator coordinates that put the loaded tool where it should be.

mod direct;

pub use direct::{Compensated, Target, compensate_directly, tool_error};
