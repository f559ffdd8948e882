//! What programs of poses are made of.

pub(crate) mod arc;
pub(crate) mod error;
pub(crate) mod language;
pub(crate) mod rotation;
pub(crate) mod statement;

pub(crate) use {arc::*, error::*, language::*, rotation::*, statement::*};
