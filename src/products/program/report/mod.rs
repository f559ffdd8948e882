//! Reports of a compensated program: its points, what limits do, what was proved, and a page of it.

mod blocks;
mod findings;
mod headline;
mod json;
mod lines;
mod notes;
mod page;
mod pictures;
mod tables;
mod text;
mod units;
mod use_of;

pub use blocks::blocks_text;
pub use findings::Findings;
pub use headline::{headline, outside_workspace, unsolved_as_written, worse_as_written};
pub use json::program_json;
pub use lines::WorstLine;
pub use page::page;
pub use pictures::figures;
pub use tables::{program_columns, program_table};
pub use text::{bounded_text, exceeded_text, holes_text, left_text};
pub use use_of::use_text;

use super::{Pass, WrittenCalls};
use crate::{
    answer::cautions::Outside,
    compensation::BoundedPath,
    files::table::largest_position,
    machine::{Machine, Motion},
    simulation::{along_path::PathAnswer, blocks::BlocksBeforeAfter},
};

/// Largest correction among the drives of one kind, mm or degrees.
pub fn largest_correction(machine: &Machine, kind: Motion, answer: &PathAnswer) -> f64 {
    largest_position(machine, kind, &answer.delta_rho())
}

/// A program that has been rewritten and proved.
#[derive(Debug)]
pub struct Proved<'a> {
    /// Its file name.
    pub name: &'a str,
    /// Its points outside the workspace box of the machine.
    pub outside: &'a Outside,
    /// What the tool does at its points, without compensation and as written.
    pub findings: &'a Findings,
    /// What each kind of commands leaves; that of the written program last.
    pub passes: &'a [Pass],
    /// What limits do, if the path was corrected within them.
    pub bounded: Option<&'a BoundedPath>,
    /// Largest correction of a drive of each kind, mm and degrees, as written.
    pub corrections: [Option<f64>; 2],
    /// What the blocks of a G-code program ask of a control.
    pub blocks: Option<&'a BlocksBeforeAfter>,
    /// What becomes of its calls.
    pub calls: &'a WrittenCalls,
}
