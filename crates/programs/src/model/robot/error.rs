//! The errors of robot and APT programs, each with the line, the statement and what was expected.

use thiserror::Error;

use crate::model::{MAX_COORDINATE_MM, MAX_MIB, gcode::ArcFault};

/// The error of a robot or APT program that cannot be followed: file, line, statement, reason and what was expected.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("{file}:{line}: `{statement}`: {fault}")]
pub struct RobotError {
    /// The program's name as given.
    pub file: String,
    /// Line in the file, from 1.
    pub line: usize,
    /// The statement the fault is about.
    pub statement: String,
    /// What is wrong with it and what was expected.
    pub fault: RobotFault,
}

/// The reason why a statement of a robot or APT program is refused; its message says what was expected.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum RobotFault {
    /// A statement of the language that is not followed.
    #[error("{what} not followed; expected {expected}")]
    NotFollowed {
        /// What it is, with its verb: "splines are".
        what: &'static str,
        /// What is followed instead.
        expected: &'static str,
    },
    /// Something that is no statement known here.
    #[error("not a statement that is known; expected {expected}")]
    Unknown {
        /// What a statement may be.
        expected: &'static str,
    },
    /// A form that a statement does not have.
    #[error("expected {expected}")]
    Form {
        /// What was expected at this place.
        expected: &'static str,
    },
    /// A motion that need not run, or not once.
    #[error("in {keyword} of line {line}, where it may be skipped or repeated; expected outside, where it runs once")]
    Branch {
        /// Keyword of the branch or loop around the motion.
        keyword: String,
        /// Line at which the branch or loop begins, from 1.
        line: usize,
    },
    /// A motion in a second routine.
    #[error(
        "a motion in the routine of line {line}, beside those of line {first}; expected all motions in one routine"
    )]
    SecondRoutine {
        /// Where the routine begins, from 1.
        line: usize,
        /// Where the first with motions does.
        first: usize,
    },
    /// A routine with motions that no other calls.
    #[error(
        "has motions and is not called; expected all motions in the routine of line {first}, or in those that it calls"
    )]
    Uncalled {
        /// Where the routine that runs first begins, from 1.
        first: usize,
    },
    /// A call of what is not in the file.
    #[error(
        "calls {name}, which may move the tool; expected the program in one routine, or {name} in robot_program.calls_kept if it does not"
    )]
    Call {
        /// Name of the routine.
        name: String,
    },
    /// A point that is not in the file.
    #[error("{name} is not known; expected its numbers in the file{beside}, or in the statement")]
    NoPoint {
        /// Name of the point.
        name: String,
        /// Which other file was looked at: " or beside it in part.dat".
        beside: String,
    },
    /// A point that was computed.
    #[error("{name} is computed in line {line}; expected a point whose numbers the file gives")]
    Computed {
        /// Name of the point.
        name: String,
        /// Line of the computation, from 1.
        line: usize,
    },
    /// A value that the program does not give.
    #[error("the value of {name} is not known; expected numbers and truths that the program itself gives")]
    NoValue {
        /// Name of the datum or function.
        name: String,
    },
    /// Brackets and their kin too deep in one another.
    #[error(
        "{depth} levels of brackets, signs, branches and data in one another; expected at most {most}, and names for what stands within"
    )]
    TooDeep {
        /// Number of levels.
        depth: usize,
        /// Largest number of levels.
        most: usize,
    },
    /// A program whose statements are too long in all.
    #[error(
        "up to here, the statements that the program runs have more than {MAX_MIB} MiB in all; expected a program that is shorter written out"
    )]
    TooManyBytes,
    /// More motions than a program may have.
    #[error("a program of {count} motions; expected at most {most}")]
    TooManyMotions {
        /// Number of motions.
        count: usize,
        /// Largest number of motions.
        most: usize,
    },
    /// A program that goes on and on.
    #[error("the program has run {most} statements and has not ended; expected one that ends")]
    TooManySteps {
        /// Number of statements that were run.
        most: usize,
    },
    /// A base whose place is not known.
    #[error(
        "where {name} stands to the base before it is not known; expected its pose in robot_program.bases of the process"
    )]
    NoBase {
        /// Name of the base.
        name: String,
    },
    /// A second tool whose rotation or tip may be another.
    #[error(
        "uses {name} after {before}: split it into a program for each tool; several in one are read where the program gives their orientation and their tips are the same"
    )]
    SecondTool {
        /// Name of the second tool.
        name: String,
        /// Name of the tool before it.
        before: String,
    },
    /// An external axis that moves and is not named.
    #[error(
        "external axis {axis} goes from {from} to {to}; expected the axis to stand still, or its drive in robot_program.external_axes"
    )]
    External {
        /// Number of the external axis, from 1.
        axis: usize,
        /// Position before, mm or degrees.
        from: f64,
        /// Position to which the program moves it, mm or degrees.
        to: f64,
    },
    /// An external axis that is named, but nothing says where it stands.
    #[error("nothing says where external axis {axis} stands; expected its value here or before")]
    NoExternal {
        /// Number of the external axis, from 1.
        axis: usize,
    },
    /// A circle whose start is not known.
    #[error("circular motion from a place that is not known; expected a motion to a full pose before it")]
    CircleFromNowhere,
    /// Three points on no circle.
    #[error("start, middle and end are on no circle; expected three points apart and not on a line")]
    NoCircle,
    /// An arc of APT that does not exist.
    #[error("{0}")]
    Arc(ArcFault),
    /// CUTCOM, without a word on which points these are.
    #[error(
        "whether points under CUTCOM are those of the tool centre is not known; expected cutcom_points = \"tool_centre\" or \"contour\" in \
         [robot_program] of the process file"
    )]
    Cutcom,
    /// A part of an orientation where it is not unique.
    #[error("part of an orientation near B = ±90°, where A and C are not unique; expected A, B and C")]
    PartOfOrientation,
    /// A quaternion or axis of no length.
    #[error("{what} has length {length}; expected 1")]
    NotUnit {
        /// Quaternion or tool axis.
        what: &'static str,
        /// Length of the quaternion or axis.
        length: f64,
    },
    /// A coordinate no machine has.
    #[error("coordinate or external axis beyond {MAX_COORDINATE_MM}; expected a position on the machine")]
    TooFar,
    /// A motion behind the end.
    #[error("a motion after the end of the program in line {end}; expected none")]
    AfterEnd {
        /// Line at which the program ends, from 1.
        end: usize,
    },
    /// More points than a path may have.
    #[error("path of more than {most} points; expected a coarser sampling or a shorter program")]
    TooManyPoints {
        /// Largest number of points.
        most: usize,
    },
}

impl RobotFault {
    /// Whether the fault may vanish where the program is expanded (calls inlined, branches and loops executed, targets computed), which callers then
    /// try. A statement that is not followed, or has a form that is not, may stand in a branch that is never taken.
    #[must_use]
    pub fn may_vanish_on_expansion(&self) -> bool {
        matches!(
            self,
            Self::Branch { .. }
                | Self::SecondRoutine { .. }
                | Self::Call { .. }
                | Self::NoPoint { .. }
                | Self::Computed { .. }
                | Self::AfterEnd { .. }
                | Self::NotFollowed { .. }
                | Self::Form { .. }
        )
    }

    /// Whether it is a limit that the program has met, whatever is done with what it computes.
    pub(crate) fn is_limit(&self) -> bool {
        matches!(self, Self::TooManySteps { .. } | Self::TooManyBytes | Self::TooDeep { .. })
    }

    /// Refuses `what`, with its verb, where `expected` is followed instead.
    pub(crate) fn not_followed<T>(what: &'static str, expected: &'static str) -> Result<T, Self> {
        Err(Self::NotFollowed { what, expected })
    }
}
