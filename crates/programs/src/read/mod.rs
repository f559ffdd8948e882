//! Readers of G-code, robot programs and polyline files.

pub(crate) mod gcode;
pub(crate) mod polyline;
pub(crate) mod robot;
pub(crate) mod scan;
