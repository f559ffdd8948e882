//! The data of robot and APT programs: statements, poses, frames, arcs, options and faults.

pub(crate) mod arc;
pub(crate) mod arm;
pub(crate) mod error;
pub(crate) mod language;
pub(crate) mod rotation;
pub(crate) mod statement;

pub(crate) use {arc::*, arm::*, error::*, language::*, rotation::*, statement::*};
