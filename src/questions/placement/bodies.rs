//! Bodies at a place: what the workpiece would stand in, and what hits along its paths.

use super::{
    Site,
    evaluate::{Evaluator, at_path_point, track_feature},
};
use crate::{
    compensation::TaskPoint,
    simulation::{
        Failure,
        along_path::Arrival,
        clearance::{ClearanceState, PathClearance},
    },
};

impl Evaluator {
    /// Checks that nothing is hit at `site`: what moves with the workpiece stands free, and no bodies hit along paths whose γ is not sought. `Err` says what hits.
    pub(super) fn check_bodies(&self, site: &Site) -> Result<(), Failure> {
        (0..self.features.len()).try_for_each(|f| {
            self.check_standing(f, site)?;
            // Where γ is sought, one was taken at which nothing is hit.
            let is_sought = self.gamma_at(site, f).is_some();
            if is_sought { Ok(()) } else { self.check_bodies_along(f, site, &self.tasks(site, f)) }
        })
    }

    /// Checks that the workpiece of feature `f` and what moves with it stand free at `site`.
    fn check_standing(&self, f: usize, site: &Site) -> Result<(), Failure> {
        let placement = site.placement(self.study.features[f].feature.reference);
        let stands_in = self.cells()[f].as_ref().and_then(|cell| cell.stands_in(&placement));
        stands_in.map_or(Ok(()), |reason| Err(Failure { status: HIT.into(), reason }))
    }

    /// Checks that no bodies hit along `tasks`, the path of feature `f` at `site`. `Err` says where which do.
    pub(super) fn check_bodies_along(&self, f: usize, site: &Site, tasks: &[TaskPoint]) -> Result<(), Failure> {
        let found = self.clearance_along(f, site, tasks, true)?;
        let Some((found, nearest)) = found.as_ref().and_then(|own| Some((own, own.nearest.as_ref()?))) else {
            return Ok(());
        };
        if found.state != ClearanceState::Hit {
            return Ok(());
        }
        let [a, b] = &nearest.names;
        let reason = match nearest.distance_mm {
            depth if depth < -TOUCHING_MM => format!("{a} and {b} overlap by {:.1} mm on the way there", -depth),
            depth if depth <= 0.0 => format!("{a} and {b} touch on the way there"),
            distance => format!(
                "{a} and {b} come within {distance:.1} mm of each other on the way there, and {} mm are wanted",
                found.wanted_mm
            ),
        };
        Err(at_path_point(&self.study.features[f], nearest.point, Failure { status: HIT.into(), reason }))
    }

    /// Returns how near bodies come along the path of each feature at `site`, where deflection moves the tool by up to `moved_mm`; `None` without bodies.
    pub(super) fn clearances(&self, site: &Site, moved_mm: f64) -> Vec<Option<PathClearance>> {
        let along = |f: usize| match self.clearance_along(f, site, &self.tasks(site, f), false) {
            Ok(Some(found)) => Some(found.moved_by(moved_mm)),
            Ok(None) => PathClearance::without_cell(&self.study.machine),
            Err(_) => None,
        };
        (0..self.features.len()).map(along).collect()
    }

    /// Returns how near bodies come along `tasks`, the path of feature `f` at `site`, or only up to the first hit; `None` without bodies.
    pub(super) fn clearance_along(
        &self,
        f: usize,
        site: &Site,
        tasks: &[TaskPoint],
        to_first_hit: bool,
    ) -> Result<Option<PathClearance>, Failure> {
        let Some(cell) = &self.cells()[f] else { return Ok(None) };
        let job = &self.study.features[f];
        let points = job.feature.path.points();
        let mut along = cell.begin(&site.placement(job.feature.reference));
        if to_first_hit {
            along = along.to_first_hit();
        }
        if tasks.iter().any(|task| task.asked.is_some()) {
            along.leave_out("postures that the program asks for: those nearest to one another were looked at");
        }
        let mut has_hit = false;
        track_feature(
            job,
            tasks,
            |_| true,
            |k, at| {
                if !(to_first_hit && has_hit) {
                    along.add(&tasks[k], Some(at), Arrival::from(&points[k]));
                    has_hit = along.hits();
                }
                Ok(())
            },
        )?;
        Ok(Some(along.finish()))
    }
}

/// Smaller overlaps are told as touching, mm.
const TOUCHING_MM: f64 = 0.05;
/// Status of a place at which something is hit.
const HIT: &str = "hits";
