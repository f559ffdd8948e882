//! Reports of a plan of measurements.

mod answer;
mod headline;
mod page;
mod pictures;
mod sheet;
mod summary;
mod tables;
mod text;
