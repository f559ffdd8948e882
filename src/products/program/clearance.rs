//! How near bodies come along a program.

use super::ProgramJob;
use crate::{
    input::error::Result,
    simulation::clearance::{MachineCell, PathClearance},
    work::{Event, Stage, Work},
};

impl ProgramJob {
    /// Returns how near the bodies of `cell`, those of its machine and process, come along the program, with the tool where it is programmed: there it
    /// is as written, up to what is left of its deflection. `None` without bodies.
    ///
    /// # Errors
    /// Those of `work`, and a path that lacks what the cutting force needs.
    pub fn clearance(&self, cell: Option<&MachineCell>, work: &Work) -> Result<Option<PathClearance>> {
        let Some(cell) = cell else { return Ok(PathClearance::without_cell(&self.machine)) };
        work.tell(Event::Stage(Stage { of: "points held against bodies", items: self.path.len() }));
        let (mut along, mut before) = (cell.begin(&self.placement), None);
        for part in self.parts() {
            let part = part?;
            let track = self.track(&part, &mut before);
            for ((point, task), at) in part.points.iter().zip(part.tasks()).zip(track.iter().flatten()) {
                work.check()?;
                work.tell(Event::Computed(1));
                along.add(task, at.at.as_ref(), point.into());
            }
        }
        Ok(Some(along.finish()))
    }
}
