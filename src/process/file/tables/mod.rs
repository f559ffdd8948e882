//! Tables of a process file that pages ignore: feeds, rotary axes, programs of robots, stock, and the search for γ.

pub(crate) mod feed;
pub(crate) mod redundancy;
pub(crate) mod robot;
pub(crate) mod rotary;
mod stl;
pub(crate) mod stock;
