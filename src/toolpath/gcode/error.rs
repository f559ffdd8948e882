//! What can be wrong with a program, said so that the line can be found and mended.

use std::ops::Range;

use thiserror::Error;

use crate::toolpath::{Sampling, path::MAX_COORDINATE_MM};

/// A program that cannot be followed: where, at which word, why, and what was expected.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("{file}:{line}:{column}: `{found}`: {fault}")]
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
}

impl From<GcodeError> for crate::input::error::Error {
    fn from(fault: GcodeError) -> Self {
        Self::program(fault)
    }
}

/// What is wrong with a word or a line. The text says what was expected.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum Fault {
    /// A character no word can hold.
    #[error("unexpected character; expected words such as X10.5, or a comment in ( ) or after ;")]
    Character,
    /// A variable, an expression or an assignment.
    #[error("variables and expressions are not supported; expected plain numbers")]
    Variable,
    /// A line checksum, which a changed line would break.
    #[error("line checksums are not supported; expected the line without `*` and the number after it")]
    Checksum,
    /// A comment that is opened and not closed on its line.
    #[error("comment is not closed; expected `)` on the same line")]
    OpenComment,
    /// Something the lexer does not take for a word.
    #[error("not a word; expected a letter followed by a number, such as X10.5")]
    NotAWord,
    /// More digits than a coordinate can hold exactly.
    #[error("number has {digits} digits in a row; expected at most {most}", most = Fault::MAX_DIGITS)]
    TooManyDigits {
        /// How many there are.
        digits: usize,
    },
    /// A feature of the language this program cannot follow.
    #[error("{0}")]
    Unsupported(Unsupported),
    /// A word whose number must be whole.
    #[error("expected a whole number after {letter}")]
    NotWhole {
        /// The word's letter.
        letter: char,
    },
    /// The same letter twice on one line.
    #[error("second {letter} word on the line; expected one")]
    Repeated {
        /// The letter.
        letter: char,
    },
    /// Two words of one modal group on one line.
    #[error("contradicts {other} on the same line; expected one of them")]
    Conflict {
        /// The word before it.
        other: String,
    },
    /// A coordinate, but no motion in force.
    #[error("coordinate without a motion; expected G0, G1, G2 or G3 on this line or before it")]
    NoMotion,
    /// A coordinate on a line whose G word does not move to it.
    #[error("coordinate on a line with {word}, which is no motion to it; expected it on a line of its own")]
    NotACoordinate {
        /// The word that claims the line.
        word: &'static str,
    },
    /// A move that needs to know where it starts, and does not.
    #[error(
        "starts at an unknown {axes}{since}; expected a G0 to a position in X, Y and Z before it, or a given start"
    )]
    UnknownStart {
        /// The axes, such as "X, Z".
        axes: String,
        /// Why they are not known: " after line 12", or nothing at the program's start.
        since: String,
    },
    /// I, J, K or R on a line that is no arc.
    #[error("arc word on a line that is no arc; expected G2 or G3 in force")]
    NotAnArc,
    /// P or Q on a line with no word it could belong to.
    #[error("parameter that belongs to no word; expected G4, G64 or an M word on the line")]
    StrayParameter,
    /// Only the selected plane's two centre words mean anything.
    #[error("centre word outside the selected plane; expected {expected} in {plane}")]
    CentreOutsidePlane {
        /// The two that would be right.
        expected: &'static str,
        /// G17, G18 or G19.
        plane: &'static str,
    },
    /// An arc without centre and without radius.
    #[error("arc without a centre; expected {expected} in {plane}, or R")]
    NoCentre {
        /// The two centre words.
        expected: &'static str,
        /// G17, G18 or G19.
        plane: &'static str,
    },
    /// An arc with absolute centre (G90.1) that gives one of its two coordinates.
    #[error("absolute centre (G90.1) with one coordinate; expected both {expected} in {plane}")]
    HalfCentre {
        /// The two centre words.
        expected: &'static str,
        /// G17, G18 or G19.
        plane: &'static str,
    },
    /// An arc with both centre and radius.
    #[error("arc with a radius and a centre; expected one of them")]
    CentreAndRadius,
    /// An arc that cannot be drawn.
    #[error("{0}")]
    Arc(ArcFault),
    /// A work offset that was not given.
    #[error("its work offset is not known; expected an offset for {word} among the options")]
    NoWorkOffset {
        /// G54 to G59.
        word: &'static str,
    },
    /// A feed or spindle speed below what it can be.
    #[error("expected {expected}")]
    Speed {
        /// The range.
        expected: &'static str,
    },
    /// A coordinate no machine has.
    #[error("coordinate beyond {most} mm; expected a position on the machine", most = Fault::MAX_COORDINATE_MM)]
    TooFar,
    /// Something after the end of the program.
    #[error("after the end of the program in line {end}; expected only comments and %")]
    AfterEnd {
        /// The line with M2 or M30.
        end: usize,
    },
    /// More points than a path may have.
    #[error("path of more than {most} points; expected a coarser sampling or a shorter program", most = Sampling::MAX_POINTS)]
    TooManyPoints,
}

