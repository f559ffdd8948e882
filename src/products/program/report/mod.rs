//! Reports of a compensated program: its points, what limits do, what was proved, and a page of it.

mod findings;
mod notes;
mod page;
mod tables;
mod words;

pub use findings::{Findings, outside_workspace};
pub use notes::{notes_text, use_text};
pub use page::{figures, page};
pub use tables::{passes_table, program_columns, program_json, program_table};
pub use words::{blocks_text, bounded_text, exceeded_text, headline, holes_text, left_text, limits_text};

use super::{ProgramJob, Proved};

/// Everything that is told.
#[derive(Debug)]
pub struct Report<'a> {
    /// The program before.
    pub job: &'a ProgramJob,
    /// Its file name.
    pub name: &'a str,
    /// As it was rewritten and proved.
    pub proved: &'a Proved,
    /// What the tool does at its points, without compensation and as written.
    pub findings: &'a Findings,
}
