//! The table on which a workpiece is to stand.

use nalgebra::{Rotation2, Vector2, Vector3};

use crate::{simulation::Failure, spatial::Pose};

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