impl Fault {
    /// The most digits in a row a number may have; 17 identify any `f64`.
    pub const MAX_DIGITS: usize = 17;
    /// The largest coordinate followed, mm.
    pub const MAX_COORDINATE_MM: f64 = MAX_COORDINATE_MM;
}

/// A feature of the language that cannot be followed, so that ignoring it would cut something else.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum Unsupported {
    /// G41, G42 and their kin.
    #[error("cutter radius compensation is not supported; expected the path of the tool centre with G40")]
    CutterCompensation,
    /// G73, G74, G76, G81 to G89.
    #[error("canned cycles are not supported; expected the cycle written out as G0 and G1 moves")]
    CannedCycle,
    /// G10, G52, G92 and their kin.
    #[error("changing the origin inside a program is not supported; expected work offsets G54 to G59 given as options")]
    Origin,
    /// G59.1 to G59.3.
    #[error("more than six work offsets are not supported; expected G54 to G59")]
    ManyOffsets,
    /// G16, G50, G51, G68: polar, scaled and rotated coordinates.
    #[error("polar, scaled or rotated coordinates are not supported; expected plain coordinates")]
    Transform,
    /// G93.
    #[error("inverse-time feed is not supported; expected feed in units per minute, G94")]
    InverseTimeFeed,
    /// G95.
    #[error("feed per revolution is not supported; expected feed in units per minute, G94")]
    FeedPerRevolution,
    /// G96.
    #[error("constant surface speed is not supported; expected spindle speed in rev/min, G97")]
    SurfaceSpeed,
    /// G5, G6, G33, G38 and other motions.
    #[error("this motion is not supported; expected G0, G1, G2 or G3")]
    Motion,
    /// G28 or G30 with a parameter, G43.1, G44 and other variants.
    #[error("this G word is not supported; expected a word of a 3-axis mill program")]
    UnknownG,
    /// A, B, C.
    #[error("rotary axes are not supported; expected X, Y and Z only")]
    RotaryAxis,
    /// U, V, W.
    #[error("secondary axes are not supported; expected X, Y and Z only")]
    SecondaryAxis,
    /// M97, M98, M99, O words after the first.
    #[error("subprograms are not supported; expected one program with its calls written out")]
    Subprogram,
    /// Any other letter.
    #[error("this word is not supported; expected one of D F G H I J K M N O P Q R S T X Y Z")]
    Letter,
    /// G53 with an arc in force.
    #[error("machine coordinates with an arc are not supported; expected G53 with G0 or G1")]
    MachineArc,
}

/// An arc whose words do not make an arc.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum ArcFault {
    /// Start and end at different distances from the centre.
    #[error(
        "arc starts {start_mm:.4} mm and ends {end_mm:.4} mm from its centre; expected equal radii to 0.005 mm or 0.1 %"
    )]
    Radii {
        /// Distance from centre to start, mm.
        start_mm: f64,
        /// Distance from centre to end, mm.
        end_mm: f64,
    },
    /// The centre is the start.
    #[error("arc of radius zero; expected a centre away from the start")]
    NoRadius,
    /// A radius too small to reach the end.
    #[error("radius {radius_mm:.4} mm cannot reach an end {chord_mm:.4} mm away; expected at least half the distance")]
    TooShort {
        /// The radius given, mm.
        radius_mm: f64,
        /// Distance from start to end in the plane, mm.
        chord_mm: f64,
    },
    /// A radius and no distance: any centre would do.
    #[error("radius form with its end at its start has no definite centre; expected a full circle by its centre")]
    NoChord,
}

/// A fault at a place in a line, before file and line are known.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Refusal {
    /// Bytes of the line the fault is about.
    pub span: Range<usize>,
    pub fault: Fault,
}

impl Refusal {
    pub fn new(span: Range<usize>, fault: Fault) -> Refusal {
        Refusal { span, fault }
    }

    /// The error, with the file, the line number from 1, and the line's own bytes to quote from.
    pub fn locate(self, file: &str, line: usize, content: &[u8]) -> GcodeError {
        let before = content.get(..self.span.start).unwrap_or_default();
        let found = content.get(self.span).unwrap_or_default();
        GcodeError {
            file: file.to_owned(),
            line,
            column: String::from_utf8_lossy(before).chars().count() + 1,
            found: String::from_utf8_lossy(found).into_owned(),
            fault: self.fault,
        }
    }
}
