//! Columns that a polyline file may have.

use std::borrow::Cow;

/// Begin of the name of an external axis column; its end is one of [`UNITS`].
const EXTERNAL: &str = "external_";
const UNITS: [&str; 2] = ["_mm", "_deg"];

/// Names of external axis columns, in words.
pub(crate) const EXTERNAL_WORDS: &str = "external_DRIVE_mm or external_DRIVE_deg";

/// A column of a polyline file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Column {
    /// Coordinate 0, 1 or 2 of the position.
    Position(usize),
    Feed,
    Spindle,
    /// Component 0, 1 or 2 of the force on the tool.
    Force(usize),
    /// Component 0, 1 or 2 of the moment on the tool.
    Moment(usize),
    /// Component 0, 1 or 2 of the direction of the tool's axis.
    ToolAxis(usize),
    /// Component w, x, y or z of the platform's orientation.
    Platform(usize),
    /// The k-th external axis of the file.
    External(usize),
    Cutting,
}

impl Column {
    /// Iterates over all columns but external axes, in the order they are written.
    pub fn all() -> impl Iterator<Item = Column> {
        let vector = |component: fn(usize) -> Column| (0..3).map(component);
        let driven =
            [Column::Feed, Column::Spindle].into_iter().chain(vector(Column::Force)).chain(vector(Column::Moment));
        let orientation = vector(Column::ToolAxis).chain((0..4).map(Column::Platform));
        vector(Column::Position).chain(driven).chain(orientation).chain([Column::Cutting])
    }

    /// Returns the name of the column in the header of a file with the external axes `external`.
    pub fn name(self, external: &[String]) -> Cow<'static, str> {
        match self {
            Column::Position(axis) => ["x_mm", "y_mm", "z_mm"][axis].into(),
            Column::Feed => "feed_mm_per_min".into(),
            Column::Spindle => "spindle_rev_per_min".into(),
            Column::Force(axis) => ["force_x_N", "force_y_N", "force_z_N"][axis].into(),
            Column::Moment(axis) => ["moment_x_Nmm", "moment_y_Nmm", "moment_z_Nmm"][axis].into(),
            Column::ToolAxis(axis) => ["axis_x", "axis_y", "axis_z"][axis].into(),
            Column::Platform(entry) => ["platform_qw", "platform_qx", "platform_qy", "platform_qz"][entry].into(),
            Column::External(index) => external[index].clone().into(),
            Column::Cutting => "cutting".into(),
        }
    }

    /// Returns the column called `name`; a new external axis is added to `external`. `None` if there is no such column.
    pub fn from_name(name: &str, external: &mut Vec<String>) -> Option<Column> {
        let drive = name.strip_prefix(EXTERNAL).and_then(|rest| UNITS.iter().find_map(|unit| rest.strip_suffix(unit)));
        if drive.is_some_and(|drive| !drive.is_empty()) {
            let known = external.iter().position(|known_name| known_name == name).unwrap_or(external.len());
            if known == external.len() {
                external.push(name.to_owned());
            }
            return Some(Column::External(known));
        }
        Column::all().find(|column| column.name(&[]) == name)
    }

    /// Returns the columns, this one included, that a file with this column must have.
    pub fn companions(self) -> Vec<Column> {
        match self {
            Column::Position(_) => (0..3).map(Column::Position).collect(),
            Column::Force(_) => (0..3).map(Column::Force).collect(),
            Column::Moment(_) => (0..3).map(Column::Moment).collect(),
            Column::ToolAxis(_) => (0..3).map(Column::ToolAxis).collect(),
            Column::Platform(_) => (0..4).map(Column::Platform).collect(),
            Column::Feed | Column::Spindle | Column::External(_) | Column::Cutting => vec![self],
        }
    }

    /// Describes what the values of the column must be, for messages.
    pub fn expected(self) -> &'static str {
        match self {
            Column::Position(_) => "a coordinate in mm, up to 1e6",
            Column::Feed => "a feed in mm/min, from 0 to 1e9",
            Column::Spindle => "a spindle speed in rev/min, from 0 to 1e9",
            Column::Force(_) => "a force in N, up to 1e12",
            Column::Moment(_) => "a moment in N·mm, up to 1e12",
            Column::ToolAxis(_) => "a component of a direction, up to 1e6",
            Column::Platform(_) => "an entry of a quaternion, from -1.001 to 1.001",
            Column::External(_) => "a position of a drive in mm or degrees, up to 1e6",
            Column::Cutting => "0 or 1",
        }
    }

    /// Parses `text` as a value of the column; `None` if the column cannot hold it.
    pub fn parse(self, text: &str) -> Option<f64> {
        let value = text.parse::<f64>().ok()?;
        let fits = match self {
            Column::Platform(_) => value.abs() <= 1.001,
            Column::Position(_) | Column::ToolAxis(_) | Column::External(_) => {
                value.abs() <= crate::model::path::MAX_COORDINATE_MM
            }
            Column::Feed | Column::Spindle => (0.0..=1e9).contains(&value),
            Column::Force(_) | Column::Moment(_) => value.abs() <= 1e12,
            Column::Cutting => value == 0.0 || value == 1.0,
        };
        fits.then_some(value)
    }
}
