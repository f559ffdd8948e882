//! Cutter radius compensation: what the radius of a cutter is of, and why compensation is not followed.

use std::{fmt, str::FromStr};

use thiserror::Error;

/// What the radius of a cutter is of: a number of the offset table, or a tool.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum CutterOf {
    /// D1 and so on.
    Offset(u32),
    /// T1 and so on.
    Tool(u32),
}

impl fmt::Display for CutterOf {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            CutterOf::Offset(number) => write!(f, "D{number}"),
            CutterOf::Tool(number) => write!(f, "T{number}"),
        }
    }
}

impl FromStr for CutterOf {
    type Err = ();

    /// Parses `D1` or `T1`.
    fn from_str(text: &str) -> Result<CutterOf, ()> {
        let number = |digits: &str| match digits.bytes().all(|byte| byte.is_ascii_digit()) {
            true => digits.parse().map_err(|_| ()),
            false => Err(()),
        };
        match text.split_at_checked(1) {
            Some(("D", digits)) => number(digits).map(CutterOf::Offset),
            Some(("T", digits)) => number(digits).map(CutterOf::Tool),
            _ => Err(()),
        }
    }
}

/// Why a contour with cutter radius compensation is not written as the path of the tool centre.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum RadiusFault {
    /// A cutter without a radius.
    #[error(
        "cutter radius compensation with a radius that is not known; expected {} in cutter_radius_mm of [gcode] in the process file",
        of.map_or_else(|| "a D or T number in the program, and its radius".to_owned(), |of| format!("the radius of {of}"))
    )]
    NotGiven {
        /// What the program names.
        of: Option<CutterOf>,
    },
    /// Oversize of the cutter in TOOL CALL.
    #[error(
        "cutter radius compensation of a tool with DR in its call; expected the call without DR, and the radius with it in the process file"
    )]
    Delta,
    /// G42 behind G41, another D, or G41 before the move away from the contour before.
    #[error(
        "changes cutter radius compensation in force; expected it switched off, a straight move away from the contour, and then the next one"
    )]
    Changed,
    /// A word that must not stand there.
    #[error(
        "stands in cutter radius compensation, where it is not followed; expected it before G41 or behind G40 and the move that follows"
    )]
    Inside,
    /// Rotary axes.
    #[error("turns rotary axes in cutter radius compensation; expected them to stand still")]
    Turns,
    /// Sinumerik's D0, D2 and so on.
    #[error(
        "cutter radius compensation by D0 or another edge of the tool than D1; expected D1, whose radius is that of T in the process file"
    )]
    Edge,
    /// G10 or TOOL DEF with a radius.
    #[error(
        "sets a radius of a tool in a program with cutter radius compensation; expected radii in the process file alone"
    )]
    SetByProgram,
    /// A move to a contour, and nothing behind it.
    #[error(
        "leads to no contour in cutter radius compensation, so that it is not known where the cutter goes; expected a line or an arc in X and Y behind it"
    )]
    Alone,
    /// A line that is read otherwise than it was meant.
    #[error(
        "cannot be written as the path of the tool centre in this form; expected G90 and G91, plane and centres on lines of their own before it"
    )]
    Misread,
    /// An arc to the contour or away from it.
    #[error("begins or ends cutter radius compensation on an arc; expected a straight line")]
    Arc,
    /// An unknown position.
    #[error(
        "leads from or to a position that is not known, in cutter radius compensation; expected X and Y in G90 before it"
    )]
    Unknown,
    /// Reversal.
    #[error(
        "turns back in cutter radius compensation, where the cutter could go round on either side; expected a contour that does not"
    )]
    TurnsBack,
    /// A contour into which the cutter does not fit.
    #[error(
        "the cutter does not fit beside this block of the contour; expected a smaller radius, or blocks in which it has room"
    )]
    Narrow,
    /// A cutter that would damage another block of the contour.
    #[error(
        "the cutter would cut into the contour of line {line}; expected a smaller radius, or a move to the contour and from it beside it"
    )]
    CutsInto {
        /// The line of the block, from 1.
        line: usize,
    },
}
