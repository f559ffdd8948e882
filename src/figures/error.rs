//! Why a figure cannot be drawn.

use thiserror::Error;

/// Why a figure cannot be drawn.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum FigureError {
    /// The figure has nothing to show: no panel, no node or no point.
    #[error("{what}: nothing to draw")]
    Empty {
        /// The empty part.
        what: String,
    },
    /// More panels than fit on one page.
    #[error("{found} panels: at most {most} fit in one figure")]
    TooManyPanels {
        /// Panels given.
        found: usize,
        /// Panels allowed.
        most: usize,
    },
    /// The values do not fill the grid.
    #[error("{what}: {found} values for a grid of {expected} nodes")]
    GridMismatch {
        /// The panel or volume.
        what: String,
        /// Product of the node counts.
        expected: usize,
        /// Values given.
        found: usize,
    },
    /// Grid coordinates that do not increase.
    #[error("{what}: coordinates must increase, but {next} follows {previous}")]
    NotAscending {
        /// The axis.
        what: String,
        /// The node before.
        previous: f64,
        /// The node that is not larger.
        next: f64,
    },
    /// A number that has no place on paper: NaN, infinite or beyond 1e100.
    #[error("{what}: {value} cannot be drawn")]
    NotDrawable {
        /// Where the number is.
        what: String,
        /// The number.
        value: f64,
    },
    /// A colour range that is not an interval.
    #[error("colour range {low} to {high}: the first must be below the second")]
    BadRange {
        /// Lower end.
        low: f64,
        /// Upper end.
        high: f64,
    },
    /// Zero or less on a logarithmic axis.
    #[error("{what}: {value} has no place on a logarithmic axis")]
    NotPositive {
        /// The series.
        what: String,
        /// The number.
        value: f64,
    },
    /// Equal axes and a logarithmic axis at once.
    #[error("equal axes need two linear axes")]
    EqualAxesWithLog,
    /// The image encoder or canvas failed.
    #[error("cannot write the image: {reason}")]
    Encode {
        /// What the library said.
        reason: String,
    },
}

/// Largest magnitude that is drawn; keeps differences and products of coordinates finite.
const LARGEST: f64 = 1e100;

/// Checks that no value is NaN, infinite or too large to be drawn; the error names `what` holds it.
pub(super) fn check_drawable(
    values: impl IntoIterator<Item = f64>,
    what: impl Fn() -> String,
) -> Result<(), FigureError> {
    match values.into_iter().find(|v| !v.is_finite() || v.abs() > LARGEST) {
        Some(value) => Err(FigureError::NotDrawable { what: what(), value }),
        None => Ok(()),
    }
}

/// Checks that `nodes` are drawable, increase strictly and are at least one; the error names `what` they belong to.
pub(super) fn check_ascending(nodes: &[f64], what: impl Fn() -> String) -> Result<(), FigureError> {
    if nodes.is_empty() {
        return Err(FigureError::Empty { what: what() });
    }
    check_drawable(nodes.iter().copied(), &what)?;
    match nodes.windows(2).find(|pair| pair[1] <= pair[0]) {
        Some(pair) => Err(FigureError::NotAscending { what: what(), previous: pair[0], next: pair[1] }),
        None => Ok(()),
    }
}

/// Checks that there are `expected` values, and that all present ones can be drawn; the error names `what` they belong to.
pub(super) fn check_grid(
    values: &[Option<f64>],
    expected: usize,
    what: impl Fn() -> String,
) -> Result<(), FigureError> {
    if values.len() != expected {
        return Err(FigureError::GridMismatch { what: what(), expected, found: values.len() });
    }
    check_drawable(values.iter().copied().flatten(), what)
}
