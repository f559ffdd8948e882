//! Programs written back with moved points: it uses all that is read, and nothing that is read uses it.

pub(crate) mod gcode;
pub(crate) mod polyline;
pub(crate) mod robot;
