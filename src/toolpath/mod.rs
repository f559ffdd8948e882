//! Toolpaths and programs: lines and circles, G-code, robot languages, APT and CSV, read and written back with moved points.
//!
//! A [`Toolpath`] is a list of [`PathPoint`]s. It comes from a generator ([`Circle`], [`Toolpath::line`]), from a
//! polyline in a CSV file ([`polyline`]) or from a G-code program ([`gcode`]). A path from a file remembers where each
//! point came from, so that moved points can be written back into the same file without touching anything else.
//!
//! Units: mm, mm/min, rev/min, N, N·mm. Frame: the workpiece frame W throughout.

mod expand;
pub mod gcode;
mod model;
pub mod polyline;
mod read;
pub mod robot;
mod write;

pub(crate) use model::{generate::cutting_point, tool::SAME_TOOL_MM};
pub use model::{
    generate::{Circle, GenerateError},
    number::{FormatError, NumberFormat},
    orientation::{Orientation, least_turn},
    path::{
        Bend, BentWall, Engaged, Load, PathPoint, Plane, PointSource, PositionsError, Toolpath, TurnDirection,
        UnknownForce,
    },
    program::{Program, RewriteError, Rewritten},
    sampling::{Sampling, SamplingError},
    tool::{ToolDescription, ToolShape},
};

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
        $(impl From<$fault> for crate::input::error::Error {
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
