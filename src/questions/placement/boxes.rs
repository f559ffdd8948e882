//! The boxes that a placement must keep: forbidden ones, which the workpiece stays out of, and the machine's workspace, which
//! the platform point stays in on all paths.

use nalgebra::Vector3;

use super::{
    evaluate::{Evaluator, located},
    site::Site,
};
use crate::{compensation::Demand, simulation::Failure};

impl Evaluator {
    pub(super) fn check_boxes(&self, site: &Site) -> Result<(), Failure> {
        let study = &self.study;
        let workpiece = study.workpiece(site);
        study.table.as_ref().map_or(Ok(()), |table| table.check(&workpiece))?;
        let is_hit = |by: f64| study.forbidden.iter().find(|b| study.extent.overlaps(&workpiece, &b.extent.grown(by)));
        let reason = match (is_hit(0.0), is_hit(study.clearance_mm)) {
            (Some(forbidden), _) => format!("the workpiece would stand in the forbidden box \"{}\"", forbidden.name),
            (None, Some(forbidden)) => format!(
                "the workpiece would stand within the clearance of {} mm around the forbidden box \"{}\"",
                study.clearance_mm, forbidden.name
            ),
            (None, None) => return Ok(()),
        };
        Err(Failure { status: "forbidden".into(), reason })
    }

    /// P stays within the machine's workspace box on the whole path.
    pub(super) fn check_workspace(&self, site: &Site) -> Result<(), Failure> {
        (0..self.features.len()).try_for_each(|f| self.check_within(f, &self.demands(site, f)))
    }

    /// P stays within the machine's workspace box on the path of feature `f`.
    pub(super) fn check_within(&self, f: usize, demands: &[Demand]) -> Result<(), Failure> {
        let job = &self.study.features[f];
        let outside = |demand: &Demand| self.study.machine.outside_workspace(demand.pose.translation);
        let Some((k, outside)) = demands.iter().enumerate().find_map(|(k, demand)| Some((k, outside(demand)?))) else {
            return Ok(());
        };
        let reason = format!("P at {outside}{}", job.at_every_turn());
        Err(located(job, k, Failure { status: "outside_workspace".into(), reason }))
    }

    /// Whether the workpiece keeps forbidden boxes and the workspace box at `site`.
    pub(super) fn fits(&self, site: &Site) -> bool {
        self.check_boxes(site).is_ok() && self.check_workspace(site).is_ok()
    }

    /// By how much forbidden boxes and the workspace box are not kept, mm.
    pub(super) fn box_violation(&self, site: &Site) -> f64 {
        let study = &self.study;
        let workpiece = study.workpiece(site);
        let boxes = study.forbidden.iter().map(|b| b.extent.grown(study.clearance_mm));
        let inside = boxes.filter(|b| study.extent.overlaps(&workpiece, b)).map(|b| -study.extent.gap(&workpiece, &b));
        let machine = &study.machine;
        let outside = (0..study.features.len()).flat_map(|f| self.demands(site, f)).filter_map(|demand| {
            let outside = machine.outside_workspace(demand.pose.translation)?;
            Some(f64::max(outside.ends[0] - outside.value, outside.value - outside.ends[1]))
        });
        let off = study.table.as_ref().map(|table| table.off(&workpiece).0);
        inside.chain(outside).chain(off).fold(0.0, f64::max)
    }

    /// Positions of P on all paths, O, mm.
    fn positions(&self, site: &Site) -> Vec<Vector3<f64>> {
        let demands = (0..self.features.len()).flat_map(|f| self.demands(site, f));
        demands.map(|demand| demand.pose.translation).collect()
    }

    /// How far the workpiece may at least move before it meets a box or the edge of the table, mm; 0 where it touches one.
    pub(super) fn gap(&self, site: &Site) -> f64 {
        let study = &self.study;
        let workpiece = study.workpiece(site);
        let boxes = study.forbidden.iter().map(|b| study.extent.gap(&workpiece, &b.extent.grown(study.clearance_mm)));
        let workspace = &study.machine.workspace;
        let inside = |p: &Vector3<f64>| (p - workspace.min).inf(&(workspace.max - p)).min();
        let on = study.table.as_ref().map(|table| -table.off(&workpiece).0);
        let gap = boxes.chain(on).chain(self.positions(site).iter().map(inside)).fold(f64::INFINITY, f64::min);
        gap.max(0.0)
    }

    /// How far the workpiece may be moved along the unit vector `way`, of O or of the workpiece carrier, before it meets a box, mm.
    pub(super) fn free_translation(&self, site: &Site, way: &Vector3<f64>) -> f64 {
        let study = &self.study;
        let workpiece = study.workpiece(site);
        let boxes = study.forbidden.iter().map(|b| b.extent.grown(study.clearance_mm));
        let way = &study.machine.carrier.as_ref().map_or(*way, |carrier| carrier.home.pose.rotation * way);
        let boxes = boxes.map(|b| study.extent.way_to(&workpiece, way, &b));
        let workspace = &study.machine.workspace;
        let left = |p: &Vector3<f64>| {
            let moves = |i: &usize| way[*i] != 0.0 && study.machine.controls_translation(*i);
            let along = (0..3).filter(moves).map(|i| {
                let end = if way[i] > 0.0 { workspace.max[i] } else { workspace.min[i] };
                (end - p[i]) / way[i]
            });
            along.fold(f64::INFINITY, f64::min).max(0.0)
        };
        let edge = study.table.as_ref().map(|table| table.way_to_edge(&workpiece, way));
        boxes.chain(edge).chain(self.positions(site).iter().map(left)).fold(f64::INFINITY, f64::min)
    }

    /// The largest distance of a point of the workpiece, or of its paths, from the origin of W, mm.
    pub(super) fn radius(&self) -> f64 {
        let corners = self.study.extent.corners().into_iter().map(|corner| corner.norm());
        // Where a path gives positions of the tool tip, P moves about W with its tool, whose direction W turns.
        let points = self.study.features.iter().flat_map(|job| {
            let tool = job.machine().tool_tip.norm();
            job.feature.path.points().iter().map(move |point| point.position_mm.norm() + tool)
        });
        corners.chain(points).fold(0.0, f64::max)
    }
}
