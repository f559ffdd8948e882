//! The cutting force at each point of a toolpath: on the tool, at its tip, in the axes of the workpiece frame W. Forces
//! are in N, moments about the tool tip in N·mm. [`Placed::wrench`](super::Placed::wrench) turns them into the wrench at P.
//!
//! Path frame, milling and drilling follow the tool. With a the unit vector along the tool from the spindle to its tip, in W
//! ([`Placed::tool_axes`](super::Placed::tool_axes)), and f the direction of motion projected onto the plane normal to a,
//! the heading, the directions are
//!
//! ```text
//! f       along the motion: tangential force of a path frame
//! f × a   to the right of the motion, seen from the workpiece (against a): radial force of a path frame
//! a       along the tool, out of the spindle: axial force of a path frame; the spindle is towards −a
//! ```
//!
//! Seen from the spindle, f × a is to the left. A motion without heading, such as a plunge along the tool's axis, has only
//! the axial part. With θ the angle between the motion and the tool's axis, what acts along f and f × a is the law's times
//!
//! ```text
//! min(1, sin θ / sin 5°)
//! ```
//!
//! as on a nearly vertical move rounding of the program decides where f points: a move that leaves the axis by a little more, or turns past
//! it, changes the force by a little. Where the tool is not cutting (G0), laws that compute the force give none.

mod arc;
mod cut_force;
mod drilling;
mod edge;
mod end_milling;
mod error;
mod feed;
pub mod materials;
mod own_forces;
mod path_frame;
mod peak;
mod slot_milling;
mod table;

pub use arc::Arc;
pub use cut_force::CutForce;
pub use drilling::{Drilling, DrillingLaw};
pub use edge::{EdgeForce, EdgeLaw, Kienzle};
pub use end_milling::{CutDirection, EndMilling, OverTurn};
pub use error::{LoadError, TableError, TableFault};
pub use own_forces::OwnForces;
pub use path_frame::PathFrame;
pub use slot_milling::SlotMilling;
pub use table::WrenchTable;

use nalgebra::{Matrix3, Vector3};

use crate::toolpath::{Load, PathPoint, Toolpath};

/// What the cutting force at a point of a path follows from.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum CuttingLaw {
    /// There is none, and none comes with the path.
    #[default]
    None,
    /// Radial, tangential and axial force are constant.
    PathFrame(PathFrame),
    /// Force and moment are tabulated over the length of the path.
    Table(WrenchTable),
    /// Force and moment come with the path: [`PathPoint::load`], at points that are not cutting as well.
    FromPath,
    /// A mechanistic model of a full slot, averaged over a turn of the spindle.
    SlotMilling(SlotMilling),
    /// A mechanistic model of a cut with the side of an end mill.
    EndMilling(EndMilling),
    /// Thrust and torque of a twist drill.
    Drilling(Drilling),
}

impl CuttingLaw {
    /// The load on the tool at `point`.
    ///
    /// # Errors
    /// When the point lacks what the law needs: a place in the table, a load of its own, feed or spindle speed.
    pub fn load(&self, point: &PathPoint) -> Result<PathLoad, LoadError> {
        Ok(match self {
            CuttingLaw::FromPath => match point.load {
                Some(load) => PathLoad::Workpiece(load),
                None if point.cutting => return Err(LoadError::NoLoad { segment: point.source.segment }),
                None => PathLoad::NONE,
            },
            _ if !point.cutting => PathLoad::NONE,
            CuttingLaw::None => PathLoad::NONE,
            CuttingLaw::PathFrame(frame) => PathLoad::PathFrame(*frame),
            CuttingLaw::Table(table) => PathLoad::Workpiece(table.load(point.arc_length_mm)?),
            CuttingLaw::SlotMilling(milling) => PathLoad::Milling(milling.force(milling.feed_per_tooth(point)?)),
            CuttingLaw::EndMilling(milling) => PathLoad::Milling(milling.force(milling.feed_per_tooth(point)?)),
            CuttingLaw::Drilling(drilling) => PathLoad::Drilling(drilling.force(drilling.feed_per_rev(point)?)),
        })
    }

    /// The load at every point of `path`, in order.
    ///
    /// # Errors
    /// When a table does not cover the lengths at which the path is cutting, when the path brings loads along that the law
    /// does not use, and as [`CuttingLaw::load`].
    pub fn loads(&self, path: &Toolpath) -> Result<Vec<PathLoad>, LoadError> {
        self.check(path)?;
        path.points().iter().map(|point| self.load(point)).collect()
    }

