//! The errors of G-code programs, each with the line, the word and what was expected.

use thiserror::Error;

use crate::model::{
    MAX_COORDINATE_MM,
    gcode::{
        ArcFault, Contradiction, Dialect, Foreign, InclinedFault, MacroFault, RadiusFault, Unsupported, WorkOffset,
    },
};

/// The error of a G-code program that cannot be followed: file, line, column, text, reason and what was expected.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("{file}:{line}:{column}: `{found}`: {fault}{}", dialect.message_suffix())]
pub struct GcodeError {
    /// The program's name as given.
    pub file: String,
    /// Line in the file, from 1.
    pub line: usize,
    /// Character in the line, from 1.
    pub column: usize,
    /// The text the fault is about.
    pub found: String,
    /// What is wrong with it and what was expected.
    pub fault: Fault,
    /// The dialect in which the program was read.
    pub dialect: Dialect,
}

impl GcodeError {
    /// Returns the same error, saying that the program was read as `dialect`.
    pub(crate) fn with_dialect(self, dialect: Dialect) -> GcodeError {
        GcodeError { dialect, ..self }
    }
}

/// The reason why a word or line of a G-code program is refused; its message says what was expected.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum Fault {
    /// A character no word can hold.
    #[error("unexpected character; expected words such as X10.5, or a comment in ( ) or after ;")]
    Character,
    /// Words of another language than ISO code.
    #[error(
        "not ISO code but another language, such as Sinumerik's or Heidenhain's; expected words such as X10.5, or --dialect, which says what it is"
    )]
    Language,
    /// What another dialect has and what is not followed of it.
    #[error("{0}")]
    Foreign(Foreign),
    /// A variable, an expression or an assignment.
    #[error(
        "variables and expressions are not read; expected plain numbers, or expand in [gcode] of the process file (--expand), which \
         writes it out"
    )]
    Variable,
    /// A line checksum, which a changed line would break.
    #[error("line checksums are not supported; expected the line without `*` and the number after it")]
    Checksum,
    /// A comment that is opened and not closed on its line.
    #[error("comment is not closed; expected `)` on the same line")]
    OpenComment,
    /// A `)` behind a comment that has ended.
    #[error(
        "comment within a comment, which ends at the first `)` to some controls and is an error to others; expected one without ( ) in it"
    )]
    NestedComment,
    /// Something that is no word.
    #[error("not a word; expected a letter followed by a number, such as X10.5")]
    NotAWord,
    /// An E directly behind a number.
    #[error(
        "an exponent, which controls do not read, or a word E; expected digits alone, such as 0.000015, or a blank before E"
    )]
    Exponent,
    /// A coordinate with leading zeros and no point.
    #[error(
        "coordinate with leading zeros and no decimal point, which some controls put in by counting digits; expected a decimal point, such as X0.085"
    )]
    ImpliedPoint,
    /// More digits than a coordinate can hold exactly.
    #[error("number has {digits} digits in a row; expected at most {most}", most = Fault::MAX_DIGITS)]
    TooManyDigits {
        /// Number of digits in a row.
        digits: usize,
    },
    /// A feature of the language this program cannot follow.
    #[error("{0}")]
    Unsupported(Unsupported),
    /// A word that controls read in ways that contradict.
    #[error(
        "{0}; expected dialect = \"fanuc\", \"haas\" or \"linuxcnc\" in [gcode] of the process file (--dialect), which says whose it is"
    )]
    Contradicts(Contradiction),
    /// M72 without M70.
    #[error("restores modes where none are kept; expected M70 or M73 before it, in the same program or subprogram")]
    NothingKept,
    /// Another word on the line of M70 to M73.
    #[error("on a line with M{code}, which keeps or restores modes; expected M{code} on a line of its own")]
    BesideKept {
        /// The number after M.
        code: u32,
    },
    /// A word whose number must be whole.
    #[error("expected a whole number after {letter}")]
    NotWhole {
        /// The word's letter.
        letter: char,
    },
    /// The same letter twice on one line.
    #[error("second {letter} word on the line; expected one")]
    Repeated {
        /// Letter of the repeated word.
        letter: char,
    },
    /// Two tools on one line.
    #[error(
        "second tool on the line, beside T{first}: which of them is in the spindle decides the force; expected one T; put the tool \
         to be fetched next on a line of its own after M6"
    )]
    TwoTools {
        /// Number of the other tool.
        first: f64,
    },
    /// Two words of one modal group on one line.
    #[error("contradicts {other} on the same line; expected one of them")]
    Conflict {
        /// The word before it.
        other: String,
    },
    /// A coordinate, but no motion in force.
    #[error("coordinate without a motion; expected G0, G1, G2, G3 or a cycle on this line or before it")]
    NoMotion,
    /// A coordinate on a line whose G word does not move to it.
    #[error("coordinate on a line with {word}, which is no motion; expected the coordinate on a line of its own")]
    NotACoordinate {
        /// The word that claims the line.
        word: &'static str,
    },
    /// G92 or G10 L20 at a place that is not known any more.
    #[error(
        "sets the origin where {axis} is not known{since}; expected a move to a position before it, or start_mm in [gcode]"
    )]
    OriginAtUnknown {
        /// X, Y or Z.
        axis: &'static str,
        /// Why it is not known: " after line 12", or nothing.
        since: String,
    },
    /// G52 and G92 together.
    #[error("G52 and G92 in force together mean different things to different controls; expected one of them")]
    LocalAndShift,
    /// A G10 whose meaning is not known.
    #[error("this G10 is not read; expected L2 or L20 with P and coordinates in G90, or data of tools")]
    Data,
    /// A, B or C that does not stand still.
    #[error(
        "turns {letter}, which stood at {from}; expected rotary axes that keep one value, or [[gcode.rotary]] in the process file, which \
         says what {letter} turns"
    )]
    Rotary {
        /// A, B or C.
        letter: char,
        /// Where it stood, as the program says.
        from: f64,
    },
    /// A zero of a rotary axis.
    #[error("sets where {letter} is 0; expected no offsets of rotary axes: {letter} is where the machine has it")]
    RotaryZero {
        /// A, B or C.
        letter: char,
    },
    /// A rotary axis that has been led to a place that is not known.
    #[error(
        "the position of {letter} is not known, as a line led the axis to a place of the machine; expected a G0 before that names {letter}"
    )]
    RotaryLost {
        /// A, B or C.
        letter: char,
    },
    /// An axis that turns the tool or the workpiece, and no control of the tip.
    #[error(
        "{letter} is not 0 and X, Y and Z are not those of the tip; expected G43.4 before, through_mm of {letter} in [[gcode.rotary]], or \
         rotary_tip = \"always\" in [gcode]"
    )]
    NoPivot {
        /// A, B or C.
        letter: char,
    },
    /// Control of the tip with an axis turned that is not known.
    #[error(
        "{letter} = {at} with control of the tip; expected [[gcode.rotary]] in the process file, which says what {letter} turns"
    )]
    UnknownRotary {
        /// A, B or C.
        letter: char,
        /// Angle of the axis, degrees.
        at: f64,
    },
    /// An inclined plane that is not followed.
    #[error("{0}")]
    Inclined(InclinedFault),
    /// A cycle drills along Z, and the tool stands otherwise.
    #[error("a cycle with the tool turned ({letter} = {at}); expected it written out as G0 and G1 moves")]
    TurnedCycle {
        /// A, B or C.
        letter: char,
        /// Angle of the axis, degrees.
        at: f64,
    },
    /// A or C with a feed, where no G0 has said that there is such an axis.
    #[error(
        "{letter} with a feed is an axis on some controls and an angle or a chamfer on others; expected a G0 with {letter} before, \
         or the line without it"
    )]
    Chamfer {
        /// A or C.
        letter: char,
    },
    /// I, J, K or R on a line that is no arc.
    #[error("arc word on a line that is no arc; expected G2 or G3 in force")]
    NotAnArc,
    /// P or Q on a line with no word it could belong to.
    #[error("parameter that belongs to no word; expected the G or M word on the line")]
    StrayParameter,
    /// Only the selected plane's two centre words mean anything.
    #[error("centre word outside the selected plane; expected {expected} in {plane}")]
    CentreOutsidePlane {
        /// The two centre words of the plane.
        expected: &'static str,
        /// G17, G18 or G19.
        plane: &'static str,
    },
    /// An arc without centre and without radius.
    #[error("arc without a centre; expected {expected} in {plane}, or R")]
    NoCentre {
        /// The two centre words of the plane.
        expected: &'static str,
        /// G17, G18 or G19.
        plane: &'static str,
    },
    /// An arc with absolute centre (G90.1) that gives one of its two coordinates.
    #[error("absolute centre (G90.1) with one coordinate; expected both {expected} in {plane}")]
    HalfCentre {
        /// The two centre words of the plane.
        expected: &'static str,
        /// G17, G18 or G19.
        plane: &'static str,
    },
    /// An arc whose centre words are of two kinds.
    #[error("one centre word from the start and one from the zero; expected both of one kind")]
    MixedCentre,
    /// A CC with one coordinate, or with one outside the plane.
    #[error("expected both coordinates of the plane that TOOL CALL chooses by the axis of the tool, or none")]
    PoleAxes,
    /// Heidenhain's C without CC.
    #[error("arc without a centre; expected CC with its coordinates before it")]
    NoPole,
    /// An arc with both centre and radius.
    #[error("arc with a radius and a centre; expected one of them")]
    CentreAndRadius,
    /// An arc that cannot be drawn.
    #[error("{0}")]
    Arc(ArcFault),
    /// A work offset that was not given.
    #[error(
        "how {offset} stands to the work offset before it is not known; expected its zero in [gcode] of the process file{}",
        offset.program_source_hint()
    )]
    NoWorkOffset {
        /// The work offset.
        offset: WorkOffset,
    },
    /// G54.1 without the number of a work offset.
    #[error("names no work offset; expected P1 to P300 on the line")]
    NoExtended,
    /// A contour with cutter radius compensation that is not written as the path of the tool centre.
    #[error("{0}")]
    Radius(RadiusFault),
    /// A macro or call that cannot be followed.
    #[error("{0}")]
    Macro(MacroFault),
    /// G93 and no F.
    #[error("inverse time feed (G93) without an F on the line; expected one on each line with G1, G2 or G3")]
    NoInverseTime,
    /// A cycle before its height or depth is said.
    #[error("cycle G{number} without {letter}; expected R and Z on this line or one before it")]
    CycleWithout {
        /// The number after G.
        number: u32,
        /// R or Z.
        letter: char,
    },
    /// A peck that is none, or more than the hole is deep.
    #[error(
        "not a peck of a hole {depth_mm:.3} mm deep; expected Q above 0, at least 1/10000 of the depth, and with a point if it is more"
    )]
    Peck {
        /// From the plane R to the bottom, mm.
        depth_mm: f64,
    },
    /// A cycle in G18 or G19.
    #[error("cycles are read in G17 only; expected the cycle written out as G0 and G1 moves")]
    CyclePlane,
    /// A series of holes in G91 and G99.
    #[error("a second hole in G91 and G99 has another R on other controls; expected G90 or G98")]
    CycleSteps,
    /// More repetitions than anybody drills.
    #[error("expected at most {most} repetitions")]
    TooManyRepeats {
        /// Largest number of repetitions.
        most: u32,
    },
    /// A feed or spindle speed below what it can be.
    #[error("expected {expected}")]
    Speed {
        /// The permitted range.
        expected: &'static str,
    },
    /// A coordinate no machine has.
    #[error("coordinate beyond {most} mm; expected a position on the machine", most = Fault::MAX_COORDINATE_MM)]
    TooFar,
    /// A motion after the end of the program.
    #[error("a motion after the end of the program in line {end}; expected none")]
    AfterEnd {
        /// The line with M2, M30 or the second %.
        end: usize,
    },
    /// An axis on a line that becomes several.
    #[error(
        "an axis that moves with the tool, or an extruder: its line becomes several, and how {letter} is shared among them is not followed; \
         expected A, B or C, {letter} on a line of its own, or a write_tolerance_mm in [gcode] with which the line stays one"
    )]
    MovesWithTool {
        /// Letter of the word.
        letter: char,
    },
    /// More lines or motions than a program may have.
    #[error("a program of {count} {what}; expected at most {most}")]
    TooMany {
        /// Lines or motions.
        what: &'static str,
        /// Their number, as far as they were counted.
        count: usize,
        /// Largest number of them.
        most: usize,
    },
    /// More points than a path may have.
    #[error("path of more than {most} points; expected a coarser sampling or a shorter program")]
    TooManyPoints {
        /// Largest number of points.
        most: usize,
    },
}

impl Fault {
    /// The most digits in a row a number may have: more than any post-processor writes.
    pub const MAX_DIGITS: usize = 64;
    /// The largest coordinate followed, mm.
    pub const MAX_COORDINATE_MM: f64 = MAX_COORDINATE_MM;

    /// Whether the fault may vanish when the program is expanded into its moves.
    pub fn may_vanish_on_expansion(&self) -> bool {
        let of_dialect = |foreign: &Foreign| {
            use Foreign::{Call, Compensation, Corner, Cycle, Flow, Frame, Motion, Parameter};
            matches!(foreign, Parameter | Flow | Call | Cycle | Motion | Corner | Frame | Compensation { .. })
        };
        match self {
            Fault::Variable
            | Fault::Unsupported(
                Unsupported::Subprogram
                | Unsupported::Transform
                | Unsupported::Corner
                | Unsupported::CutterCompensation,
            ) => true,
            Fault::Foreign(foreign) => of_dialect(foreign),
            _ => false,
        }
    }
}
