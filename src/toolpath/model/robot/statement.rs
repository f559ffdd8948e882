//! A statement that moves the tool: where it stands in the file, and the numbers of the poses it leads to.

use std::ops::Range;

use nalgebra::{Isometry3, UnitQuaternion};

/// How a statement moves the tool.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// In a straight line.
    Line,
    /// On a circle through a point on the way.
    Circle,
    /// On a way of its own, not for cutting.
    PointToPoint,
}

/// What a number of a pose is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Component {
    /// X, Y or Z, mm times the unit of the program.
    Position(usize),
    /// A, B, C in degrees; q1 to q4; or i, j, k.
    Rotation(usize),
    /// External axis, from 0, mm or degrees.
    External(usize),
}

/// A number in the text of a pose.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Number {
    pub component: Component,
    /// Its bytes in the text of the pose.
    pub at: Range<usize>,
    pub value: f64,
}

/// A pose a statement leads to.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Target {
    /// What stands for it in the statement, bytes of the source.
    pub at: Range<usize>,
    /// The text of the pose with its numbers: what stands in the statement, or what is declared elsewhere.
    pub text: Vec<u8>,
    pub numbers: Vec<Number>,
}

impl Target {
    pub fn number(&self, component: Component) -> Option<f64> {
        self.numbers.iter().find(|number| number.component == component).map(|number| number.value)
    }
}

/// The frames in force at a statement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Frames {
    /// Pose of the base in the workpiece frame, `X_WB`, mm.
    pub base: Isometry3<f64>,
    /// Orientation of the programmed tool frame in the platform, `R_PN`.
    pub tool: UnitQuaternion<f64>,
    /// mm in a unit of the program's coordinates.
    pub unit_mm: f64,
}

impl Default for Frames {
    fn default() -> Self {
        Self { base: Isometry3::identity(), tool: UnitQuaternion::identity(), unit_mm: 1.0 }
    }
}

/// A statement that moves the tool.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Statement {
    /// Its bytes in the source, without comment and line ending.
    pub at: Range<usize>,
    /// The line it begins on, from 1.
    pub line: usize,
    /// The bytes of the word that says how it moves.
    pub keyword: Range<usize>,
    /// The bytes behind its last pose that a line to another point has as well.
    pub suffix: Range<usize>,
    pub kind: Kind,
    /// The pose a circle passes on its way.
    pub via: Option<Target>,
    /// Where it leads; `None` where that is not known (joint positions, a point of another file).
    pub end: Option<Target>,
    /// By how much a circle turns if it does not end at its end, rad; negative against the way to its middle.
    pub sweep_rad: Option<f64>,
    /// Whether positions are steps from where the tool is.
    pub is_step: bool,
    pub frames: Frames,
    /// mm/min.
    pub feed_mm_per_min: Option<f64>,
    pub spindle_rev_per_min: Option<f64>,
    pub tool: Option<u32>,
}
