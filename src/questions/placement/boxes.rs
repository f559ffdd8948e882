//! Space around the workpiece: the table on which it stands, forbidden boxes, and the machine's workspace box, in which P stays on all paths.

use nalgebra::{Rotation2, Vector2, Vector3};

use super::{
    evaluate::{Evaluator, at_path_point},
    site::Site,
    turned::Setup,
};
use crate::{compensation::TaskPoint, simulation::Failure, spatial::Pose};

impl Evaluator {
    /// Checks that nothing refuses every place, and that the workpiece at `site` is on the table and clear of the forbidden boxes. `Err` says what is wrong.
    pub(super) fn check_boxes(&self, site: &Site) -> Result<(), Failure> {
        self.refused_everywhere.clone().map_or(Ok(()), Err)?;
        let study = &self.study;
        let workpiece = study.workpiece_pose(site);
        study.table.as_ref().map_or(Ok(()), |table| table.check(&workpiece))?;
        let is_hit =
            |by: f64| study.forbidden.iter().find(|b| study.extent.overlaps(&workpiece, &b.extent.expanded(by)));
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

    /// Checks that P stays within the machine's workspace box on all paths at `setup`. `Err` names the first point outside.
    pub(super) fn check_workspace(&self, setup: &Setup) -> Result<(), Failure> {
        (0..self.features.len()).try_for_each(|f| self.check_feature_workspace(f, &self.tasks(setup, f)))
    }

    /// Checks that P stays within the machine's workspace box at `tasks`, the path of feature `f`. `Err` names the first point outside.
    pub(super) fn check_feature_workspace(&self, f: usize, tasks: &[TaskPoint]) -> Result<(), Failure> {
        let job = &self.study.features[f];
        let outside = |task: &TaskPoint| self.study.machine.outside_workspace(task.pose.translation);
        let Some((k, outside)) = tasks.iter().enumerate().find_map(|(k, task)| Some((k, outside(task)?))) else {
            return Ok(());
        };
        let note = match job.gamma_search.is_some() {
            true => "; no rotation about the tool axis keeps the path within the box and the machine within its limits",
            false => "",
        };
        let reason = format!("P at {outside}{note}");
        Err(at_path_point(job, k, Failure { status: "outside_workspace".into(), reason }))
    }

    /// Returns whether table, forbidden boxes and workspace box allow `site`.
    pub(super) fn is_clear(&self, setup: &Setup) -> bool {
        self.check_boxes(&setup.site).is_ok() && self.check_workspace(setup).is_ok()
    }

    /// Returns by how much table, forbidden boxes and workspace box are violated at `setup`, mm; 0 where they are not.
    pub(super) fn box_violation(&self, setup: &Setup) -> f64 {
        let study = &self.study;
        let workpiece = study.workpiece_pose(&setup.site);
        let boxes = study.forbidden.iter().map(|b| b.extent.expanded(study.clearance_mm));
        let inside = boxes.filter(|b| study.extent.overlaps(&workpiece, b)).map(|b| -study.extent.gap(&workpiece, &b));
        let machine = &study.machine;
        let outside = (0..study.features.len()).flat_map(|f| self.tasks(setup, f)).filter_map(|task| {
            let outside = machine.outside_workspace(task.pose.translation)?;
            Some(f64::max(outside.ends[0] - outside.value, outside.value - outside.ends[1]))
        });
        let overhang = study.table.as_ref().map(|table| table.overhang(&workpiece).0);
        inside.chain(outside).chain(overhang).fold(0.0, f64::max)
    }

    /// Returns the positions of P on all paths, O, mm.
    fn positions(&self, setup: &Setup) -> Vec<Vector3<f64>> {
        let tasks = (0..self.features.len()).flat_map(|f| self.tasks(setup, f));
        tasks.map(|task| task.pose.translation).collect()
    }

    /// Returns a lower bound of how far the workpiece can move before it meets a box or the edge of the table, mm; 0 where it touches one.
    pub(super) fn clearance(&self, setup: &Setup) -> f64 {
        let study = &self.study;
        let workpiece = study.workpiece_pose(&setup.site);
        let boxes =
            study.forbidden.iter().map(|b| study.extent.gap(&workpiece, &b.extent.expanded(study.clearance_mm)));
        let workspace = &study.machine.workspace;
        let inside = |p: &Vector3<f64>| (p - workspace.min).inf(&(workspace.max - p)).min();
        let on = study.table.as_ref().map(|table| -table.overhang(&workpiece).0);
        let gap = boxes.chain(on).chain(self.positions(setup).iter().map(inside)).fold(f64::INFINITY, f64::min);
        gap.max(0.0)
    }

    /// Returns how far the workpiece can move along the unit `direction`, of O or of the carrier, before it meets a box or leaves table or workspace, mm.
    pub(super) fn free_translation(&self, setup: &Setup, direction: &Vector3<f64>) -> f64 {
        let study = &self.study;
        let workpiece = study.workpiece_pose(&setup.site);
        let boxes = study.forbidden.iter().map(|b| b.extent.expanded(study.clearance_mm));
        let direction =
            &study.machine.carrier.as_ref().map_or(*direction, |carrier| carrier.home.pose.rotation * direction);
        let boxes = boxes.map(|b| study.extent.free_travel(&workpiece, direction, &b));
        let workspace = &study.machine.workspace;
        let travel_of = |p: &Vector3<f64>| {
            let moves = |i: &usize| direction[*i] != 0.0 && study.machine.controls_translation(*i);
            let along = (0..3).filter(moves).map(|i| {
                let end = if direction[i] > 0.0 { workspace.max[i] } else { workspace.min[i] };
                (end - p[i]) / direction[i]
            });
            along.fold(f64::INFINITY, f64::min).max(0.0)
        };
        let edge = study.table.as_ref().map(|table| table.distance_to_edge(&workpiece, direction));
        boxes.chain(edge).chain(self.positions(setup).iter().map(travel_of)).fold(f64::INFINITY, f64::min)
    }

    /// Returns the largest distance of a point of the workpiece or of its paths from the origin of W, mm.
    pub(super) fn workpiece_radius(&self) -> f64 {
        let corners = self.study.extent.corners().into_iter().map(|corner| corner.norm());
        // Where a path gives positions of the tool tip, P moves about W with its tool, whose direction W turns.
        let points = self.study.features.iter().flat_map(|job| {
            let tool = job.machine().tool_tip.norm();
            job.feature.path.points().iter().map(move |point| point.position_mm.norm() + tool)
        });
        corners.chain(points).fold(0.0, f64::max)
    }
}

/// A table: a rectangle of O, turned about z, that must hold the footprint of the workpiece.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// Its centre, O, mm.
    pub centre_mm: Vector2<f64>,
    /// Lengths of its sides, mm.
    pub size_mm: Vector2<f64>,
    /// Angle from x of O to its first side, rad.
    pub yaw: f64,
    /// z of its surface in O, mm, if the workpiece must not reach through it.
    pub height_mm: Option<f64>,
    /// Whether the workpiece hangs under it, since the tool comes from below.
    pub is_overhead: bool,
    /// Smallest distance of the workpiece from its edge, mm.
    pub margin_mm: f64,
    /// Points of the workpiece that must be on it, W, mm.
    pub footprint: Vec<Vector3<f64>>,
}