    /// Whether the law suits `path` as a whole.
    ///
    /// # Errors
    /// When a table does not cover the lengths at which the path is cutting, or the path brings loads along that the law does not
    /// use.
    pub fn check(&self, path: &Toolpath) -> Result<(), LoadError> {
        if *self != CuttingLaw::FromPath && path.points().iter().any(|point| point.load.is_some()) {
            return Err(LoadError::UnusedLoads { other_law: *self != CuttingLaw::None });
        }
        if let CuttingLaw::Table(table) = self {
            table.covers(path)?;
        }
        Ok(())
    }
}

/// The load at a point of a path, before it is known how the tool stands to the workpiece.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PathLoad {
    /// Given in the axes of W.
    Workpiece(Load),
    /// Constant in the frame of path and tool.
    PathFrame(PathFrame),
    /// In the directions of feed and tool.
    Milling(CutForce),
    /// In the directions of feed and tool, where the tool moves along its axis into the part.
    Drilling(CutForce),
}

impl PathLoad {
    /// No load.
    pub const NONE: Self = Self::Workpiece(NO_LOAD);

    /// The load in W for a motion along the unit vector `tangent` (W) of a tool whose axes in W are the columns of `tool_axes`,
    /// [`Placed::tool_axes`](super::Placed::tool_axes).
    #[must_use]
    pub fn on_tool(&self, tangent: Vector3<f64>, tool_axes: &Matrix3<f64>) -> Load {
        let tangent_of_tool = || tool_axes.tr_mul(&tangent);
        let of_cut = |cut: &CutForce| {
            let (force, moment) = cut.on_tool(tangent_of_tool());
            Load { force_N: tool_axes * force, moment_Nmm: tool_axes * moment }
        };
        match self {
            PathLoad::Workpiece(load) => *load,
            PathLoad::PathFrame(frame) => Load { force_N: tool_axes * frame.force(tangent_of_tool()), ..NO_LOAD },
            PathLoad::Milling(cut) => of_cut(cut),
            PathLoad::Drilling(cut) if drilling::drills(tangent_of_tool()) => of_cut(cut),
            PathLoad::Drilling(_) => NO_LOAD,
        }
    }
}

/// No load.
const NO_LOAD: Load = Load { force_N: Vector3::new(0.0, 0.0, 0.0), moment_Nmm: Vector3::new(0.0, 0.0, 0.0) };

/// A motion nearer to the tool's axis than this has but a share of the force across the axis, as the sine of the angle: 5°, as far as a
/// drill may be from its axis.
const FULL_HEADING: f64 = 0.087_155_742_747_658_17;

/// f in axes of the tool: the direction of motion normal to the tool, of unit length, for a motion along `tangent` (a unit
/// vector, axes of the tool). `None` for a motion along the tool's axis, steeper than one in a million, and for none.
fn heading(tangent: Vector3<f64>) -> Option<Vector3<f64>> {
    Vector3::new(tangent.x, tangent.y, 0.0).try_normalize(LEAST_HEADING)
}

/// A motion nearer to the tool's axis has no heading, as the sine of the angle.
const LEAST_HEADING: f64 = 1e-6;

