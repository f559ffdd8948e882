//! The sources of error as a page tells them apart.

use crate::{
    machine::Machine,
    page::{Group, GroupValue},
    simulation::Source,
};

/// The sources of error of a machine, all at once first.
pub(crate) fn source_group(machine: &Machine) -> Group {
    let value = |source: &Source| GroupValue { cells: vec![source.label().into()], label: source.words().into() };
    let alone = Source::of(machine).iter().filter(|source| **source != Source::All);
    Group {
        columns: vec!["source".into()],
        label: "source of error".into(),
        values: std::iter::once(&Source::All).chain(alone).map(value).collect(),
    }
}
