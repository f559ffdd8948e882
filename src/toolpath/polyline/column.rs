//! The columns a polyline file may have.

/// A column of a polyline file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Column {
    /// Coordinate 0, 1 or 2 of the position.
    Position(usize),
    Feed,
    Spindle,
    /// Component 0, 1 or 2.
    Force(usize),
    /// Component 0, 1 or 2.
    Moment(usize),
    Cutting,
}

impl Column {
    /// Every column, in the order they are written.
    pub const ALL: [Column; 12] = [
        Column::Position(0),
        Column::Position(1),
        Column::Position(2),
        Column::Feed,
        Column::Spindle,
        Column::Force(0),
        Column::Force(1),
        Column::Force(2),
        Column::Moment(0),
        Column::Moment(1),
        Column::Moment(2),
        Column::Cutting,
    ];

    /// Its name in the header.
    pub fn name(self) -> &'static str {
        match self {
            Column::Position(axis) => ["x_mm", "y_mm", "z_mm"][axis],
            Column::Feed => "feed_mm_per_min",
            Column::Spindle => "spindle_rev_per_min",
            Column::Force(axis) => ["force_x_N", "force_y_N", "force_z_N"][axis],
            Column::Moment(axis) => ["moment_x_Nmm", "moment_y_Nmm", "moment_z_Nmm"][axis],
            Column::Cutting => "cutting",
        }
    }

    /// The column of this name.
    pub fn named(name: &str) -> Option<Column> {
        Column::ALL.into_iter().find(|column| column.name() == name)
    }

    /// The columns that must be there if this one is.
    pub fn companions(self) -> [Column; 3] {
        match self {
            Column::Position(_) => [0, 1, 2].map(Column::Position),
            Column::Force(_) => [0, 1, 2].map(Column::Force),
            Column::Moment(_) => [0, 1, 2].map(Column::Moment),
            Column::Feed | Column::Spindle | Column::Cutting => [self; 3],
        }
    }

    /// What its values must be.
    pub fn expected(self) -> &'static str {
        match self {
            Column::Position(_) => "a coordinate in mm, up to 1e6",
            Column::Feed => "a feed in mm/min, from 0 to 1e9",
            Column::Spindle => "a spindle speed in rev/min, from 0 to 1e9",
            Column::Force(_) => "a force in N, up to 1e12",
            Column::Moment(_) => "a moment in N·mm, up to 1e12",
            Column::Cutting => "0 or 1",
        }
    }

    /// The value written as `text`, if the column can hold it.
    pub fn value(self, text: &str) -> Option<f64> {
        let value = text.parse::<f64>().ok()?;
        let fits = match self {
            Column::Position(_) => value.abs() <= crate::toolpath::path::MAX_COORDINATE_MM,
            Column::Feed | Column::Spindle => (0.0..=1e9).contains(&value),
            Column::Force(_) | Column::Moment(_) => value.abs() <= 1e12,
            Column::Cutting => value == 0.0 || value == 1.0,
        };
        fits.then_some(value)
    }
}
