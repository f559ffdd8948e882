//! Drive forces along a path where inputs are uncertain: the largest of each drive in each draw, solved in full.

use std::ops::Range;

use rayon::prelude::*;

use super::{
    Failure, Machines, Source,
    along_path::{BLOCK, Commands, PathCase},
    path_blocks::{TrackedBlock, solve_blocks},
    spread::DrawnMachines,
    tracking::TrackPoint,
};
use crate::{compensation::TaskPoint, input::error, process::uncertainty::DrawnForceAt, statics::Batch, work::Work};

/// Largest force of each drive over some points of a path in a draw: its size, N or N·mm, and the index of its point; or why there is no equilibrium.
pub(crate) type DrawnForces = Result<Vec<(f64, usize)>, Failure>;

/// Returns the largest forces over the points of both, draw by draw.
pub(crate) fn larger_forces(all: Vec<DrawnForces>, next: Vec<DrawnForces>) -> Vec<DrawnForces> {
    let larger = |(own, next): ((f64, usize), (f64, usize))| if next.0 > own.0 { next } else { own };
    let of_draw = |(own, next): (DrawnForces, DrawnForces)| Ok(own?.into_iter().zip(next?).map(larger).collect());
    all.into_iter().zip(next).map(of_draw).collect()
}

/// A part of a path at which drive forces are wanted.
pub(crate) struct ForcedPart<'a> {
    /// Index of its first point.
    pub first: usize,
    /// The nominal machine along it, by blocks.
    pub track: &'a [Vec<TrackPoint>],
    /// Poses and loads at its points.
    pub tasks: &'a [TaskPoint],
    /// What draws change of the force at each; empty where one factor is for all of it.
    pub forces: &'a [DrawnForceAt],
}

impl DrawnMachines {
    /// Returns the largest drive forces in each of `draws` at `commands`, over those points of the part whose index in the path `counts`. The results do not
    /// depend on the number of threads.
    ///
    /// # Errors
    /// Of `work`.
    pub fn largest_forces(
        &self,
        draws: Range<usize>,
        &ForcedPart { first, track, tasks, forces }: &ForcedPart<'_>,
        commands: &Commands<'_>,
        counts: &(dyn Fn(usize) -> bool + Sync),
        work: &Work,
    ) -> error::Result<Vec<DrawnForces>> {
        // As many blocks as are solved side by side, also of a short path.
        let length = tasks.len().div_ceil(Batch::WIDTH).clamp(1, BLOCK / Batch::WIDTH);
        let long = track.iter().enumerate();
        let blocks: Vec<TrackedBlock<'_>> =
            long.flat_map(|(block, track)| (block * BLOCK..).step_by(length).zip(track.chunks(length))).collect();
        let solve = |index: usize| {
            let largest = |machines: &Machines| -> error::Result<DrawnForces> {
                let tasks: Vec<TaskPoint> = self.under_draw(index, tasks, forces);
                let case = PathCase::new(machines, Source::All, &tasks);
                let mut largest = vec![(0.0, first); case.nominal.drive_count()];
                for together in blocks.chunks(Batch::WIDTH) {
                    let solved = solve_blocks(&case, commands, together, &|| work.check())?;
                    for ((start, _), answers) in together.iter().zip(solved) {
                        for (point, answer) in (first + start..).zip(answers).filter(|(point, _)| counts(*point)) {
                            if !answer.is_settled {
                                return Ok(Err(Failure::of(&answer.status, case.nominal)));
                            }
                            for (most, force) in largest.iter_mut().zip(&answer.drive_forces) {
                                *most = if force.abs() > most.0 { (force.abs(), point) } else { *most };
                            }
                        }
                    }
                }
                Ok(Ok(largest))
            };
            self.on_draw(index, largest).unwrap_or_else(|failure| Ok(Err(failure)))
        };
        draws.into_par_iter().map(solve).collect()
    }
}
