//! What programs of poses are made of.

pub(crate) mod error;
pub(crate) mod language;
pub(crate) mod rotation;
pub(crate) mod statement;
pub(crate) mod way;

pub(crate) use {error::*, language::*, rotation::*, statement::*, way::*};
