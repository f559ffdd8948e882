//! A path as it cuts: its points, and how the tool is in material on the way to each.

use std::ops::Deref;

use nalgebra::{UnitQuaternion, Vector3};

use crate::toolpath::Toolpath;

/// A path, and how its tool is in material where a stock is known.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CutPath {
    path: Toolpath,
    engagements: Vec<Engaged>,
}

impl CutPath {
    /// Creates the path with what is known of its engagement at each point.
    pub(crate) fn new(path: Toolpath, engagements: Vec<Engaged>) -> Self {
        Self { path, engagements }
    }

    /// Returns how the tool is in material on the way to each point; nothing where no stock is known.
    #[must_use]
    pub fn engagements(&self) -> &[Engaged] {
        &self.engagements
    }

    /// Returns the same path with these platform orientations `R_WP`, one for each point.
    #[must_use]
    pub fn with_platforms(self, platforms: &[UnitQuaternion<f64>]) -> Self {
        self.map(|path| path.with_platforms(platforms))
    }

    /// Returns a path of these points of it alone, indices in path order.
    #[must_use]
    pub(crate) fn at_points(&self, points: &[usize]) -> Self {
        let engagements = points.iter().filter_map(|&k| self.engagements.get(k).copied()).collect();
        let own = Toolpath::assemble(points.iter().map(|&k| self.path.points()[k]).collect());
        Self { path: own.with_external_axes(self.path.external_axes()), engagements }
    }

    /// Returns the same path with its points as `change` makes them of those there are.
    #[must_use]
    pub(crate) fn map(self, change: impl FnOnce(Toolpath) -> Toolpath) -> Self {
        Self { path: change(self.path), ..self }
    }
}

impl Deref for CutPath {
    type Target = Toolpath;

    fn deref(&self) -> &Toolpath {
        &self.path
    }
}

impl From<Toolpath> for CutPath {
    fn from(path: Toolpath) -> Self {
        Self::new(path, Vec::new())
    }
}

/// How the tool is in material on the way to a point: all zero in air.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[allow(non_snake_case, reason = "the unit is N, not n")]
pub struct Engaged {
    /// Number of regions of height with their own arcs: of several, depth, width, angles and chip are extremes.
    pub regions: usize,
    /// Height above the tip up to which it is in material, mm.
    pub depth_mm: f64,
    /// Radial width, mm.
    pub width_mm: f64,
    /// Least angle at which a tooth enters, counted as in [`EndMilling`](crate::process::cutting::EndMilling), rad; `None` where only the end cuts.
    pub entry_rad: Option<f64>,
    /// Largest angle at which a tooth leaves, rad.
    pub exit_rad: Option<f64>,
    /// Largest thickness of the chip, mm; `None` where the feed per tooth is not known.
    pub chip_mm: Option<f64>,
    /// Volume removed for each mm of path, mm².
    pub removed_mm2: f64,
    /// Area of the end of a flat or bull-nose tool that goes down into material, mm²: the force of its end teeth is in no law.
    pub end_mm2: f64,
    /// How teeth pass through the material: "up", "down" or "both"; empty in air.
    pub milling: &'static str,
    /// What the tool bends in itself; `None` where that is not asked.
    pub bend: Option<Bend>,
    /// Largest force within a turn of straight teeth, N; only where the mean is larger than at all points before.
    pub peak_N: Option<f32>,
    /// Why no law knows the force there, or all of it: none is computed then, or what is known.
    pub unknown: Option<UnknownForce>,
}

/// A cut whose force no law of the process knows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum UnknownForce {
    /// The end of a milling tool goes down into material: its end teeth are in no law.
    End,
    /// A drill that is not in solid material all around, by a law of solid drilling.
    PartlySolid,
    /// A drill that does not go along its axis.
    Aside,
    /// As of [`UnknownForce::End`] on a ramp, where the force of its side is known: the last, as not all is unknown.
    EndOnRamp,
}

/// How far a tool bends in itself where its teeth make a wall: at the instant at which a tooth passes the wall at that height, not on average.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(non_snake_case, reason = "the unit is N, not n")]
pub struct Bend {
    /// Mean over the heights of the walls that are made, and over both, W, mm; with the mean force where none is made.
    pub aimed_mm: Vector3<f64>,
    /// Unit vector to the left of the motion seen from the spindle, W.
    pub left: Vector3<f64>,
    /// The wall on the left, and that on the right; `None` where none is made.
    pub walls: [Option<BentWall>; 2],
    /// Force on the tool to the left: on average, where walls are made (`None` where none is), and the largest in size over a turn, N.
    pub across_N: [Option<f32>; 3],
}

/// How far a tool bends where it makes a wall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BentWall {
    /// Heights above the tip from which to which the wall is made, mm.
    pub heights_mm: [f32; 2],
    /// Bend to the left at heights evenly between them, mm.
    pub bends_mm: [f32; Bend::HEIGHTS],
}

impl Bend {
    /// Number of heights.
    pub const HEIGHTS: usize = 7;

    /// Returns the bend to the left of the wall on one side (left or not) at a height above the tip, that at its end beyond it, mm; `None` where none is made.
    #[must_use]
    pub fn at(&self, is_left: bool, height_mm: f64) -> Option<f64> {
        let own = self.walls[usize::from(!is_left)].as_ref()?;
        let [bottom, top] = own.heights_mm.map(f64::from);
        let share = ((height_mm - bottom) / (top - bottom).max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        let along = share * (Self::HEIGHTS - 1) as f64;
        let first = (along as usize).min(Self::HEIGHTS - 2);
        let [low, high] = [first, first + 1].map(|at| f64::from(own.bends_mm[at]));
        Some(low + (along - first as f64) * (high - low))
    }
}
