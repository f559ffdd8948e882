//! The process file with the errors of chains that were found: machine files have no place for them.

use super::{Found, IdentificationStudy, Identified};
use crate::{
    input::{Folder, error::Result},
    machine::Chain,
    process::Process,
};

/// Keys of `[[chain_error]]` that are vectors, and what the names of their parameters begin with behind the chain.
const VECTORS: [(&str, &str); 4] = [
    ("base_translation_mm", "base.translation"),
    ("base_rotation_deg", "base.turn"),
    ("end_translation_mm", "end.translation"),
    ("end_rotation_deg", "end.turn"),
];
const TURN: (&str, &str) = ("turn_about_drive_axis_deg", "turn");
const OFFSETS: &str = "drive_offsets_mm_or_deg";

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
        let errors = of_chain(chain, found);
        if errors.is_empty() {
            continue;
        }
        text += &format!("\n[[chain_error]]\nchain = {:?}\n", chain.name);
        let value = |behind: &str| {
            let name = format!("{}.{behind}", chain.name);
            errors.iter().find(|own| own.unknown.name == name).map(|own| own.value)
        };
        if let Some(turn) = value(TURN.1) {
            text += &format!("{} = {turn:?}\n", TURN.0);
        }
        for (key, behind) in VECTORS {
            let components = ["x", "y", "z"].map(|axis| value(&format!("{behind}.{axis}")));
            if components.iter().any(Option::is_some) {
                text += &format!("{key} = {:?}\n", components.map(Option::unwrap_or_default));
            }
        }
        let offsets: Vec<Option<f64>> =
            chain.drives.iter().map(|drive| value(&format!("{}.offset", drive.name))).collect();
        if offsets.iter().any(Option::is_some) {
            let offsets: Vec<f64> = offsets.into_iter().map(Option::unwrap_or_default).collect();
            text += &format!("{OFFSETS} = {offsets:?}\n");
        }
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

/// What was identified of the errors of `chain`.
fn of_chain<'a>(chain: &Chain, found: &'a Identified) -> Vec<&'a Found> {
    let vectors = VECTORS.iter().flat_map(|(_, behind)| ["x", "y", "z"].map(|axis| format!("{behind}.{axis}")));
    let offsets = chain.drives.iter().map(|drive| format!("{}.offset", drive.name));
    let names: Vec<String> = std::iter::once(TURN.1.to_string())
        .chain(vectors)
        .chain(offsets)
        .map(|behind| format!("{}.{behind}", chain.name))
        .collect();
    let identified = found.found.iter().filter(|own| own.open.is_none());
    identified.filter(|own| names.contains(&own.unknown.name)).collect()
}
