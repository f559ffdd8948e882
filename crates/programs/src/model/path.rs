//! A toolpath: its points in order, with orientation, feed, load and source; and the planes in which arcs lie.

use nalgebra::{UnitQuaternion, Vector3};
use thiserror::Error;

use crate::model::{
    Orientation,
    robot::{ArmData, ArmPosture},
    tool::ToolDescription,
};
use kinetostat_spatial::MAX_EXTERNAL_AXES;

/// The largest coordinate of a path, mm: beyond any machine.
pub(crate) const MAX_COORDINATE_MM: f64 = 1e6;

/// A force and a moment on the tool, in the axes of the workpiece frame.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(non_snake_case, reason = "the unit is N, not n")]
pub struct Load {
    /// Force, N.
    pub force_N: Vector3<f64>,
    /// Moment about the tool tip, N·mm.
    pub moment_Nmm: Vector3<f64>,
}

/// The source of a path point: the move of its file or generator, and how far along it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointSource {
    /// Index of the move: of the motion blocks of a program, of the rows of a CSV file, or 0 for a generator.
    pub segment: usize,
    /// How far along the move the point lies: 0 at its start, 1 at its end.
    pub parameter: f64,
}

/// What is known of the way to a point from the one before.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Way {
    /// Straight, or a piece of a curve that the points follow.
    #[default]
    Followed,
    /// Made rapidly (G0), as the control does that.
    Rapid,
    /// From point to point, all joints of an arm at once (PTP, MoveJ).
    PointToPoint,
    /// A curve of which only the ends are known.
    Curve,
    /// Nothing: where it starts is not known, as after a return to the reference position.
    Unknown,
}

/// One point of a toolpath: where the tool tip is, how the tool is oriented, how it moves and what acts on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathPoint {
    /// Position of the tool tip in the workpiece frame, mm.
    pub position_mm: Vector3<f64>,
    /// Orientation of the tool; `None`: as with the machine at home, whether or not the workpiece is tilted.
    pub orientation: Option<Orientation>,
    /// Direction of motion, a unit vector in the workpiece frame; where two moves meet, the direction of arrival.
    /// Zero only if the whole path has no length.
    pub tangent: Vector3<f64>,
    /// Length of the path up to here, mm. A move whose start is not known adds none.
    pub arc_length_mm: f64,
    /// Whether the tool may be cutting on the way here: false after a rapid move (G0).
    pub cutting: bool,
    /// Feed along the path on the way here, mm/min; `None` for a rapid move, or if none was given.
    pub feed_mm_per_min: Option<f64>,
    /// Spindle speed last programmed, rev/min.
    pub spindle_rev_per_min: Option<f64>,
    /// Number of the tool in the spindle, if the path says it.
    pub tool: Option<u32>,
    /// Feature of the program on the way here, as an index into [`GcodeOptions::features`](crate::gcode::GcodeOptions::features).
    pub feature: Option<u16>,
    /// Cutting load here, if the path brings it along.
    pub load: Option<Load>,
    /// Positions of the external axes that the path commands, in the order of [`Toolpath::external_axes`], mm or degrees as their names say, and
    /// behind them those of the drives that it leads.
    pub external: [f64; MAX_EXTERNAL_AXES],
    /// The move that the point comes from.
    pub source: PointSource,
    /// What the program of a robot says of the posture of the arm here.
    pub arm: Option<ArmData>,
    /// What is known of the way here.
    pub way: Way,
}

/// An ordered list of points the tool should pass, in the workpiece frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Toolpath {
    points: Vec<PathPoint>,
    external_axes: Vec<String>,
    led_axes: Vec<String>,
    tools: Vec<ToolDescription>,
    postures: Vec<Option<ArmPosture>>,
}

impl Toolpath {
    /// Creates the path through `points`. A zero tangent is unknown and becomes that of the next point that has one, or else the last
    /// before.
    #[must_use]
    pub fn assemble(mut points: Vec<PathPoint>) -> Toolpath {
        fill_tangents(points.iter_mut().rev());
        fill_tangents(points.iter_mut());
        Toolpath { points, ..Toolpath::default() }
    }

    /// Returns the number of the tool at each point where it cuts and the path says which; `None` at the others.
    #[must_use]
    pub fn cutting_tools(&self) -> Vec<Option<u32>> {
        self.points.iter().map(|point| point.tool.filter(|_| point.cutting)).collect()
    }

