//! Statements of Sinumerik's and Heidenhain's dialects that are refused, each with its reason.

use thiserror::Error;

/// Why a statement of Sinumerik's or Heidenhain's dialect is refused: a feature that is not followed, or something missing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum Foreign {
    /// R and Q parameters, variables, expressions.
    #[error("parameters, variables and expressions are not followed; expected plain numbers")]
    Parameter,
    /// IF, GOTOF, FN 9, CALL LBL.
    #[error("jumps, loops, branches and repeats are not followed; expected the blocks in the order they run")]
    Flow,
    /// L100, CALL PGM, names of subprograms.
    #[error("calls a subprogram, or is a word that is not read; expected one program without calls")]
    Call,
    /// CYCLE81, CYCL DEF 200.
    #[error("cycles are not followed; expected the cycle written out as moves")]
    Cycle,
    /// A cycle that is followed, but not with these values or at this place.
    #[error("this cycle cannot be written out as moves; expected {expected}")]
    CycleValue {
        /// What should be there.
        expected: &'static str,
    },
    /// CIP, CT, splines, APPR, FL.
    #[error("this motion is not followed; expected straight lines, and arcs by centre or radius")]
    Motion,
    /// RND, CHF.
    #[error("roundings and chamfers that the control inserts are not followed; expected them as arcs and lines")]
    Corner,
    /// G41, RL.
    #[error(
        "cutter radius compensation is not followed as the control makes it; expected the path of the tool centre with {off}, or \
         cutter_compensation = \"off\" in [gcode] of the process file, which writes it"
    )]
    Compensation {
        /// What switches it off.
        off: &'static str,
    },
    /// ROT, SCALE, MIRROR, AP=, LP.
    #[error("rotated, scaled, mirrored and polar coordinates are not followed; expected plain coordinates")]
    Frame,
    /// G91 or IC behind TRANS or another work offset.
    #[error(
        "a step from a position before the zero changed: whether it also goes the way of the zero is a setting of the control (SD42440); \
         expected an absolute coordinate of this axis before"
    )]
    StepToNewZero,
    /// TRAORI, TRANSMIT, M128, PLANE.
    #[error(
        "transformations of the control (tool centre point, tilted plane, cylinder) are not followed; expected them off"
    )]
    Kinematics,
    /// An M function of Heidenhain's that changes the path.
    #[error("this M function changes where the tool goes or how fast; expected a program without it")]
    MFunction,
    /// CYCL DEF 7.1 #5.
    #[error("datum tables are not read; expected CYCL DEF 7 with X, Y or Z")]
    DatumTable,
    /// CYCL DEF 7.0 whose axes stand behind `~`.
    #[error(
        "a datum shift whose axes stand behind ~ is not read; expected CYCL DEF 7.1 and further blocks with X, Y or Z"
    )]
    ContinuedShift,
    /// CYCL DEF 247 without Q339.
    #[error("which preset the cycle sets is not said; expected Q339 with its number in the block")]
    NoPreset,
    /// X without a number.
    #[error("expected a number after it")]
    NoNumber,
    /// A string or a bracket that is not closed.
    #[error("not closed; expected {close} on the same line")]
    NotClosed {
        /// What closes it.
        close: char,
    },
    /// X1=, which only G74 and G75 take.
    #[error("a coordinate of the machine; expected it with G74 or G75")]
    MachineAxis,
    /// A coordinate without L.
    #[error("not a statement that is read; expected one that begins as L, C, CR, CC, TOOL CALL, CYCL DEF or M do")]
    Unknown,
    /// C without DR.
    #[error("an arc without its direction; expected DR+ or DR-")]
    NoSense,
    /// CR without R.
    #[error("an arc without a radius; expected R with a number, or CC and C")]
    NoRadius,
    /// C without coordinates.
    #[error("an arc without its end; expected X, Y or Z")]
    NoEnd,
    /// C with FMAX.
    #[error("a rapid arc; expected a feed")]
    RapidArc,
    /// BEGIN PGM without unit.
    #[error("names no unit; expected MM or INCH at its end")]
    NoUnit,
    /// L with `~`.
    #[error("a block that continues in the next line (`~`); expected the whole block in one line")]
    Continued,
    /// A word twice.
    #[error("a second one in the block; expected one")]
    Twice,
}
