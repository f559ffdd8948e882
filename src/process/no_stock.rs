//! Stock on pages: none, as they have paths as they were cut.

use crate::{
    input::error::Result,
    process::{CutPath, cutting::CuttingLaw},
    toolpath::{PathPoint, Toolpath},
};

/// No stock.
#[derive(Debug, Clone)]
pub enum StockRemoval {}

impl StockRemoval {
    /// Never called.
    pub(super) fn cut<'a, Place, Origin>(
        &self,
        _: Toolpath,
        _: Place,
        _: impl Fn(&PathPoint) -> &'a CuttingLaw,
        _: Origin,
    ) -> Result<CutPath> {
        match *self {}
    }

    /// Never called.
    pub(super) fn cut_shifted<Place, Shifts, Law>(&self, _: &Toolpath, _: Place, _: Shifts, _: Law) -> Result<CutPath> {
        match *self {}
    }

    /// Never called.
    pub fn check_movable<M, P>(&self, _: M, _: P) -> Result<()> {
        match *self {}
    }

    /// Never called.
    pub(super) fn teeth_hz(&self, _: &CutPath) -> Option<[f64; 2]> {
        match *self {}
    }
}
