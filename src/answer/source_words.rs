//! Which sources of error act, in words.

use crate::simulation::Source;
use crate::{
    files::words::listed,
    machine::{ChainError, Machine},
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
