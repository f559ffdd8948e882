//! Reports of a compensated program: its points, the effect of limits, the verification, and a page.

mod against;
mod feed;
mod findings;
mod machined;
mod notes;
mod page;
mod tables;
mod words;

pub use findings::{Findings, outside_workspace};
pub use notes::{notes_text, use_text};
pub use page::{figures, page};
pub use tables::{PROGRAM_RANKS, passes_table, program_columns, program_json, program_table};
pub use words::{blocks_text, bounded_text, budget_table, exceeded_text, findings_text, headline};

use super::{ProgramJob, VerifiedProgram};

/// Input of the reports of a compensated program.
#[derive(Debug)]
pub struct Report<'a> {
    /// The program before compensation.
    pub job: &'a ProgramJob,
    /// File name of the program.
    pub name: &'a str,
    /// The program as rewritten and verified.
    pub verified: &'a VerifiedProgram,
    /// Errors at its points, without compensation and as written.
    pub findings: &'a Findings,
}
