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

use super::table::{correction_columns, force_columns, force_unit, position_unit};
use crate::{compensation::Target, machine::Machine};

/// Correction and force of each drive.
pub(super) fn drive_quantities(machine: &Machine, better: Better) -> Vec<Quantity> {
    let labels = machine.drive_labels();
    let corrections = correction_columns(machine).zip(&labels).map(|(column, label)| {
        Quantity::new([column], &format!("correction of drive {label}"), position_unit(machine), better)
    });
    let forces = force_columns(machine).zip(&labels).map(|(column, label)| {
        Quantity::new([column], &format!("force of drive {label}"), force_unit(machine), better)
    });
    corrections.chain(forces).collect()
}

/// What compensation puts right, in words.
pub(super) fn target_words(target: Target) -> &'static str {
    match target {
        Target::ToolTip => "position of the tool tip T",
        Target::PlatformPoint => "position of the platform point P",
        Target::FullPose => "position of the tool tip T and orientation of the platform",
    }
}
