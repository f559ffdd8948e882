//! Stand-in for the search of γ on pages, which have no threads for it: the tool keeps its programmed rotation.

use std::borrow::Cow;

use super::PathStudy;
use crate::{
    input::error::Result,
    process::{CutPath, file::Process},
    work::Work,
};

/// A search for γ along a path, of which there are none on pages.
#[derive(Debug, Clone)]
pub enum PathGammaSearch {}

impl PathGammaSearch {
    /// Returns `None`: no γ is sought.
    pub(super) fn of(_process: &Process, _path: &CutPath, _origin: &str) -> Option<Self> {
        None
    }
}

impl PathStudy {
    /// Returns the study unchanged; never `Err`.
    pub fn with_gamma(&self, _work: &Work) -> Result<Cow<'_, Self>> {
        Ok(Cow::Borrowed(self))
    }
}
