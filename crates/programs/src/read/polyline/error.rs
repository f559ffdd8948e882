//! Faults of polyline files.

use thiserror::Error;

use crate::model::Sampling;
use kinetostat_input::csv_rows::RowFault;
use kinetostat_spatial::MAX_EXTERNAL_AXES;

/// A polyline file that cannot be read: which file and line, and why.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("{file}:{line}: {fault}")]
pub struct PolylineError {
    /// The file's name as given.
    pub file: String,
    /// Line in the file, from 1.
    pub line: usize,
    /// What is wrong and what was expected.
    pub fault: PolylineFault,
}

/// What is wrong with a line of a polyline file.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum PolylineFault {
    /// An unknown column.
    #[error("unknown column `{name}`; expected x_mm, y_mm, z_mm and any of {optional}")]
    UnknownColumn {
        /// The name in the header.
        name: String,
        /// The names of the columns that need not be there.
        optional: String,
    },
    /// Two columns of the same name.
    #[error("second column `{name}`; expected one")]
    RepeatedColumn {
        /// The name.
        name: String,
    },
    /// More external axes than a path commands.
    #[error("{count} external axes; expected at most {most}", most = MAX_EXTERNAL_AXES)]
    TooManyAxes {
        /// How many there are.
        count: usize,
    },
    /// A missing column.
    #[error("no column `{name}`; expected it {because}")]
    MissingColumn {
        /// Its name.
        name: String,
        /// Why it must be there.
        because: &'static str,
    },
    /// A row that cannot be read, of another width, or with a value that its column cannot hold.
    #[error(transparent)]
    Row(#[from] RowFault),
    /// Columns of both the tool's axis and the platform's orientation.
    #[error("columns of the tool's axis and of the platform's orientation; expected one of them")]
    TwoOrientations,
    /// A tool axis of length 0.
    #[error("axis_x, axis_y, axis_z are all 0; expected a direction")]
    NoDirection,
    /// A quaternion that is not of unit length.
    #[error("platform_qw, platform_qx, platform_qy, platform_qz have length {norm}; expected 1")]
    NotUnit {
        /// Its length.
        norm: f64,
    },
    /// A header and no rows, or nothing at all.
    #[error("no points; expected a header and at least one row")]
    NoPoints,
    /// More rows than a path may have points.
    #[error("more than {most} points; expected fewer", most = Sampling::MAX_POINTS)]
    TooManyPoints,
}