/// Smaller overhangs are rounding, mm.
const ROUNDING_MM: f64 = 1e-9;

/// Sides of a table, in its own axes.
const SIDES: [(Vector2<f64>, &str); 4] = [
    (Vector2::new(1.0, 0.0), "+x"),
    (Vector2::new(-1.0, 0.0), "−x"),
    (Vector2::new(0.0, 1.0), "+y"),
    (Vector2::new(0.0, -1.0), "−y"),
];

impl Table {
    /// Returns by how much a workpiece at the pose `X_OW` is off the table, mm, and beyond which side; negative where it stands on it.
    pub fn overhang(&self, workpiece: &Pose) -> (f64, &'static str) {
        let half = 0.5 * self.size_mm;
        let to_table = Rotation2::new(-self.yaw);
        let mut largest = (f64::NEG_INFINITY, "");
        for point in &self.footprint {
            let point = workpiece.transform(*point);
            let in_table = to_table * (point.xy() - self.centre_mm);
            for (side, name) in &SIDES {
                let off = side.dot(&in_table) - side.abs().dot(&half) + self.margin_mm;
                largest = if off > largest.0 { (off, name) } else { largest };
            }
            let behind = self.height_mm.map_or(f64::NEG_INFINITY, |height| (height - point.z) * self.up_sign());
            largest = if behind > largest.0 { (behind, "") } else { largest };
        }
        largest
    }

    /// Returns 1 if the workpiece stands on the table, −1 if it hangs under it: the sign of z of O towards the workpiece.
    fn up_sign(&self) -> f64 {
        if self.is_overhead { -1.0 } else { 1.0 }
    }

    /// Checks that the workpiece at the pose `X_OW` stands on the table. `Err` says by how much it does not.
    pub(super) fn check(&self, workpiece: &Pose) -> Result<(), Failure> {
        let reason = match self.overhang(workpiece) {
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

    /// Returns how far a workpiece at the pose `X_OW` on the table can move along the unit vector `way` of O before it leaves it, mm.
    pub(super) fn distance_to_edge(&self, workpiece: &Pose, way: &Vector3<f64>) -> f64 {
        let half = 0.5 * self.size_mm;
        let to_table = Rotation2::new(-self.yaw);
        let along = to_table * way.xy();
        let travel_of = |point: &Vector3<f64>| {
            let point = workpiece.transform(*point);
            let in_table = to_table * (point.xy() - self.centre_mm);
            let to_side = SIDES
                .iter()
                .filter(|(side, _)| side.dot(&along) > 0.0)
                .map(|(side, _)| (side.abs().dot(&half) - self.margin_mm - side.dot(&in_table)) / side.dot(&along));
            let down = self.height_mm.filter(|_| way.z * self.up_sign() < 0.0).map(|height| (height - point.z) / way.z);
            to_side.chain(down).fold(f64::INFINITY, f64::min)
        };
        self.footprint.iter().map(travel_of).fold(f64::INFINITY, f64::min).max(0.0)
    }

    /// Returns the corners of the table in order around it, O, mm.
    pub fn corners(&self) -> [Vector2<f64>; 4] {
        let (half, turn) = (0.5 * self.size_mm, Rotation2::new(self.yaw));
        [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
            .map(|[x, y]| self.centre_mm + turn * Vector2::new(x * half.x, y * half.y))
    }
}
