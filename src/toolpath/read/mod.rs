//! Programs read and followed, format by format.

pub(crate) mod gcode;
pub(crate) mod polyline;
pub(crate) mod robot;
pub(crate) mod scan;
