//! What stands for rotation about the tool axis on pages, which have no threads to seek it on: a path stays as programmed.

use std::borrow::Cow;

use super::PathStudy;
use crate::{input::error::Result, process::file::Process, toolpath::Toolpath, work::Work};

/// A path whose turn is sought: none.
#[derive(Debug, Clone)]
pub enum PathTurn {}

impl PathTurn {
    /// None.
    pub(super) fn of(_process: &Process, _path: &Toolpath, _origin: &str) -> Option<Self> {
        None
    }
}

impl PathStudy {
    /// The study as it is.
    ///
    /// # Errors
    /// None.
    pub fn turned(&self, _work: &Work) -> Result<Cow<'_, Self>> {
        Ok(Cow::Borrowed(self))
    }
}
