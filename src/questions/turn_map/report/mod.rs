//! Reports of a map of turns.

mod answer;
mod headline;
mod page;
mod pictures;
mod summary;
mod table;
mod text;
