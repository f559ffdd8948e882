//! Polylines in CSV files: one point a row, units in the column names.
//!
//! | column | | meaning |
//! |---|---|---|
//! | `x_mm`, `y_mm`, `z_mm` | required | position of the tool tip in the workpiece frame |
//! | `feed_mm_per_min` | optional | feed on the way to the point |
//! | `spindle_rev_per_min` | optional | spindle speed on the way to the point |
//! | `force_x_N`, `force_y_N`, `force_z_N` | optional, together | force on the tool, workpiece axes |
//! | `moment_x_Nmm`, `moment_y_Nmm`, `moment_z_Nmm` | optional, together | moment on the tool about its tip |
//! | `axis_x`, `axis_y`, `axis_z` | optional, together | direction of the tool's axis, from its tip to the spindle, workpiece axes |
//! | `platform_qw`, `platform_qx`, `platform_qy`, `platform_qz` | optional, together | orientation of the platform or flange `R_WP`, a quaternion |
//! | `external_DRIVE_mm`, `external_DRIVE_deg` | optional, up to six | where the drive stands: a rail before an arm, one under the workpiece |
//! | `cutting` | optional | 1 if the tool cuts on the way to the point, 0 if not; 1 without the column |
//!
//! Columns may stand in any order. Any other column is refused. The path is straight between rows and split like the lines of a program
//! ([`Polyline::sampled`]); forces, moments and external axes given with rows are interpolated, and the tool turns evenly. The tangent at a
//! row halves the turn the path makes there, and is that of arrival at a corner of more than 20°; a path that ends where it begins turns
//! there as well, so that it is the same whichever corner comes first.

pub use super::{
    read::polyline::{
        Polyline,
        error::{PolylineError, PolylineFault},
    },
    write::polyline::write,
};
