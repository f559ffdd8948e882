//! Results, or a comparison of results, as one HTML file that needs no network: everything result folders say.
//!
//! A run leaves a [`Description`]; [`ResultFolder`] reads it; [`page()`] makes a report of one folder, [`comparison()`] of several.

mod aligned;
mod compared;
mod comparison;
pub mod dataset;
mod description;
mod drawn;
mod explore;
mod folder;
pub mod headline;
mod kind;
mod machine;
mod of_parts;
mod packed;
mod picture;
mod point_command;
mod record;
mod sentences;
mod single;
pub mod table;
mod template;
mod verdict;
pub mod winners;

pub use comparison::{Comparison, comparison};
pub use description::{
    Better, Column, Description, Explorer, Fact, FigureNote, Group, GroupValue, Mark, PartView, Quantity, Section,
    Shape, SmallTable, TableNote,
};
pub use explore::{Interactive, explore_page};
pub use folder::{ResultFolder, href, relative_display};
pub use kind::{DrawsTable, PageKind};
pub use machine::DeflectedPose;
pub use machine::MachineDescription;
pub use packed::{Packed, Precision};
pub use point_command::{PointCommand, point_commands};
pub use record::{ReasonView, count_reasons};
pub(crate) use single::{ANSWER, MACHINE_AT_HOME, PORTRAIT, WORST_ANGLE};
pub use single::{page, page_with};

/// Name of the page in a result folder.
pub const PAGE: &str = "report.html";

/// Tag near the beginning of each page that names the program that made it.
pub const GENERATOR: &str = r#"<meta name="generator" content="kinetostat">"#;
