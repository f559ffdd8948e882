//! What a placement must keep: the table on which the workpiece is to stand, forbidden boxes, which it stays out of, and the machine's
//! workspace, which the platform point stays in on all paths.

use nalgebra::{Rotation2, Vector2, Vector3};

use super::{
    evaluate::{Evaluator, located},
    site::Site,
};
use crate::{compensation::TaskPoint, simulation::Failure, spatial::Pose};

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
        (0..self.features.len()).try_for_each(|f| self.check_within(f, &self.tasks(site, f)))
    }

    /// P stays within the machine's workspace box on the path of feature `f`.
    pub(super) fn check_within(&self, f: usize, tasks: &[TaskPoint]) -> Result<(), Failure> {
        let job = &self.study.features[f];
        let outside = |task: &TaskPoint| self.study.machine.outside_workspace(task.pose.translation);
        let Some((k, outside)) = tasks.iter().enumerate().find_map(|(k, task)| Some((k, outside(task)?))) else {
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
        let outside = (0..study.features.len()).flat_map(|f| self.tasks(site, f)).filter_map(|task| {
            let outside = machine.outside_workspace(task.pose.translation)?;
            Some(f64::max(outside.ends[0] - outside.value, outside.value - outside.ends[1]))
        });
        let off = study.table.as_ref().map(|table| table.off(&workpiece).0);
        inside.chain(outside).chain(off).fold(0.0, f64::max)
    }

    /// Positions of P on all paths, O, mm.
    fn positions(&self, site: &Site) -> Vec<Vector3<f64>> {
        let tasks = (0..self.features.len()).flat_map(|f| self.tasks(site, f));
        tasks.map(|task| task.pose.translation).collect()
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

/// A rectangle of O, turned about z, that must hold the footprint of the workpiece.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// Its middle, O, mm.
    pub centre_mm: Vector2<f64>,
    /// Lengths of its sides, mm.
    pub size_mm: Vector2<f64>,
    /// Angle from x of O to its first side, rad.
    pub yaw: f64,
    /// z of its surface in O, mm, if the workpiece must not reach behind it.
    pub height_mm: Option<f64>,
    /// Whether the workpiece hangs under it, since the tool comes from below.
    pub is_overhead: bool,
    /// How far the workpiece must stay from its edge, mm.
    pub margin_mm: f64,
    /// Points that must be on it, in W, mm.
    pub footprint: Vec<Vector3<f64>>,
}

/// Off by less is rounding, mm.
const ROUNDING_MM: f64 = 1e-9;

/// Sides of a table, in its own axes.
const SIDES: [(Vector2<f64>, &str); 4] = [
    (Vector2::new(1.0, 0.0), "+x"),
    (Vector2::new(-1.0, 0.0), "−x"),
    (Vector2::new(0.0, 1.0), "+y"),
    (Vector2::new(0.0, -1.0), "−y"),
];

impl Table {
    /// By how much a workpiece at `workpiece`, `X_OW`, is off the table, mm, and beyond which side; negative where it stands on it.
    pub fn off(&self, workpiece: &Pose) -> (f64, &'static str) {
        let half = 0.5 * self.size_mm;
        let back = Rotation2::new(-self.yaw);
        let mut most = (f64::NEG_INFINITY, "");
        for point in &self.footprint {
            let point = workpiece.transform(*point);
            let own = back * (point.xy() - self.centre_mm);
            for (side, name) in &SIDES {
                let off = side.dot(&own) - side.abs().dot(&half) + self.margin_mm;
                most = if off > most.0 { (off, name) } else { most };
            }
            let behind = self.height_mm.map_or(f64::NEG_INFINITY, |height| (height - point.z) * self.up());
            most = if behind > most.0 { (behind, "") } else { most };
        }
        most
    }

    /// From the table to the workpiece, along z of O.
    fn up(&self) -> f64 {
        if self.is_overhead { -1.0 } else { 1.0 }
    }

    /// The workpiece at `workpiece`, `X_OW`, stands on the table.
    ///
    /// # Errors
    /// By how much it does not.
    pub(super) fn check(&self, workpiece: &Pose) -> Result<(), Failure> {
        let reason = match self.off(workpiece) {
            (off, _) if off <= ROUNDING_MM => return Ok(()),
            (off, "") if self.is_overhead => {
                format!(
                    "the workpiece would be {off:.1} mm above the surface of the table, under which it hangs: the tool points up"
                )
            }
            (off, "") => format!("the workpiece would be {off:.1} mm below the surface of the table"),
            (off, side) if self.margin_mm > 0.0 => {
                format!(
                    "the workpiece would be {off:.1} mm beyond the margin of {} mm on side {side} of the table",
                    self.margin_mm
                )
            }
            (off, side) => format!("the workpiece would hang {off:.1} mm over side {side} of the table"),
        };
        Err(Failure { status: "off_table".into(), reason })
    }

    /// How far a workpiece that stands on the table may be moved along `way`, a unit vector of O, mm.
    pub(super) fn way_to_edge(&self, workpiece: &Pose, way: &Vector3<f64>) -> f64 {
        let half = 0.5 * self.size_mm;
        let back = Rotation2::new(-self.yaw);
        let along = back * way.xy();
        let left = |point: &Vector3<f64>| {
            let point = workpiece.transform(*point);
            let own = back * (point.xy() - self.centre_mm);
            let to_side = SIDES
                .iter()
                .filter(|(side, _)| side.dot(&along) > 0.0)
                .map(|(side, _)| (side.abs().dot(&half) - self.margin_mm - side.dot(&own)) / side.dot(&along));
            let down = self.height_mm.filter(|_| way.z * self.up() < 0.0).map(|height| (height - point.z) / way.z);
            to_side.chain(down).fold(f64::INFINITY, f64::min)
        };
        self.footprint.iter().map(left).fold(f64::INFINITY, f64::min).max(0.0)
    }

    /// Its corners in turn, O, mm.
    pub fn corners(&self) -> [Vector2<f64>; 4] {
        let (half, turn) = (0.5 * self.size_mm, Rotation2::new(self.yaw));
        [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
            .map(|[x, y]| self.centre_mm + turn * Vector2::new(x * half.x, y * half.y))
    }
}
