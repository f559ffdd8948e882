//! The cutting force at each point of a toolpath: on the tool, at its tip, in the axes of the workpiece frame W.
//!
//! The tool's axis is the z axis of W; which way it points only slot milling needs to know ([`SpindleSide`]). Forces are in N, moments about the tool tip in
//! N·mm. [`Placed::wrench`](super::Placed::wrench) turns them into the wrench at P.
//!
//! Along a path whose direction of motion, projected onto the xy-plane, is the unit vector f (the heading), the
//! directions are
//!
//! ```text
//! f           along the motion: tangential force of a path frame, feed direction of slot milling
//! n = z × f   left of the motion
//! −n          right of the motion: radial force of a path frame
//! ```
//!
//! A motion without heading, such as a plunge along the tool's axis, has only the axial part of a path frame's or of
//! slot milling's force. Where the tool is not cutting (G0), laws that compute the force give none.

mod error;
mod path_frame;
mod slot_milling;
mod table;

pub use error::{LoadError, TableError, TableFault};
pub use path_frame::PathFrame;
pub use slot_milling::{EdgeForce, SlotMilling, SpindleSide};
pub use table::WrenchTable;

use nalgebra::Vector3;

use super::toolpath::{Load, PathPoint, Toolpath};

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
}

impl CuttingLaw {
    /// The load on the tool at `point`.
    ///
    /// # Errors
    /// When the point lacks what the law needs: a place in the table, a load of its own, feed or spindle speed.
    pub fn load(&self, point: &PathPoint) -> Result<Load, LoadError> {
        match self {
            CuttingLaw::FromPath => match point.load {
                Some(load) => Ok(load),
                None if point.cutting => Err(LoadError::NoLoad { segment: point.source.segment }),
                None => Ok(NO_LOAD),
            },
            _ if !point.cutting => Ok(NO_LOAD),
            CuttingLaw::None => Ok(NO_LOAD),
            CuttingLaw::PathFrame(frame) => Ok(frame.load(point.tangent)),
            CuttingLaw::Table(table) => table.load(point.arc_length_mm),
            CuttingLaw::SlotMilling(milling) => milling.load(point),
        }
    }

    /// The load at every point of `path`, in order.
    ///
    /// # Errors
    /// When a table does not cover the lengths at which the path is cutting, when there is no law but the path brings
    /// loads along, and as [`CuttingLaw::load`].
    pub fn loads(&self, path: &Toolpath) -> Result<Vec<Load>, LoadError> {
        match self {
            CuttingLaw::Table(table) => table.covers(path)?,
            CuttingLaw::None if path.points().iter().any(|point| point.load.is_some()) => {
                return Err(LoadError::UnusedLoads);
            }
            _ => {}
        }
        path.points().iter().map(|point| self.load(point)).collect()
    }
}

/// No load.
const NO_LOAD: Load = Load { force_N: Vector3::new(0.0, 0.0, 0.0), moment_Nmm: Vector3::new(0.0, 0.0, 0.0) };

/// A force at the tool tip.
fn at_the_tip(force_n: Vector3<f64>) -> Load {
    Load { force_N: force_n, ..NO_LOAD }
}

/// f: the direction of motion in the xy-plane, of unit length, for a motion along `tangent` (a unit vector, W). `None`
/// for a motion along the tool's axis, steeper than one in a million, and for none.
fn heading(tangent: Vector3<f64>) -> Option<Vector3<f64>> {
    Vector3::new(tangent.x, tangent.y, 0.0).try_normalize(1e-6)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::process::{ForceLaw, MillingForce, toolpath::polyline::Polyline};

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
            spindle: crate::process::toolpath::Turn::Clockwise,
            spindle_side: SpindleSide::Above,
        };
        [CuttingLaw::PathFrame(PathFrame { force }), CuttingLaw::SlotMilling(milling)]
    }

    #[test]
    fn no_force_on_rapid_moves_and_only_an_axial_one_on_plunges() {
        let path = read("x_mm,y_mm,z_mm,cutting\n0,0,5,0\n0,0,0,1\n0,0,-1,1\n9,0,-1,0\n");
        for law in laws() {
            let loads = law.loads(&path).unwrap();
            assert_eq!(loads[0], NO_LOAD);
            assert_eq!((loads[1].force_N.x, loads[1].force_N.y), (0.0, 0.0));
            assert!(loads[1].force_N.z != 0.0);
            assert!(loads[2].force_N.xy().norm() > 1.0);
            assert_eq!(loads[3], NO_LOAD);
        }
        assert_eq!(CuttingLaw::None.loads(&path).unwrap(), [NO_LOAD; 4]);
    }

    #[test]
    fn forces_turn_with_the_path_and_lean_on_nothing_else() {
        for law in laws() {
            let along_x = law.loads(&read("x_mm,y_mm,z_mm\n0,0,0\n5,0,0\n")).unwrap()[0].force_N;
            let along_y = law.loads(&read("x_mm,y_mm,z_mm\n3,1,0\n3,9,0\n")).unwrap()[0].force_N;
            assert!((along_y - Vector3::new(-along_x.y, along_x.x, along_x.z)).norm() < 1e-12);
        }
    }

    #[test]
    fn loads_of_the_path_are_taken_as_they_are_and_missed_where_the_tool_cuts() {
        let path = read("x_mm,y_mm,z_mm,force_x_N,force_y_N,force_z_N,cutting\n0,0,0,1,2,3,1\n1,0,0,4,5,6,0\n");
        let loads = CuttingLaw::FromPath.loads(&path).unwrap();
        assert_eq!(loads[0].force_N, Vector3::new(1.0, 2.0, 3.0));
        assert_eq!(loads[1].force_N, Vector3::new(4.0, 5.0, 6.0));
        assert_eq!(
            CuttingLaw::None.loads(&path).unwrap_err().to_string(),
            "the path brings loads along, but the process has no cutting force: expected force.from_path = true, or a \
             path without force columns"
        );
        let bare = read("x_mm,y_mm,z_mm,cutting\n0,0,0,0\n1,0,0,1\n");
        assert_eq!(
            CuttingLaw::FromPath.loads(&bare).unwrap_err().to_string(),
            "the path gives no load for move 2: expected the columns force_x_N, force_y_N, force_z_N"
        );
    }
}
