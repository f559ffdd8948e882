//! How near bodies come along a program.

use super::ProgramJob;
use crate::{
    input::error::Result,
    simulation::clearance::{MachineCell, PathClearance},
    work::Work,
};

impl ProgramJob {
    /// Returns how near bodies come along the program, with the tool where it is programmed: there it is as written, up to what is left of its deflection.
    /// `None` where the process names no cell.
    ///
    /// # Errors
    /// Those of [`MachineCell::new`], of `work`, and a path that lacks what the cutting force needs.
    pub fn clearance(&self, work: &Work) -> Result<Option<PathClearance>> {
        let Some(own) = &self.process.cell else { return Ok(None) };
        let cell = MachineCell::new(&self.machine, own)?;
        let (mut along, mut before) = (cell.begin(&self.placement), None);
        for part in self.parts() {
            let part = part?;
            let track = self.track(&part, &mut before);
            for ((point, task), at) in part.points.iter().zip(part.tasks()).zip(track.iter().flatten()) {
                work.check()?;
                along.add(task, at.at.as_ref(), !point.cutting && point.feed_mm_per_min.is_none());
            }
        }
        Ok(Some(along.finish()))
    }
}
