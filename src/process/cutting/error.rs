//! The errors of cutting forces along a path and of wrench tables.

use thiserror::Error;

use crate::input::csv_rows::RowFault;

/// Why the cutting force along a path cannot be computed.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum LoadError {
    /// The tool cuts where a wrench table has no rows.
    #[error(
        "the wrench table covers the path from {table_from_mm} to {table_to_mm} mm, but the tool cuts from \
         {cut_from_mm} to {cut_to_mm} mm: expected rows over the whole cut"
    )]
    TableTooShort {
        /// First arc length of the table, mm.
        table_from_mm: f64,
        /// Last arc length of the table, mm.
        table_to_mm: f64,
        /// Arc length at the first cutting point, mm.
        cut_from_mm: f64,
        /// Arc length at the last cutting point, mm.
        cut_to_mm: f64,
    },
    /// The load was to come with the path and did not.
    #[error(
        "the path gives no load for move {}: expected the columns force_x_N, force_y_N, force_z_N", segment + 1
    )]
    NoLoad {
        /// Index of the move.
        segment: usize,
    },
    /// The path has loads that nothing uses.
    #[error(
        "the path brings loads along, but the process {}: expected force.from_path = true, or a path without force \
         columns",
        if *other_law { "takes the cutting force from elsewhere" } else { "has no cutting force" }
    )]
    UnusedLoads {
        /// Whether the process has another cutting force.
        other_law: bool,
    },
    /// Tools have forces of their own, and the path does not say which tool cuts.
    #[error(
        "the path does not say which tool cuts, which force_of_tool asks for: expected a program with T, or one force, [force]"
    )]
    ToolNotKnown,
    /// Something is cut with a tool that has no force, and others have.
    #[error(
        "{} cuts on move {} and has no force: expected {}, or [force] for all tools without a force of their own",
        tool.map_or("a tool without number".into(), |number| format!("tool {number}")),
        segment + 1,
        tool.map_or("T before it".into(), |number| format!("[force_of_tool.{number}]"))
    )]
    NoForce {
        /// Its number, if the path says it.
        tool: Option<u32>,
        /// Index of the move.
        segment: usize,
    },
    /// A feature has a force and nothing is cut in it.
    #[error(
        "nothing is cut in the feature \"{text}\" of force_of_feature: expected a line of the program with this text"
    )]
    NoSuchFeature {
        /// The text that begins the feature.
        text: String,
    },
    /// The feed per tooth follows from the feed, and none is in force.
    #[error("no feed in force on move {}: expected one, or {key} in the process", segment + 1)]
    NoFeed {
        /// Index of the move.
        segment: usize,
        /// What the process could give instead.
        key: &'static str,
    },
    /// The feed per tooth follows from the spindle speed, and the spindle does not turn.
    #[error(
        "spindle speed {} on move {}: expected one above 0, or {key} in the process",
        rev_per_min.map_or("not given".into(), |speed| format!("{speed} rev/min")),
        segment + 1
    )]
    NoSpindleSpeed {
        /// Index of the move.
        segment: usize,
        /// The speed in force, rev/min.
        rev_per_min: Option<f64>,
        /// What the process could give instead.
        key: &'static str,
    },
}

/// The error of a wrench table that cannot be read: file, line and reason.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("{file}:{line}: {fault}")]
pub struct TableError {
    /// The file's name as given.
    pub file: String,
    /// Line in the file, from 1.
    pub line: usize,
    /// What is wrong and what was expected.
    pub fault: TableFault,
}

/// The reason why a wrench table is refused; its message says what was expected.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum TableFault {
    /// The header is not that of a wrench table.
    #[error("columns `{found}`; expected {expected}, in any order")]
    Header {
        /// The header's names.
        found: String,
        /// The names it should have.
        expected: String,
    },
    /// A row that cannot be read, of another width, or with a value that is no number.
    #[error(transparent)]
    Row(#[from] RowFault),
    /// A row that does not lie after the one before it.
    #[error("arc_length_mm = {found} after {before}; expected rows in order of increasing length")]
    Order {
        /// The length, mm.
        found: f64,
        /// The length in the row before, mm.
        before: f64,
    },
    /// Nothing to interpolate between.
    #[error("rows: {found}; expected a header and at least 2 rows")]
    TooFewRows {
        /// Number of rows.
        found: usize,
    },
}
