//! Writes programs back with moved points; it uses the readers, which do not use it.

pub(crate) mod gcode;
pub(crate) mod polyline;
pub(crate) mod robot;
