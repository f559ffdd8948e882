//! Bodies at a place: what the workpiece would stand in, and what hits along its paths.

use super::{
    FeatureJob, Site,
    evaluate::{Evaluator, HIT, at_path_point, track_feature},
    turned::Setup,
};
use crate::{
    compensation::TaskPoint,
    process::PathReference,
    simulation::{Failure, along_path::Arrival, clearance::PathClearance, tasks::tasks_under},
};

impl Evaluator {
    /// Checks that no bodies hit along `tasks`, the path of feature `f` at `site`. Returns their least
    /// distance, mm, where it is asked for and known. `Err` says where which hit.
    pub(super) fn check_bodies_along(
        &self,
        f: usize,
        site: &Site,
        tasks: &[TaskPoint],
    ) -> Result<Option<f64>, Failure> {
        let Some(found) = self.clearance_along(f, site, tasks, !self.needs.clearance)? else { return Ok(None) };
        if let (Some(nearest), Some(reason)) = (&found.nearest, found.hit_text(|_| "on the way there".into())) {
            let failure = Failure { status: HIT.into(), reason };
            return Err(match nearest.point {
                Some(point) => at_path_point(&self.study.features[f], point, failure),
                None => failure,
            });
        }
        Ok(found.at_least_mm.filter(|_| self.needs.clearance && found.assumed.is_empty()))
    }

    /// Returns how near bodies come along the path of each feature at `setup`, and where the workpiece stands then: there or at the corner of its allowance
    /// where they come nearest. Deflection moves the tool by up to `moved_mm`. `None` without bodies.
    pub(super) fn clearances(&self, setup: &Setup, moved_mm: f64) -> Vec<Option<(Site, PathClearance)>> {
        let setups = self.clamped_setups(setup);
        let least = |own: &(Site, PathClearance)| own.1.at_least_mm.unwrap_or(f64::INFINITY);
        let nearest = |f: usize| {
            let (mut open, mut all): (Vec<String>, Vec<(Site, PathClearance)>) = (Vec::new(), Vec::new());
            for own in &setups {
                match self.clearance_along(f, &own.site, &self.tasks(own, f), false) {
                    Ok(Some(found)) => all.push((own.site, found)),
                    Ok(None) => return PathClearance::without_cell(&self.study.machine).map(|found| (own.site, found)),
                    Err(failure) => open.push(failure.reason),
                }
            }
            open.extend(all.iter().flat_map(|own| own.1.not_looked_at.clone()));
            let (site, mut found) = all.into_iter().reduce(|a, b| if least(&b) < least(&a) { b } else { a })?;
            for what in open {
                if !found.not_looked_at.contains(&what) {
                    found.not_looked_at.push(what);
                }
            }
            Some((site, found.moved_by(moved_mm)))
        };
        (0..self.features.len()).map(nearest).collect()
    }

    /// Returns how near bodies come along `tasks`, the path of feature `f` at `site`, or only up to the first hit; `None` without bodies.
    pub(super) fn clearance_along(
        &self,
        f: usize,
        site: &Site,
        tasks: &[TaskPoint],
        to_first_hit: bool,
    ) -> Result<Option<PathClearance>, Failure> {
        let Some(cell) = &self.cells[f] else { return Ok(None) };
        let job = &self.study.features[f];
        let points = job.feature.path.points();
        let mut along = cell.begin(&site.placement(job.feature.reference));
        if to_first_hit {
            along = along.to_first_hit();
        }
        if tasks.iter().any(|task| task.asked.is_some()) {
            along.leave_out("postures that the program asks for: those nearest to one another were looked at");
        }
        let mut has_hit = along.hits();
        if to_first_hit && has_hit {
            return Ok(Some(along.finish()));
        }
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

/// Returns where what moves with the workpiece is in the way of the tool of `job`, as at every place; `None` where it is not, or that is not known.
pub(super) fn hit_everywhere(job: &FeatureJob) -> Option<Failure> {
    let (machine, feature, cell) = (job.machine(), &job.feature, job.bodies.as_ref()?);
    // A stock asks for a tool along z of W, about which yaw turns: only the tip stays where it is then.
    let is_tip = feature.reference == PathReference::ToolTip;
    if !is_tip || machine.uncontrolled_axes().next().is_some() || machine.has_parasitic_rotation {
        return None;
    }
    let placement = Site([0.0; 6]).placement(feature.reference);
    let tasks = tasks_under(machine, &placement, job.target, &feature.path, &feature.loads);
    let found = cell.hit_everywhere(&placement, &tasks, feature.path.points())?;
    let reason = found.hit_text(|_| "there, wherever the workpiece is put".into())?;
    Some(at_path_point(job, found.nearest?.point?, Failure { status: HIT.into(), reason }))
}
