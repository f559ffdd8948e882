//! The sources of error in answers: what acts, in words and as groups of a page, and what is gathered of each.

use crate::{
    files::words::listed,
    machine::{ChainError, Machine, Zeroed},
    page::{Group, GroupValue},
    simulation::Source,
};

/// Under what the tool moves, to begin a sentence with: "Under cutting force and chain errors".
pub(crate) fn acting(machine: &Machine, errors: &[ChainError], has_force: bool) -> String {
    let is_real = errors.iter().any(|error| !error.is_none());
    let word = |source: &Source| match source {
        Source::Cutting => has_force.then_some("cutting force"),
        Source::Weight => Some(machine.own_forces().unwrap_or("weight")),
        Source::Errors => is_real.then_some("chain errors"),
        Source::All => None,
    };
    match Source::parts(machine).iter().filter_map(word).collect::<Vec<_>>().as_slice() {
        [] => "With neither force nor chain errors".into(),
        words => format!("Under {}", listed(words)),
    }
}

/// The sources of error of a machine as a page tells them apart, all at once first.
pub(crate) fn source_group(machine: &Machine) -> Group {
    let value = |source: &Source| GroupValue { cells: vec![source.label().into()], label: source.words().into() };
    let alone = Source::of(machine).iter().filter(|source| **source != Source::All);
    Group {
        columns: vec!["source".into()],
        label: "source of error".into(),
        values: std::iter::once(&Source::All).chain(alone).map(value).collect(),
    }
}

impl Source {
    /// The beginning of a sentence that says how far the tool is moved.
    pub(crate) fn moves(self, machine: &Machine) -> String {
        let own = machine.own_forces().unwrap_or("weight");
        let moves = if own == "weight" { "moves it" } else { "move it" };
        match self {
            Source::Cutting => "The cutting force alone moves the tool".into(),
            Source::Weight if machine.zeroed == Zeroed::AtRest => {
                format!("Its {own}, which {} taken as zeroed, {moves}", if own == "weight" { "is" } else { "are" })
            }
            Source::Weight => format!("Its {own} alone {moves}"),
            Source::Errors => "Chain errors alone move it".into(),
            Source::All if Self::parts(machine).len() > 2 => "All together move it".into(),
            Source::All => "Both together move it".into(),
        }
    }
}
