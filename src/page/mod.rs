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
pub use explore::{ToTry, explore_page};
pub use folder::{ResultFolder, href, relative_display};
pub use machine::DeflectedPose;
pub use machine::MachineDescription;
pub(crate) use machine::error_facts;
pub use packed::{Packed, Precision};
pub use point_command::{PointCommand, point_commands};
pub use record::{ReasonView, count_reasons};
pub(crate) use single::{ANSWER, MACHINE_AT_HOME, PORTRAIT, WORST_ANGLE};
pub use single::{page, page_with};

use crate::files::table::{columns_of_kind, correction_columns, force_columns, kind_word};
use crate::machine::{Drive, Machine};

/// Returns the quantities "largest correction" and "largest force" over the drives, apart for slides and hinges if there are both.
pub(crate) fn largest_drive_quantities(machine: &Machine) -> Vec<Quantity> {
    let name = |kind, what: &str| match machine.has_mixed_drives() {
        false => format!("largest drive {what}"),
        true => format!("largest {what} of {}", kind_word(machine, kind)),
    };
    let corrections = machine.drive_kinds().map(|kind| {
        let columns = columns_of_kind(machine, kind, correction_columns(machine));
        let words = format!("{} |Δρ|", name(kind, "correction"));
        Quantity::new(columns, &words, kind.shown_position_unit(), Better::Smaller)
    });
    let forces = machine.drive_kinds().map(|kind| {
        let columns = columns_of_kind(machine, kind, force_columns(machine));
        let words = format!("{} |τ|", name(kind, kind.force_word()));
        Quantity::new(columns, &words, kind.shown_force_unit(), Better::Smaller)
    });
    corrections.chain(forces).collect()
}

/// Name of the page in a result folder.
pub const PAGE: &str = "report.html";

/// Tag near the beginning of each page that names the program that made it.
pub const GENERATOR: &str = r#"<meta name="generator" content="kinetostat">"#;

/// Returns the quantities correction and force of each drive, with `better` as their direction.
pub(crate) fn drive_quantities(machine: &Machine, better: Better) -> Vec<Quantity> {
    let labels = machine.drive_labels();
    let drives: Vec<(&String, &Drive)> = labels.iter().zip(machine.drives().map(|(_, drive)| drive)).collect();
    let corrections = correction_columns(machine).zip(&drives).map(|(column, (label, drive))| {
        Quantity::new([column], &format!("correction of drive {label}"), drive.motion.shown_position_unit(), better)
    });
    let forces = force_columns(machine).zip(&drives).map(|(column, (label, drive))| {
        let words = format!("{} of drive {label}", drive.motion.force_word());
        Quantity::new([column], &words, drive.motion.shown_force_unit(), better)
    });
    corrections.chain(forces).collect()
}
