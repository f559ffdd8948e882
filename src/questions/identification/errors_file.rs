//! The process file with the errors of chains that were found: machine files have no place for them.

use nalgebra::Vector3;
use serde::Serialize;

use super::{Found, IdentificationStudy, Identified};
use crate::{
    input::{Folder, error::Result},
    machine::{Chain, ChainError, Machine},
    process::{Process, file::chain_errors::ChainErrorSpec},
};

#[derive(Serialize)]
struct Tables {
    chain_error: [ChainErrorSpec; 1],
}

/// The text of the file, and the names of what stands in it; `None` where none of what was identified is an error of a chain.
///
/// # Errors
/// The process that was written is none: an error too large to be one.
pub(super) fn write(study: &IdentificationStudy, found: &Identified) -> Result<Option<(String, Vec<String>)>> {
    let mut text = format!(
        "# Errors of chains, identified from {}: a process file, or tables to copy into one.\nschema = 1\n",
        study.data
    );
    let mut written = Vec::new();
    for chain in &study.machine.chains {
        let errors = of_chain(&study.machine, chain, found);
        if errors.is_empty() {
            continue;
        }
        text += &format!("\n{}", tables(chain, &errors));
        for own in &errors {
            let [low, high] = own.interval;
            text += &format!(
                "# {}: 95 % interval {low:.4e} to {high:.4e} {}
",
                own.unknown.name, own.unknown.unit
            );
        }
        written.extend(errors.iter().map(|own| own.unknown.name.clone()));
    }
    if written.is_empty() {
        return Ok(None);
    }
    Process::from_toml(&text, "errors of chains as they were identified", Folder::in_memory([]), &study.machine)?;
    Ok(Some((text, written)))
}

/// What was identified of the errors of `chain`: numbers that the machine file has no key for.
fn of_chain<'a>(machine: &Machine, chain: &Chain, found: &'a Identified) -> Vec<&'a Found> {
    let identified = found.found.iter().filter(|own| own.open.is_none());
    let is_of_chain = |name: &str| name.strip_prefix(&chain.name).is_some_and(|behind| behind.starts_with('.'));
    let has_no_key = |name: &str| machine.parameter(name).is_ok_and(|own| own.key.is_none());
    identified.filter(|own| is_of_chain(&own.unknown.name) && has_no_key(&own.unknown.name)).collect()
}

/// The same as a table of the file; what was not sought beside it in a vector is zero.
fn tables(chain: &Chain, errors: &[&Found]) -> String {
    let value = |behind: &str| {
        let name = format!("{}.{behind}", chain.name);
        errors.iter().find(|own| own.unknown.name == name).map(|own| own.value)
    };
    let vector = |behind: &str| {
        let components = ["x", "y", "z"].map(|axis| value(&format!("{behind}.{axis}")));
        components.iter().any(Option::is_some).then(|| components.map(Option::unwrap_or_default))
    };
    // A file has either: a turn is added to the base's as a rotation vector, as parameters are.
    let about_drive = |turn: f64| ChainError::turn_about_drive_axis(chain, turn.to_radians()).base.angular;
    let (turn, base) = match (value("turn"), vector("base.turn")) {
        (Some(turn), Some(base)) => (None, Some((Vector3::from(base) + about_drive(turn).map(f64::to_degrees)).into())),
        either => either,
    };
    let offsets: Vec<Option<f64>> = chain.drives.iter().map(|drive| value(&format!("{}.offset", drive.name))).collect();
    let has_offsets = offsets.iter().any(Option::is_some);
    let spec = ChainErrorSpec {
        chain: chain.name.clone(),
        turn_about_drive_axis_deg: turn,
        base_translation_mm: vector("base.translation"),
        base_rotation_deg: base,
        end_translation_mm: vector("end.translation"),
        end_rotation_deg: vector("end.turn"),
        drive_offsets_mm_or_deg: has_offsets.then(|| offsets.into_iter().map(Option::unwrap_or_default).collect()),
    };
    toml::to_string(&Tables { chain_error: [spec] }).expect("names and numbers can be written")
}
