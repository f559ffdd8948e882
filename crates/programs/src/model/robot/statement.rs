//! A motion statement of a robot or APT program: its place in the file, and the numbers of its poses.

use std::ops::Range;

use nalgebra::{Isometry3, UnitQuaternion, Vector3};

/// The kind of motion that a statement commands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum MotionKind {
    /// In a straight line.
    Line,
    /// On a circle through a point on the way.
    Circle,
    /// From point to point on a path that the controller chooses, not for cutting.
    PointToPoint,
    /// On a curve that the controller lays through this point and those beside it.
    Spline,
}

/// Which component of a pose a number is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Component {
    /// X, Y or Z, mm times the unit of the program.
    Position(usize),
    /// A, B, C in degrees; q1 to q4; or i, j, k.
    Rotation(usize),
    /// External axis, from 0, mm or degrees.
    External(usize),
    /// Radius of a circle of APT, in the unit of positions.
    Radius,
    /// What is said of the posture of the arm, in the order of its language.
    Arm(usize),
}

/// A number in the text of a pose: component, bytes and value.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Number {
    pub component: Component,
    /// The number's bytes in the text of the pose.
    pub at: Range<usize>,
    pub value: f64,
}

/// A target pose of a motion statement, as the program's text gives it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Target {
    /// Bytes of the source that stand for the pose in the statement: its numbers or its name.
    pub at: Range<usize>,
    /// The pose's text with its numbers: from the statement, or from the declaration of its name.
    pub text: Vec<u8>,
    pub numbers: Vec<Number>,
}

impl Target {
    /// Returns the value of a component of the pose; `None` if the text does not give it.
    pub fn number(&self, component: Component) -> Option<f64> {
        self.numbers.iter().find(|number| number.component == component).map(|number| number.value)
    }
}

/// mm in an inch.
pub(crate) const INCH_MM: f64 = 25.4;
/// mm in a metre.
pub(crate) const METRE_MM: f64 = 1e3;
/// A coordinate in metres has as many more decimals than one in mm.
pub(crate) const METRE_DECIMALS: u8 = 3;

/// The base, tool frame and unit in force at a statement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Frames {
    /// Pose of the base in the workpiece frame, `X_WB`, mm.
    pub base: Isometry3<f64>,
    /// Orientation of the programmed tool frame in the platform, `R_PN`.
    pub tool: UnitQuaternion<f64>,
    /// How many mm one unit of the program's coordinates is.
    pub unit_mm: f64,
}

impl Default for Frames {
    /// Returns the base at W, the tool frame of the platform, and mm.
    fn default() -> Self {
        Self { base: Isometry3::identity(), tool: UnitQuaternion::identity(), unit_mm: 1.0 }
    }
}

/// A motion statement of a robot or APT program, as read.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Statement {
    /// The statement's bytes in the source, without comment and line ending.
    pub at: Range<usize>,
    /// The line on which the statement begins, from 1.
    pub line: usize,
    /// The bytes of the motion's keyword.
    pub keyword: Range<usize>,
    /// The bytes after the last pose (velocity, zone, tool) that inserted statements repeat.
    pub suffix: Range<usize>,
    pub kind: MotionKind,
    /// The intermediate pose of a circle.
    pub via: Option<Target>,
    /// The end pose; `None` where it is not known (joint positions, a point of another file).
    pub end: Option<Target>,
    /// The programmed angle of a circle that does not end at its end pose, rad; negative against the direction to `via`.
    pub sweep_rad: Option<f64>,
    /// Whether positions are relative to where the tool is.
    pub is_step: bool,
    pub frames: Frames,
    /// Distance from the end at which the motion begins to blend into the next, mm; infinite if unknown, `None` if it goes to its end or the
    /// language gives no distance.
    pub blend_mm: Option<f64>,
    /// mm/min.
    pub feed_mm_per_min: Option<f64>,
    pub spindle_rev_per_min: Option<f64>,
    pub tool: Option<u32>,
    pub apt: AptParts,
    /// Of a spline motion of KRL (SLIN, SCIRC, SPTP, SPL).
    pub spline: Option<SplineMotion>,
    /// Whether the control leaves open which posture the arm takes, whatever the target says.
    pub is_posture_open: bool,
    /// Angles of the joints to which it leads, rad, where it gives no pose.
    pub joints: Option<[f32; 6]>,
}

/// What KRL says of a spline motion beyond what other motions have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct SplineMotion {
    /// Line on which the block of SPLINE begins whose segment it is, from 1.
    pub block: Option<usize>,
    /// Whether WITH says how a circle turns the tool ($CIRC_MODE).
    pub sets_circle_mode: bool,
}

/// What records of APT before a motion say of it.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct AptParts {
    /// The tool axis in the base, from tip to spindle, where a record right before sets it and the motion does not.
    pub tool_axis: Option<Vector3<f64>>,
    pub circle: Option<AptCircle>,
    /// The cycle whose hole the motion is.
    pub drilling: Option<Drilling>,
}

/// The circle of a circular motion of APT.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct AptCircle {
    /// Its centre in the base, as `Position`, and its radius, both in the unit of the program.
    pub record: Target,
    pub turn: CircleTurn,
    /// Bytes of the record before the motion that has no meaning without the circle, with its line ending.
    pub leading: Range<usize>,
}

/// How a circular motion of APT says in which direction it turns; unit vectors in the base.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum CircleTurn {
    /// Right-handed about this axis; centre and radius can be replaced by others.
    About(Vector3<f64>),
    /// It starts in this direction, and ends where the circle meets the line from its centre to the end for the first or the second time.
    Towards { direction: Vector3<f64>, is_second: bool },
}

/// A drilling cycle of APT: lengths along the tool axis from the point of a GOTO.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Drilling {
    /// Depth of the bottom below the point, positive.
    pub depth_mm: f64,
    /// Height above the point to which the tool goes rapidly.
    pub clear_mm: f64,
    /// Height above the point to which it comes back.
    pub back_mm: f64,
}

impl Statement {
    /// Creates a statement on line `line` that leads nowhere yet, with nothing behind its poses.
    pub fn new(at: Range<usize>, line: usize, keyword: Range<usize>, kind: MotionKind) -> Self {
        Self {
            suffix: at.end..at.end,
            at,
            line,
            keyword,
            kind,
            via: None,
            end: None,
            sweep_rad: None,
            is_step: false,
            frames: Frames::default(),
            blend_mm: None,
            feed_mm_per_min: None,
            spindle_rev_per_min: None,
            tool: None,
            apt: AptParts::default(),
            spline: None,
            is_posture_open: false,
            joints: None,
        }
    }
}
