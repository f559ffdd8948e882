//! The sources of error in reports: in words, and as a choice on pages.

use crate::{
    files::words::join_text,
    machine::{ChainError, Machine, ZeroState},
    page::Group,
    simulation::Source,
};

/// Returns the beginning of a sentence that names the acting sources of error: "Under cutting force and chain errors".
pub(crate) fn acting_text(machine: &Machine, errors: &[ChainError], has_force: bool) -> String {
    let has_errors = errors.iter().any(|error| !error.is_none());
    let word = |source: &Source| match source {
        Source::Cutting => has_force.then_some("cutting force"),
        Source::Weight => Some(machine.own_load_text().unwrap_or("weight")),
        Source::Geometry => has_errors.then_some("chain errors"),
        Source::All => None,
    };
    match Source::parts(machine).iter().filter_map(word).collect::<Vec<_>>().as_slice() {
        [] => "With neither force nor chain errors".into(),
        text => format!("Under {}", join_text(text)),
    }
}

/// Returns on which cutting force of `size`, N, an answer rests, such as "a cutting force of up to 217 N" with "up to " as `most`.
pub(crate) fn force_text(most: &str, size: f64) -> String {
    if size > 0.0 { format!("a cutting force of {most}{size:.0} N") } else { "no cutting force".into() }
}

/// Returns the sources of error of a machine as a choice on a page, all at once first.
pub(crate) fn source_group(machine: &Machine) -> Group {
    let alone = Source::of(machine).iter().filter(|source| **source != Source::All);
    let sources = std::iter::once(&Source::All).chain(alone).map(|source| (source.label(), source.text()));
    Group::by_column("source", "source of error", sources)
}

impl Source {
    /// Returns the beginning of a sentence that says how far this source moves the tool.
    pub(crate) fn moves(self, machine: &Machine) -> String {
        let loads = machine.own_load_text().unwrap_or("weight");
        let (moves, are) = if loads == "weight" { ("moves the tool", "is") } else { ("move the tool", "are") };
        match self {
            Source::Cutting => "The cutting force alone moves the tool".into(),
            Source::Weight if machine.zeroed == ZeroState::AtRest => {
                format!("The machine's {loads}, which {are} taken as zeroed, {moves}")
            }
            Source::Weight => format!("The machine's {loads} alone {moves}"),
            Source::Geometry => "Chain errors alone move the tool".into(),
            Source::All if Self::parts(machine).len() > 2 => "All sources together move the tool".into(),
            Source::All => "Both sources together move the tool".into(),
        }
    }
}
