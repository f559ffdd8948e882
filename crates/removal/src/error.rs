//! What is refused, and why.

use thiserror::Error;

/// Input that no removal can be computed from. Lengths are in mm.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum RemovalError {
    /// A dimension is not a positive finite number.
    #[error("{what} is {value}: expected a positive number of mm")]
    NotPositive {
        /// The dimension.
        what: &'static str,
        /// What was given.
        value: f64,
    },
    /// The corner radius is negative or larger than the radius of the cutter.
    #[error("corner radius {corner_mm} mm: expected 0 to {radius_mm} mm, the radius of the cutter")]
    Corner {
        /// What was given.
        corner_mm: f64,
        /// Radius of the cutter.
        radius_mm: f64,
    },
    /// The point angle of a drill is not between 0 and 180°.
    #[error("point angle {angle_deg}°: expected more than 0 and less than 180°")]
    PointAngle {
        /// What was given, degrees.
        angle_deg: f64,
    },
    /// A position or direction has a coordinate that is not finite or larger than any machine.
    #[error("{what} ({x}, {y}, {z}): expected numbers of at most 1e9")]
    NotFinite {
        /// What it is.
        what: &'static str,
        /// x, mm.
        x: f64,
        /// y, mm.
        y: f64,
        /// z, mm.
        z: f64,
    },
    /// A cutter is to be cut into more slices or rings than is of use.
    #[error("{slices} slices of the cutter: expected at most {most}")]
    TooManySlices {
        /// Slices that were asked for.
        slices: f64,
        /// Slices that there may be.
        most: u32,
    },
    /// A direction of motion has no length.
    #[error("direction of motion without length")]
    NoDirection,
    /// The upper corner of a box is not above the lower one on each axis.
    #[error("box from {low:?} to {high:?}: expected a larger upper corner on each axis")]
    EmptyBox {
        /// Lower corner, mm.
        low: [f64; 3],
        /// Upper corner, mm.
        high: [f64; 3],
    },
    /// The field would have more columns than can be numbered.
    #[error("{columns} columns of {cell_mm} mm: expected at most {most}; use a larger cell")]
    TooManyColumns {
        /// Columns that the stock needs.
        columns: f64,
        /// Size of a cell.
        cell_mm: f64,
        /// Columns that can be numbered.
        most: u32,
    },
    /// More moves cut than can be numbered.
    #[error("more than {most} moves in a field")]
    TooManyMoves {
        /// Moves that can be numbered.
        most: u32,
    },
    /// A triangle names a vertex that there is not, or the mesh has none.
    #[error("mesh: {fault}")]
    Mesh {
        /// What is wrong.
        fault: String,
    },
}

/// Returns `value` if it is positive and finite.
pub(crate) fn positive(what: &'static str, value: f64) -> Result<f64, RemovalError> {
    if value > 0.0 && value.is_finite() { Ok(value) } else { Err(RemovalError::NotPositive { what, value }) }
}

/// Fails if a coordinate of `at` is not finite, or so large that squares of it would not be.
pub(crate) fn finite(what: &'static str, at: &nalgebra::Vector3<f64>) -> Result<(), RemovalError> {
    if at.iter().all(|value| value.abs() <= 1e9) {
        return Ok(());
    }
    Err(RemovalError::NotFinite { what, x: at.x, y: at.y, z: at.z })
}
