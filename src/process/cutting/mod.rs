//! The cutting force at each point of a toolpath: on the tool, at its tip, in the axes of the workpiece frame W. Forces
//! are in N, moments about the tool tip in N·mm. [`PlacedWorkpiece::wrench`](super::PlacedWorkpiece::wrench) turns them into the wrench at P.
//!
//! Path frame, milling and drilling follow the tool. With a the unit vector along the tool from the spindle to its tip, in W
//! ([`PlacedWorkpiece::tool_axes`](super::PlacedWorkpiece::tool_axes)), and f the direction of motion projected onto the plane normal to a,
//! the heading, the directions are
//!
//! ```text
//! f       along the motion: tangential force of a path frame
//! f × a   to the right of the motion, seen from the workpiece (against a): radial force of a path frame
//! a       along the tool, out of the spindle: axial force of a path frame; the spindle is towards −a
//! ```
//!
//! Seen from the spindle, f × a is to the left. A motion without heading, such as a plunge along the tool's axis, has only
//! the axial part of a path frame, and nothing of the side of an end mill, of whose whole force the share below acts. With θ the angle between the motion and the tool's axis, what acts along f and f × a is the law's times
//!
//! ```text
//! min(1, sin θ / sin 5°)
//! ```
//!
//! as on a nearly vertical move rounding of the program decides where f points: a move that leaves the axis by a little more, or turns past
//! it, changes the force by a little. Where the tool is not cutting (G0), laws that compute the force give none.

mod arc;
mod corners;
mod cut_force;
mod drilling;
mod edge;
mod end_milling;
#[cfg_attr(target_family = "wasm", path = "not_engaged.rs")]
mod engaged_milling;
mod error;
mod feed;
pub mod materials;
mod own_forces;
mod path_frame;
mod peak;
mod slot_milling;
mod table;

pub use arc::EngagementArc;
pub(crate) use corners::Corners;
pub use cut_force::CutForce;
pub(crate) use drilling::is_drilling;
pub use drilling::{Drilling, DrillingLaw};
pub use edge::{EdgeForce, EdgeLaw, Kienzle};
pub use end_milling::{CutDirection, EndMilling, MeanOrPeak};
pub use engaged_milling::EngagedMilling;
#[cfg(not(target_family = "wasm"))]
pub use engaged_milling::Stub;
pub use error::{LoadError, TableError, TableFault};
pub use own_forces::OwnForces;
pub use path_frame::PathFrame;
pub use slot_milling::SlotMilling;
pub use table::WrenchTable;

use nalgebra::{Matrix3, Vector3};

use crate::{
    process::MillingForce,
    toolpath::{Load, PathPoint, Toolpath},
};

/// The law that gives the cutting force at each point of a path.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum CuttingLaw {
    /// No cutting force, and none in the path.
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
    /// A mechanistic model of milling whose engagement is found from the stock: [`PathPoint::load`].
    EngagedMilling(EngagedMilling),
    /// Thrust and torque of a twist drill where it touches the stock: [`PathPoint::load`].
    EngagedDrilling(Drilling),
}

impl CuttingLaw {
    /// Computes the load on the tool at `point`: none where it does not cut, unless the path gives one. Fails when a table has no row there,
    /// or the path gives no load, feed or spindle speed that the law needs.
    pub fn load(&self, point: &PathPoint) -> Result<PathLoad, LoadError> {
        Ok(match self {
            CuttingLaw::FromPath => match point.load {
                Some(load) => PathLoad::Workpiece(load),
                None if point.cutting => return Err(LoadError::NoLoad { segment: point.source.segment }),
                None => PathLoad::NONE,
            },
            _ if !point.cutting => PathLoad::NONE,
            CuttingLaw::None => PathLoad::NONE,
            CuttingLaw::EngagedMilling(_) | CuttingLaw::EngagedDrilling(_) => {
                point.load.map_or(PathLoad::NONE, PathLoad::Workpiece)
            }
            CuttingLaw::PathFrame(frame) => PathLoad::PathFrame(*frame),
            CuttingLaw::Table(table) => PathLoad::Workpiece(table.load(point.arc_length_mm)?),
            CuttingLaw::SlotMilling(milling) => PathLoad::Milling(milling.force(milling.feed_per_tooth(point)?)),
            CuttingLaw::EndMilling(milling) => PathLoad::Milling(milling.force(milling.feed_per_tooth(point)?)),
            CuttingLaw::Drilling(drilling) => PathLoad::Drilling(drilling.force(drilling.feed_per_rev(point)?)),
        })
    }

    /// Returns the law with one component of its force alone, by its index: tangential, radial or axial, with what its coefficients make of the torque; the load of a
    /// drill is axial. `None` where the force is no sum of them, as of a table or a peak.
    #[must_use]
    pub fn with_only(&self, component: usize) -> Option<Self> {
        let only = |own: usize| if own == component { 1.0 } else { 0.0 };
        Some(match *self {
            CuttingLaw::None => CuttingLaw::None,
            CuttingLaw::PathFrame(PathFrame { force }) => CuttingLaw::PathFrame(PathFrame {
                force: MillingForce {
                    tangential: force.tangential * only(0),
                    radial: force.radial * only(1),
                    axial: force.axial * only(2),
                    ..force
                },
            }),
            CuttingLaw::SlotMilling(own) => {
                let [tangential, radial, axial] = EdgeForce::only([own.tangential, own.radial, own.axial], component);
                CuttingLaw::SlotMilling(SlotMilling { tangential, radial, axial, ..own })
            }
            CuttingLaw::EndMilling(own) if own.over_turn == MeanOrPeak::Mean => {
                CuttingLaw::EndMilling(EndMilling { edge: own.edge.with_only(component), ..own })
            }
            CuttingLaw::Drilling(own) if component == 2 => CuttingLaw::Drilling(own),
            CuttingLaw::Drilling(_) => CuttingLaw::None,
            CuttingLaw::EngagedMilling(_) | CuttingLaw::EngagedDrilling(_) => return None,
            CuttingLaw::Table(_) | CuttingLaw::FromPath | CuttingLaw::EndMilling(_) => return None,
        })
    }

