//! NC and robot programs: lines and circles, G-code, robot languages, APT and CSV, read and written back with moved points.
//!
//! A [`Toolpath`] is a list of [`PathPoint`]s. It comes from a generator ([`Circle`], [`Toolpath::line`]), from a
//! polyline in a CSV file ([`polyline`]), from a G-code program ([`gcode`]) or from one of a robot ([`robot`]); [`ProgramFile`] is any of these
//! in a file. A path from a file remembers where each point came from, so that moved points can be written back into the same file without
//! touching anything else.
//!
//! Units: mm, mm/min, rev/min, N, N·mm. Frame: the workpiece frame W throughout.

#![warn(missing_docs)]

pub mod blocks;
mod expand;
mod file;
pub mod gcode;
mod model;
pub mod polyline;
mod read;
mod rewritten;
pub mod robot;
mod write;

pub use file::{ProgramFile, ProgramOptions, line_in_words};
pub use model::{
    generate::{Circle, GenerateError, cutting_point},
    number::{FormatError, NumberFormat},
    orientation::{Orientation, least_turn},
    path::{Load, PathPoint, Plane, PointSource, PositionsError, Toolpath, TurnDirection},
    program::{Program, RewriteError, Rewritten},
    sampling::{Sampling, SamplingError},
    tool::{SAME_TOOL_MM, ToolDescription, ToolShape},
};
pub use rewritten::{CommandedPath, RewrittenFile};

/// What tests hold against closed forms: no part of the interface.
#[doc(hidden)]
pub mod internals {
    pub use super::{
        model::{
            number::{decimals_in, format_fixed},
            robot::arc::Arc,
        },
        read::{
            gcode::tool_comments::tool_comments,
            robot::frames::{Base, Bases, Tool, Tools},
            scan::Scan,
        },
        write::gcode::fit::centre_through,
    };
}

/// Faults of programs and paths, of which the one error of the program is made.
macro_rules! program_faults {
    ($($fault:ty),+) => {
        $(impl From<$fault> for kinetostat_input::error::Error {
            fn from(fault: $fault) -> Self {
                Self::program(fault)
            }
        })+
    };
}

program_faults!(
    FormatError,
    PositionsError,
    RewriteError,
    gcode::GcodeError,
    polyline::PolylineError,
    robot::RobotError
);

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