    /// Returns the same path with these names for the external axes it commands.
    pub fn with_external_axes(mut self, names: &[String]) -> Toolpath {
        self.external_axes = names.into();
        self
    }

    /// Returns the names of the external axes that the path commands, with their units: `external_table_deg`.
    #[must_use]
    pub fn external_axes(&self) -> &[String] {
        &self.external_axes
    }

    /// Returns the same path with these names for the drives that serve the task near where it leads them.
    pub fn with_led_axes(mut self, names: Vec<String>) -> Toolpath {
        self.led_axes = names;
        self
    }

    /// Returns the names of the drives that serve the task near where the path leads them, as [`Toolpath::external_axes`] would have them.
    #[must_use]
    pub fn led_axes(&self) -> &[String] {
        &self.led_axes
    }

    /// Returns the same path with what its program says about its tools.
    pub fn with_tools(self, tools: Vec<ToolDescription>) -> Toolpath {
        Toolpath { tools, ..self }
    }

    /// Returns what comments of the program say about tools; nothing where they were not looked at.
    #[must_use]
    pub fn tools(&self) -> &[ToolDescription] {
        &self.tools
    }

    /// Returns the same path with how the arm stands at each point, so far as it is known.
    pub fn with_postures(self, postures: Vec<Option<ArmPosture>>) -> Toolpath {
        Toolpath { postures, ..self }
    }

    /// Returns how the arm stands at each point, where a written program is to say it; else nothing.
    pub fn postures(&self) -> &[Option<ArmPosture>] {
        &self.postures
    }

    /// Returns the points, in order.
    #[must_use]
    pub fn points(&self) -> &[PathPoint] {
        &self.points
    }

    /// Returns the positions of the points in the workpiece frame, mm, in order.
    #[must_use]
    pub fn positions_mm(&self) -> Vec<Vector3<f64>> {
        self.points.iter().map(|point| point.position_mm).collect()
    }

    /// Returns the number of points.
    #[must_use]
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// Whether the path gives the tool orientation at any point.
    #[must_use]
    pub fn is_oriented(&self) -> bool {
        self.points.iter().any(|point| point.orientation.is_some())
    }

    /// Whether the path has no point.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// Whether the last point repeats the first (position, tangent, load, orientation): a closed loop, whose means
    /// must not depend on the corner at which it begins.
    #[must_use]
    pub fn is_closed(&self) -> bool {
        let is_same = |a: &PathPoint, b: &PathPoint| {
            (a.position_mm, a.tangent, a.cutting) == (b.position_mm, b.tangent, b.cutting)
                && (a.load, a.orientation) == (b.load, b.orientation)
        };
        matches!(self.points.as_slice(), [first, .., last] if is_same(first, last))
    }

    /// Returns the length of the path, mm.
    #[must_use]
    pub fn length_mm(&self) -> f64 {
        self.points.last().map_or(0.0, |point| point.arc_length_mm)
    }

    /// Returns the largest feed where the tool cuts, mm/min; `None` unless all cuts have one.
    #[must_use]
    pub fn largest_cutting_feed_mm_per_min(&self) -> Option<f64> {
        let mut cutting = self.points.iter().filter(|point| point.cutting);
        cutting.try_fold(0.0, |most: f64, point| Some(most.max(point.feed_mm_per_min?))).filter(|most| *most > 0.0)
    }

    /// Returns the same path with this feed, mm/min, at every cutting point.
    #[must_use]
    pub fn with_feed(mut self, feed_mm_per_min: f64) -> Toolpath {
        for point in self.points.iter_mut().filter(|point| point.cutting) {
            point.feed_mm_per_min = Some(feed_mm_per_min);
        }
        self
    }

    /// Returns the same path with these platform orientations `R_WP`, one for each point.
    #[must_use]
    pub fn with_platforms(mut self, platforms: &[UnitQuaternion<f64>]) -> Toolpath {
        for (point, platform) in self.points.iter_mut().zip(platforms) {
            point.orientation = Some(Orientation::Platform(*platform));
            // The program says it of the orientations that it has.
            point.arm = None;
        }
        self
    }

