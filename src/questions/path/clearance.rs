//! How near bodies come along the path of a study.

use super::PathStudy;
use crate::{
    input::error::Result,
    simulation::{
        along_path::{self, TrackBlocks},
        clearance::{MachineCell, PathClearance},
    },
    work::{Event, Stage, Work},
};

/// Returns how near the bodies of `cell`, those of the study, come along the path of a study returned by [`PathStudy::with_gamma`]; `None` without bodies.
///
/// # Errors
/// Those of `work`.
pub fn clearance(study: &PathStudy, cell: Option<&MachineCell>, work: &Work) -> Result<Option<PathClearance>> {
    let Some(cell) = cell else { return Ok(PathClearance::without_cell(&study.machine)) };
    work.summary("clearance", || {
        work.tell(Event::Stage(Stage { of: "points held against bodies", items: study.tasks.len() }));
        let track = TrackBlocks::new(&study.machine, None, &study.tasks);
        let mut along = cell.begin(&study.placement);
        for start in (0..study.tasks.len()).step_by(along_path::BLOCK) {
            for (k, at) in (start..).zip(track.block(start)) {
                work.check()?;
                work.tell(Event::Computed(1));
                along.add(&study.tasks[k], at.at.as_ref(), study.stations[k].arrival);
            }
        }
        Ok(Some(along.finish()))
    })
}