    /// Whether there is a force at all, whether it depends on the feed of a program, and whether its mean torque about the tool's axis is known.
    pub(super) fn knows(&self) -> [bool; 3] {
        let (by_feed, torque) = match self {
            CuttingLaw::None => return [false; 3],
            CuttingLaw::PathFrame(_) | CuttingLaw::Table(_) | CuttingLaw::FromPath => (false, false),
            CuttingLaw::SlotMilling(own) => (own.feed_per_tooth_mm.is_none(), false),
            CuttingLaw::EndMilling(own) => (own.feed_per_tooth_mm.is_none(), own.over_turn == MeanOrPeak::Mean),
            CuttingLaw::EngagedMilling(own) => (own.feed_per_tooth_mm.is_none(), true),
            CuttingLaw::Drilling(own) | CuttingLaw::EngagedDrilling(own) => (own.feed_per_rev_mm.is_none(), true),
        };
        [true, by_feed, torque]
    }

    /// Whether the loads of the path are its loads.
    pub(super) fn takes_loads(&self) -> bool {
        matches!(self, CuttingLaw::FromPath | CuttingLaw::EngagedMilling(_) | CuttingLaw::EngagedDrilling(_))
    }

    /// Checks that the law suits `path` as a whole. Fails if a table does not cover all lengths at which the path is cutting, or the path has
    /// loads that the law does not use.
    pub fn check(&self, path: &Toolpath) -> Result<(), LoadError> {
        if !self.takes_loads() && path.points().iter().any(|point| point.load.is_some()) {
            return Err(LoadError::UnusedLoads { other_law: *self != CuttingLaw::None });
        }
        if let CuttingLaw::Table(table) = self {
            table.check_coverage(path)?;
        }
        Ok(())
    }
}

/// The load at a point of a path, in the frame in which its law gives it: that of W, of the path, or of feed and tool.
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

    /// Returns the load in W for a motion along the unit vector `tangent` (W) of a tool whose axes in W are the columns of `tool_axes`,
    /// [`PlacedWorkpiece::tool_axes`](super::PlacedWorkpiece::tool_axes).
    #[must_use]
    pub fn on_tool(&self, tangent: Vector3<f64>, tool_axes: &Matrix3<f64>) -> Load {
        let tangent_of_tool = || tool_axes.tr_mul(&tangent);
        let in_workpiece_axes = |cut: &CutForce| {
            let (force, moment) = cut.on_tool(tangent_of_tool());
            Load { force_N: tool_axes * force, moment_Nmm: tool_axes * moment }
        };
        match self {
            PathLoad::Workpiece(load) => *load,
            PathLoad::PathFrame(frame) => Load { force_N: tool_axes * frame.force(tangent_of_tool()), ..NO_LOAD },
            // Along the axis the side of the tool cuts nothing, and its end is in no law.
            PathLoad::Milling(cut) => {
                let share = lateral_share(tangent_of_tool());
                let axial = Vector3::new(1.0, 1.0, share);
                in_workpiece_axes(&CutForce {
                    force_N: cut.force_N.component_mul(&axial),
                    torque_Nmm: cut.torque_Nmm * share,
                })
            }
            PathLoad::Drilling(cut) if drilling::is_drilling(tangent_of_tool()) => in_workpiece_axes(cut),
            PathLoad::Drilling(_) => NO_LOAD,
        }
    }
}

/// The end of a milling tool counts where it takes more than this share of what is removed, or falls by more: less is of rounding.
pub(crate) const BY_END: f64 = 0.01;

/// No load.
const NO_LOAD: Load = Load { force_N: Vector3::new(0.0, 0.0, 0.0), moment_Nmm: Vector3::new(0.0, 0.0, 0.0) };

/// A motion nearer to the tool's axis than this has but a share of the force across the axis, as the sine of the angle: 5°, as far as a
/// drill may be from its axis.
const FULL_HEADING: f64 = 0.087_155_742_747_658_17;

/// Returns the heading f, the direction of the motion `tangent` normal to the tool: both unit vectors in axes of the tool. `None` for a
/// motion along the tool's axis, steeper than one in a million, or without direction.
fn heading(tangent: Vector3<f64>) -> Option<Vector3<f64>> {
    Vector3::new(tangent.x, tangent.y, 0.0).try_normalize(LEAST_HEADING)
}

/// A motion nearer to the tool's axis has no heading, as the sine of the angle.
pub(crate) const LEAST_HEADING: f64 = 1e-6;

/// Returns the share of the lateral force that acts on a motion along `tangent` (a unit vector, axes of the tool): 0 without heading,
/// 1 from 5° off the tool's axis.
pub(crate) fn lateral_share(tangent: Vector3<f64>) -> f64 {
    ((tangent.xy().norm() - LEAST_HEADING) / (FULL_HEADING - LEAST_HEADING)).clamp(0.0, 1.0)
}
