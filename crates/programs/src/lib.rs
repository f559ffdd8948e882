//! NC and robot programs: lines and circles, G-code, robot languages, APT and CSV, read and written back with moved points.
//!
//! What a program is, from its bytes on; each stage is made of the one before it:
//!
//! | stage | what it is |
//! |---|---|
//! | [`gcode::GcodeProgram`], [`robot::RobotProgram`], [`polyline::Polyline`] | a program read and followed, held as its bytes |
//! | [`ProgramFile`] | any of these, as the name and the bytes of a file say |
//! | [`Toolpath`] | the [`PathPoint`]s that it leads through, each with the move it comes from; also generated ([`Circle`], [`Toolpath::line`]) |
//! | [`Rewritten`] | the program written through other points, all else as it was, and where each point lies in it |
//! | [`CommandedPath`] | where the written program, read back, sends the tool at these points |
//! | [`RewrittenFile`] | bytes and commanded path of a rewritten [`ProgramFile`], its [`blocks`], and what became of its [calls](gcode::Calls) |
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

pub use file::{ProgramFile, ProgramOptions};
pub use model::{
    gcode::options::WriteOptions,
    generate::{Circle, GenerateError, cutting_point},
    number::{FormatError, NumberFormat},
    orientation::Orientation,
    path::{Load, PathPoint, Plane, PointSource, PositionsError, Toolpath, TurnDirection, Way},
    program::{RewriteError, Rewritten},
    sampling::{Sampling, SamplingError},
    tool::{ToolDescription, ToolShape},
};
pub use rewritten::{CommandedPath, RewrittenFile};

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
