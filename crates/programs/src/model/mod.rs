//! The data of paths and programs: points, moves, words, faults and options.

pub(crate) mod gcode;
pub(crate) mod generate;
pub(crate) mod number;
pub(crate) mod orientation;
pub(crate) mod path;
pub(crate) mod program;
pub(crate) mod robot;
pub(crate) mod sampling;
pub(crate) mod tool;
pub(crate) mod way;

pub(crate) use {number::*, orientation::*, path::*, program::*, sampling::*, way::*};
