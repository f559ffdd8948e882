//! What is made for a control: a compensated program, a table of corrections, code that computes them.

pub mod correction;
pub mod field;
#[cfg(feature = "report")]
pub(crate) mod field_report;
pub mod program;
#[cfg(feature = "report")]
pub mod realtime;