/// The share of the force across the tool that a motion along `tangent` has (a unit vector, axes of the tool), from 0 where it has no
/// heading.
fn share_across(tangent: Vector3<f64>) -> f64 {
    ((tangent.xy().norm() - LEAST_HEADING) / (FULL_HEADING - LEAST_HEADING)).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, PI};

    use super::*;
    use crate::{
        process::{ForceLaw, MillingForce},
        spatial::{Pose, frame_about},
        toolpath::polyline::Polyline,
    };

    fn read(source: &str) -> Toolpath {
        Polyline::read(source, "path.csv").unwrap().toolpath().clone()
    }

    fn laws() -> [CuttingLaw; 2] {
        let force = MillingForce { law: ForceLaw::Rotated, ..MillingForce::PAPER };
        let force_of = |cutting, edge| EdgeForce { cutting, edge };
        let milling = SlotMilling {
            tangential: force_of(800.0, 10.0),
            radial: force_of(300.0, 8.0),
            axial: force_of(-150.0, -2.0),
            depth_mm: 2.0,
            teeth: 3,
            feed_per_tooth_mm: Some(0.05),
            spindle: crate::toolpath::Turn::Clockwise,
        };
        [CuttingLaw::PathFrame(PathFrame { force }), CuttingLaw::SlotMilling(milling)]
    }

    /// Loads on a tool along z of W.
    fn loads(law: &CuttingLaw, path: &Toolpath) -> Vec<Load> {
        loads_on(law, path, Vector3::z())
    }

    /// Loads on a tool along `axis` of W.
    fn loads_on(law: &CuttingLaw, path: &Toolpath, axis: Vector3<f64>) -> Vec<Load> {
        let loads = law.loads(path).unwrap();
        path.points().iter().zip(loads).map(|(p, load)| load.on_tool(p.tangent, &frame_about(axis))).collect()
    }

    #[test]
    fn all_forces_turn_with_the_tool() {
        // The same cut on a machine that stands in any other way: forces stand in the same way to tool and motion.
        let path = read("x_mm,y_mm,z_mm\n0,0,0\n5,2,0\n5,2,-1\n9,3,-3\n");
        for angles in [Vector3::new(PI, 0.0, 0.0), Vector3::new(FRAC_PI_2, 0.0, 0.4), Vector3::new(0.3, -1.2, 2.0)] {
            let turn = Pose::from_roll_pitch_yaw(angles).rotation;
            let turned = path.points().iter().map(|p| PathPoint { tangent: turn * p.tangent, ..*p }).collect();
            let turned = Toolpath::assemble(turned);
            for law in laws() {
                let (here, there) = (loads(&law, &path), loads_on(&law, &turned, turn * Vector3::z()));
                for (here, there) in here.iter().zip(&there) {
                    assert!((turn * here.force_N - there.force_N).norm() < 1e-11, "{} {}", here.force_N, there.force_N);
                }
            }
        }
    }

    #[test]
    fn the_signs_are_those_of_the_picture() {
        // Tool down, as on most mills; the feed along x.
        let force = MillingForce { radial: 7.0, tangential: 3.0, axial: -2.0, law: ForceLaw::Rotated };
        let path = read("x_mm,y_mm,z_mm\n0,0,0\n5,0,0\n");
        let down = loads_on(&CuttingLaw::PathFrame(PathFrame { force }), &path, -Vector3::z())[0].force_N;
        // Along the feed; to the right seen from the workpiece, which is +y; and up, into the spindle.
        assert!((down - Vector3::new(3.0, 7.0, 2.0)).norm() < 1e-12, "{down}");
        // Spindle horizontal, tool along y, feed along x: nothing radial lies along the tool.
        let level = loads_on(&CuttingLaw::PathFrame(PathFrame { force }), &path, Vector3::y())[0].force_N;
        assert!((level - Vector3::new(3.0, -2.0, 7.0)).norm() < 1e-12, "{level}");
    }

    #[test]
    fn no_force_on_rapid_moves_and_only_an_axial_one_on_plunges() {
        let path = read("x_mm,y_mm,z_mm,cutting\n0,0,5,0\n0,0,0,1\n0,0,-1,1\n5,0,-1,1\n9,0,-1,0\n");
        for law in laws() {
            let loads = loads(&law, &path);
            assert_eq!(loads[0], NO_LOAD);
            for plunge in &loads[1..3] {
                assert_eq!((plunge.force_N.x, plunge.force_N.y), (0.0, 0.0));
                assert!(plunge.force_N.z != 0.0);
            }
            assert!(loads[3].force_N.xy().norm() > 1.0);
            assert_eq!(loads[4], NO_LOAD);
        }
        assert_eq!(loads(&CuttingLaw::None, &path), [NO_LOAD; 5]);
    }

    #[test]
    fn forces_turn_with_the_path_and_lean_on_nothing_else() {
        for law in laws() {
            let along_x = loads(&law, &read("x_mm,y_mm,z_mm\n0,0,0\n5,0,0\n"))[0].force_N;
            let along_y = loads(&law, &read("x_mm,y_mm,z_mm\n3,1,0\n3,9,0\n"))[0].force_N;
            assert!((along_y - Vector3::new(-along_x.y, along_x.x, along_x.z)).norm() < 1e-12);
        }
    }

    #[test]
    fn loads_of_the_path_are_taken_as_they_are_and_missed_where_the_tool_cuts() {
        let path = read("x_mm,y_mm,z_mm,force_x_N,force_y_N,force_z_N,cutting\n0,0,0,1,2,3,1\n1,0,0,4,5,6,0\n");
        let loads = loads(&CuttingLaw::FromPath, &path);
        assert_eq!(loads[0].force_N, Vector3::new(1.0, 2.0, 3.0));
        assert_eq!(loads[1].force_N, Vector3::new(4.0, 5.0, 6.0));
        assert_eq!(
            CuttingLaw::None.loads(&path).unwrap_err().to_string(),
            "the path brings loads along, but the process has no cutting force: expected force.from_path = true, or a \
             path without force columns"
        );
        for law in laws() {
            assert_eq!(
                law.loads(&path).unwrap_err().to_string(),
                "the path brings loads along, but the process takes the cutting force from elsewhere: expected \
                 force.from_path = true, or a path without force columns"
            );
        }
        let bare = read("x_mm,y_mm,z_mm,cutting\n0,0,0,0\n1,0,0,1\n");
        assert_eq!(
            CuttingLaw::FromPath.loads(&bare).unwrap_err().to_string(),
            "the path gives no load for move 2: expected the columns force_x_N, force_y_N, force_z_N"
        );
    }
}
