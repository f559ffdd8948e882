//! A path tracked on a machine with errors, some of whose inputs may be uncertain: what path studies, programs and places have in common.

use std::sync::Arc;

use super::{Machines, spread::DrawnMachines, spread_along::SpreadPath};
use crate::{
    input::error::Result,
    machine::{ChainError, Machine},
    process::{Placement, file::Process, uncertainty::Uncertainty},
};

/// The machine that a path is tracked on, where the workpiece stands, and what is asked of the path.
#[derive(Debug, Clone)]
pub struct TrackedPath {
    /// The nominal machine with the tool of the process.
    pub machine: Machine,
    /// Errors of each chain of the actual machine.
    pub errors: Vec<ChainError>,
    /// Where the workpiece stands.
    pub placement: Placement,
    /// Largest deviation of the tool from its path that is allowed, mm.
    pub tolerance_mm: Option<f64>,
    /// What is not known exactly; `None` where all inputs are taken as exact.
    pub uncertainty: Option<Arc<Uncertainty>>,
}

impl TrackedPath {
    /// Returns a path cut by `process`, all inputs of which are taken as exact.
    pub fn of(process: &Process) -> Self {
        Self {
            machine: process.machine.clone(),
            errors: process.errors.clone(),
            placement: process.placement,
            tolerance_mm: process.tolerance_mm,
            uncertainty: None,
        }
    }

    /// Returns the nominal and actual machines of the error sources. `Err` as [`Machines::new`].
    pub fn machines(&self) -> Result<Machines> {
        Machines::new(&self.machine, &self.errors)
    }

    /// Returns what uncertain inputs make of its `machines`; `None` where all are exact. `Err` as [`Machines::drawn`].
    pub(crate) fn drawn(&self, machines: &Machines) -> Result<Option<DrawnMachines>> {
        DrawnMachines::new(self.uncertainty.as_deref(), machines, &self.errors)
    }

    /// Returns the path on the `drawn` machines whose spread is wanted: of one pass, all points of which count, with all that reports say.
    pub(crate) fn spread<'a>(&self, drawn: &'a DrawnMachines) -> SpreadPath<'a> {
        SpreadPath {
            drawn,
            placement: self.placement,
            tolerance_mm: self.tolerance_mm,
            margin_mm: 0.0,
            audits: 1,
            passes: &[],
            counts: &|_| true,
            by_drive: true,
            compensates: true,
        }
    }
}
