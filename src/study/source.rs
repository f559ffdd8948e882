//! Sources of error.

use serde::Serialize;

/// What makes the tool leave its path.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Source {
    /// The cutting force on the nominal machine.
    Cutting,
    /// The chain errors of the unloaded real machine.
    Assembly,
    /// Both at once: the cutting force on the real machine.
    Both,
}

impl Source {
    /// All sources, in table order.
    pub const ALL: [Source; 3] = [Source::Cutting, Source::Assembly, Source::Both];

    /// Word used in tables.
    pub fn label(self) -> &'static str {
        match self {
            Source::Cutting => "cutting",
            Source::Assembly => "assembly",
            Source::Both => "both",
        }
    }
}
