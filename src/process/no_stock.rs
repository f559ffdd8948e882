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
    pub(super) fn cut<'a, Machine, Placement, Origin, Done>(
        &self,
        _: Toolpath,
        _: Machine,
        _: Placement,
        _: impl Fn(&PathPoint) -> &'a CuttingLaw,
        _: Origin,
        _: Done,
    ) -> Result<CutPath> {
        match *self {}
    }

    /// Never called.
    pub(super) fn cut_shifted<Placed, Shifts, Law, Origin>(
        &self,
        _: &Toolpath,
        _: Placed,
        _: Shifts,
        _: Law,
        _: Origin,
    ) -> Result<CutPath> {
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
