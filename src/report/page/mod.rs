//! The answer as one HTML file: everything a result folder says, readable without this program or a network.
//!
//! [`Description`] is what a run leaves beside its tables; [`ResultFolder`] reads both back; [`page()`] makes a report of one
//! folder and [`comparison()`] of several.

mod address;
mod columns;
mod common;
mod compared;
mod comparison;
mod dataset;
mod description;
mod folder;
mod machine;
mod nodes;
mod packed;
mod record;
mod single;
mod table;
mod template;
mod wins;

pub use comparison::comparison;
pub use description::{
    Better, Column, Description, Explorer, Fact, FigureNote, Group, GroupValue, Mark, Quantity, SCHEMA, Shape,
    TableNote,
};
pub use folder::ResultFolder;
pub use machine::MachineDescription;
pub(super) use machine::error_facts;
pub use single::{MACHINE_AT_HOME, page};

use crate::compensation::Target;

/// What compensation puts right, in words.
pub(super) fn target_words(target: Target) -> &'static str {
    match target {
        Target::ToolTip => "position of the tool tip T",
        Target::PlatformPoint => "position of the platform point P",
        Target::FullPose => "position of the tool tip T and orientation of the platform",
    }
}
