//! Tables of a process file that pages ignore: bodies of the cell, feeds, rotary axes, programs of robots, stock, and the search for γ.

pub mod cell;
pub(crate) mod feed;
pub(crate) mod redundancy;
pub(crate) mod robot;
pub(crate) mod rotary;
pub(crate) mod stock;
