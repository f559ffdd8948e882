//! What pages do with results of one kind beyond what the description of a result says, declared by whoever makes these.

use super::description::Shape;

/// What pages do with results of one kind.
#[derive(Debug, Clone, Copy)]
pub struct PageKind {
    /// Shape of the view that takes the place of the first figure on a screen, for the reader to point at; `None`: the figure stays.
    pub pointed: Option<Shape>,
    /// Whether the groups of a view are sources of error, for each of which the engine in the page can be asked.
    pub has_sources: bool,
    /// Whether `kinetostat point` recomputes a node of a view.
    pub has_point_command: bool,
    /// Heading and hint of the block in which a reader asks the engine.
    pub interactive: (&'static str, &'static str),
    /// Draws by which results with uncertain inputs are held against each other.
    pub draws: Option<DrawsTable>,
}

/// A table with a row for each draw of the uncertain inputs.
#[derive(Debug, Clone, Copy)]
pub struct DrawsTable {
    /// Name of the CSV file.
    pub file: &'static str,
    /// Columns of the largest distance from the path, mm: without compensation, and with it.
    pub distances: [&'static str; 2],
}

impl PageKind {
    /// Results of which pages show what the description says.
    pub const PLAIN: Self = Self {
        pointed: None,
        has_sources: false,
        has_point_command: false,
        interactive: ("Try another place", "move the part, pull the tool, change a number: computed in this page"),
        draws: None,
    };
}