    /// Returns the same path, in which a point stays cutting only where `cuts` is true.
    #[must_use]
    pub fn cutting_where(mut self, cuts: impl Fn(&PathPoint) -> bool) -> Toolpath {
        for point in &mut self.points {
            point.cutting &= cuts(point);
        }
        self
    }

    /// Returns the same path with this spindle speed, rev/min, at every point.
    #[must_use]
    pub fn with_spindle(mut self, spindle_rev_per_min: f64) -> Toolpath {
        for point in &mut self.points {
            point.spindle_rev_per_min = Some(spindle_rev_per_min);
        }
        self
    }
}

/// A coordinate plane. Angles in it turn from its first axis toward its second.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Plane {
    /// First axis x, second y, normal z (G17).
    #[default]
    Xy,
    /// First axis z, second x, normal y (G18).
    Zx,
    /// First axis y, second z, normal x (G19).
    Yz,
}

impl Plane {
    /// Returns the indices (0 = x, 1 = y, 2 = z) of the first axis, the second axis and the normal, a right-handed triple.
    #[must_use]
    pub fn axes(self) -> [usize; 3] {
        match self {
            Plane::Xy => [0, 1, 2],
            Plane::Zx => [2, 0, 1],
            Plane::Yz => [1, 2, 0],
        }
    }
}

/// The direction of rotation of a circle or arc, seen from the tip of its plane's normal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TurnDirection {
    /// From the plane's second axis toward its first (G2).
    Clockwise,
    /// From the plane's first axis toward its second (G3).
    CounterClockwise,
}

impl TurnDirection {
    /// Returns the sign of the angle turned through: −1 for clockwise.
    pub fn sign(self) -> f64 {
        if self == Self::Clockwise { -1.0 } else { 1.0 }
    }
}

/// Gives every point without a tangent that of the last point before it that has one, in the order of `points`.
fn fill_tangents<'a>(points: impl Iterator<Item = &'a mut PathPoint>) {
    let mut known = Vector3::zeros();
    for point in points {
        if point.tangent == Vector3::zeros() {
            point.tangent = known;
        }
        known = point.tangent;
    }
}

/// Returns the unit vector along `v`; zero if `v` is shorter than 1e-12.
pub(crate) fn direction(v: Vector3<f64>) -> Vector3<f64> {
    v.try_normalize(1e-12).unwrap_or_else(Vector3::zeros)
}

/// Why corrected positions or orientations do not fit the path.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum PositionsError {
    /// One position is needed for every point.
    #[error("{corrected} corrected positions for a path of {points} points: expected one for each point")]
    Count {
        /// Points of the path.
        points: usize,
        /// Positions given.
        corrected: usize,
    },
    /// A position is no position.
    #[error("corrected position {point} is ({x}, {y}, {z}) mm: expected finite numbers up to {MAX_COORDINATE_MM}")]
    NotAPosition {
        /// Index of the point, from 0.
        point: usize,
        /// Its x coordinate, mm.
        x: f64,
        /// Its y coordinate, mm.
        y: f64,
        /// Its z coordinate, mm.
        z: f64,
    },
    /// If there are orientations, one is needed for every point.
    #[error("{given} orientations for a path of {points} points: expected one for each point")]
    Orientations {
        /// Points of the path.
        points: usize,
        /// Orientations given.
        given: usize,
    },
}

/// Checks that there is one finite position of at most [`MAX_COORDINATE_MM`] for every point of `path`, and one orientation if any are given.
pub(crate) fn check_corrected(
    path: &Toolpath,
    corrected_mm: &[Vector3<f64>],
    orientations: Option<&[Orientation]>,
) -> Result<(), PositionsError> {
    if let Some(given) = orientations.map(<[Orientation]>::len).filter(|given| *given != path.len()) {
        return Err(PositionsError::Orientations { points: path.len(), given });
    }
    if path.len() != corrected_mm.len() {
        return Err(PositionsError::Count { points: path.len(), corrected: corrected_mm.len() });
    }
    for (point, p) in corrected_mm.iter().enumerate() {
        // Not-a-numbers compare as false.
        if !p.iter().all(|c| c.abs() <= MAX_COORDINATE_MM) {
            return Err(PositionsError::NotAPosition { point, x: p.x, y: p.y, z: p.z });
        }
    }
    Ok(())
}
