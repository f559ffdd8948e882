//! Files with the identified parameters: the machine file with values and provenance changed, and a process file with chain errors.

use nalgebra::Vector3;
use serde::Serialize;
use toml_edit::{ArrayOfTables, DocumentMut, Item, Table, Value, value};

use super::{
    Estimate, IdentificationStudy, Identified,
    validate::{residual_share, rms_mm},
};
use crate::{
    files::words::{counted, join_text, millimetres, percent},
    input::{Folder, error::Result},
    machine::{Chain, ChainError, Machine},
    process::{Process, file::chain_errors::ChainErrorSpec},
};

/// A machine file with the identified parameters, and those that have no key in it: chain errors, which belong to a process.
pub(super) struct MachineFile {
    /// Text of the file; `None` if no identified parameter has a key in it.
    pub text: Option<String>,
    /// Names of identified parameters that are not in it.
    pub left_out: Vec<String>,
    /// Why there is no text although something was identified.
    pub problem: Option<String>,
}

impl MachineFile {
    /// Makes the result that no machine file is written, and why: no parameter has a key in it, or there was a `problem`.
    fn unwritten(left_out: Vec<String>, problem: Option<String>) -> Self {
        Self { text: None, left_out, problem }
    }
}

/// Last parts of parameter names and the index of the component of a vector or interval that they mean.
const COMPONENTS: [(&str, usize); 5] = [("x", 0), ("y", 1), ("z", 2), ("min", 0), ("max", 1)];
/// Last parts of parameter names that mean rows and columns of a 6×6 matrix, in order.
const ROWS: [&str; 6] = ["x", "y", "z", "rx", "ry", "rz"];

/// Writes the identified values and their provenance into the text of the study's machine file, and checks it by reading it back.
pub(super) fn write_machine(study: &IdentificationStudy, results: &Identified) -> MachineFile {
    let mut document = match study.machine_text.parse::<DocumentMut>() {
        Ok(document) => document,
        Err(fault) => {
            let names = results.estimates.iter().map(|estimate| estimate.unknown.name.clone()).collect();
            return MachineFile::unwritten(names, Some(fault.to_string()));
        }
    };
    provenance_as_tables(&mut document);
    let (mut written, mut left_out) = (Vec::new(), Vec::new());
    for estimate in results.estimates.iter().filter(|estimate| estimate.open.is_none()) {
        let name = &estimate.unknown.name;
        let key = study.machine.parameter(name).ok().and_then(|parameter| parameter.key);
        // What was written is read back below.
        match key.is_some_and(|key| set_number(document.as_item_mut(), &key, name, estimate.value).is_some()) {
            true => written.push(estimate),
            false => left_out.push(name.clone()),
        }
    }
    if written.is_empty() {
        return MachineFile::unwritten(left_out, None);
    }
    for estimate in &written {
        remove_provenance(&mut document, &estimate.unknown.name);
        add_provenance(&mut document, study, results, estimate);
    }
    // Where the schema lies is true of the file that this one is made of.
    let text: String =
        document.to_string().split_inclusive('\n').filter(|line| !line.starts_with("#:schema")).collect();
    let read_back = Machine::from_toml(&text, "the machine file that was found");
    let is_kept = |estimate: &&&Estimate| {
        let back = read_back.as_ref().ok().and_then(|machine| machine.parameter(&estimate.unknown.name).ok()?.value);
        back == Some(estimate.value)
    };
    let lost: Vec<String> =
        written.iter().filter(|estimate| !is_kept(estimate)).map(|estimate| estimate.unknown.name.clone()).collect();
    if lost.is_empty() {
        return MachineFile { text: Some(text), left_out, problem: None };
    }
    let problem = match &read_back {
        Err(fault) => fault.to_string(),
        Ok(_) => format!("{} would not be read back as it was found", lost.join(", ")),
    };
    let all = [left_out, written.iter().map(|estimate| estimate.unknown.name.clone()).collect()].concat();
    MachineFile::unwritten(all, Some(problem))
}

/// Sets the number of the parameter `name` at `key`, such as `chain[0].elements[2].beam.length_mm`; `None` if there is no such number.
fn set_number(document: &mut Item, key: &str, name: &str, number: f64) -> Option<()> {
    let mut item = document;
    for part in key.split('.') {
        let (word, indices) = part.split_once('[').map_or((part, None), |(word, rest)| (word, Some(rest)));
        item = item.get_mut(word)?;
        for index in indices.into_iter().flat_map(|rest| rest.split('[')) {
            item = item.get_mut(index.trim_end_matches(']').parse::<usize>().ok()?)?;
        }
    }
    let last = name.rsplit('.').next()?;
    if item.as_array().is_none() {
        *item.as_value_mut()? = with_decor(item.as_value()?, number);
        return Some(());
    }
    if let Some((_, index)) = COMPONENTS.iter().find(|(word, _)| *word == last) {
        let entry = item.get_mut(*index)?;
        *entry.as_value_mut()? = with_decor(entry.as_value()?, number);
        return Some(());
    }
    let (row, column) = last.split_once('_')?;
    let place = |word: &str| ROWS.iter().position(|row| *row == word);
    let (row, column) = (place(row)?, place(column)?);
    for (i, j) in [(row, column), (column, row)] {
        let entry = item.get_mut(i)?.get_mut(j)?;
        *entry.as_value_mut()? = with_decor(entry.as_value()?, number);
    }
    Some(())
}

/// Returns `number` as a TOML value with the blanks and comments around `old`.
fn with_decor(old: &Value, number: f64) -> Value {
    let mut new = Value::from(number);
    *new.decor_mut() = old.decor().clone();
    new
}

/// Turns provenance that is written as an inline list into tables, to which others can be appended.
fn provenance_as_tables(document: &mut DocumentMut) {
    if let Some(item) = document.remove("provenance") {
        let item = item.into_array_of_tables().map_or_else(|item| item, Item::ArrayOfTables);
        document.insert("provenance", item);
    }
}

/// Removes the parameter `name` from the provenance tables, and tables that are then of no parameter.
fn remove_provenance(document: &mut DocumentMut, name: &str) {
    let Some(tables) = document.get_mut("provenance").and_then(Item::as_array_of_tables_mut) else { return };
    let mut emptied = Vec::new();
    for (number, table) in tables.iter_mut().enumerate() {
        if let Some(names) = table.get_mut("parameters").and_then(Item::as_array_mut) {
            let before = names.len();
            names.retain(|listed| listed.as_str() != Some(name));
            if names.is_empty() && before > 0 {
                emptied.push(number);
            }
        }
    }
    for number in emptied.into_iter().rev() {
        tables.remove(number);
    }
}

/// Describes the residual of the fit in words: against the given noise, or against the measured lengths.
fn misfit_text(study: &IdentificationStudy, results: &Identified) -> String {
    let fit = &results.fit;
    if !study.noise.is_estimated {
        let widened = if fit.scale > 1.0 { ", and the interval is wider by it" } else { "" };
        return format!("the residual is {:.2} times the noise that was given{widened}", fit.scale);
    }
    let residual = rms_mm(fit.residuals.as_slice(), &study.measurements);
    let residual = residual.map_or_else(|| "nothing".into(), |residual| format!("{} RMS", millimetres(residual, 4)));
    let share = residual_share(fit.residuals.as_slice(), &study.measurements, &[]);
    let share = share.map_or_else(String::new, |share| format!(", {} of what was measured", percent(share)));
    format!("the residual is {residual}{share}, and is in the interval")
}

/// Describes in a sentence the residual of a machine file with only some of the fitted parameters; `None` where it has all or none.
pub(super) fn partial_text(study: &IdentificationStudy, results: &Identified) -> Option<String> {
    let partial = results.partial.as_ref()?;
    let names: Vec<&str> = partial.unidentified.iter().map(|&k| &*study.unknowns[k].name).collect();
    let (are, they) = if names.len() == 1 { ("is", "it is") } else { ("are", "they are") };
    let rest = format!("{} {are} not identified, and {they} in the file as before", join_text(&names));
    let full = rms_mm(results.fit.residuals.as_slice(), &study.measurements);
    Some(match (&partial.residual_mm, full) {
        (Ok(Some(partial)), Some(full)) => {
            format!(
                "{rest}: so the machine leaves {} RMS, with all parameters as fitted {}.",
                millimetres(*partial, 3),
                millimetres(full, 3)
            )
        }
        (Ok(_), _) => format!("{rest}, with which what was identified was not fitted."),
        (Err(failure), _) => format!("{rest}: so the machine is not solved: {}.", failure.reason.trim_end_matches('.')),
    })
}

/// Appends a provenance table that says from what `estimate` was identified, with its interval and former value.
fn add_provenance(document: &mut DocumentMut, study: &IdentificationStudy, results: &Identified, estimate: &Estimate) {
    let mut table = Table::new();
    let unit = estimate.unknown.unit;
    table["what"] = value(estimate.unknown.name.as_str());
    table["grade"] = value("identified");
    let measurements = counted(study.measurements.len(), "measurement");
    let before = format!("{:e} {unit}", estimate.unknown.start);
    let partial =
        partial_text(study, results).map_or_else(String::new, |text| format!("; {}", text.trim_end_matches('.')));
    table["source"] = value(format!(
        "Identified from {measurements} in {}; {}{partial}; before: {}",
        study.data,
        misfit_text(study, results),
        before.trim_end()
    ));
    let mut names = toml_edit::Array::new();
    names.push(estimate.unknown.name.as_str());
    table["parameters"] = value(names);
    table["interval"] = value(toml_edit::Array::from_iter(estimate.interval));
    let provenance = document.entry("provenance").or_insert(Item::ArrayOfTables(ArrayOfTables::new()));
    if let Some(tables) = provenance.as_array_of_tables_mut() {
        tables.push(table);
    }
}

/// TOML text of one chain's errors in a process file.
#[derive(Serialize)]
struct ChainErrorTables {
    chain_error: [ChainErrorSpec; 1],
}

/// Writes a process file of the identified chain errors, which have no key in machine files, and returns its text and the names of the
/// parameters in it; `None` if there are none, `Err` if the file is not valid, such as for an error that is too large.
pub(super) fn write_errors(study: &IdentificationStudy, results: &Identified) -> Result<Option<(String, Vec<String>)>> {
    let mut text = format!(
        "# Errors of chains, identified from {}: a process file, or tables to copy into one.\nschema = 1\n",
        study.data
    );
    let mut written = Vec::new();
    for chain in &study.machine.chains {
        let errors = chain_estimates(&study.machine, chain, results);
        if errors.is_empty() {
            continue;
        }
        text += &format!("\n{}", chain_error_toml(chain, &errors));
        for estimate in &errors {
            let [low, high] = estimate.interval;
            text += &format!(
                "# {}: 95 % interval {low:.4e} to {high:.4e} {}\n",
                estimate.unknown.name, estimate.unknown.unit
            );
        }
        written.extend(errors.iter().map(|estimate| estimate.unknown.name.clone()));
    }
    if written.is_empty() {
        return Ok(None);
    }
    Process::from_toml(&text, "errors of chains as they were identified", Folder::in_memory([]), &study.machine)?;
    Ok(Some((text, written)))
}

/// Returns the identified errors of `chain`: parameters that have no key in the machine file.
fn chain_estimates<'a>(machine: &Machine, chain: &Chain, results: &'a Identified) -> Vec<&'a Estimate> {
    let identified = results.estimates.iter().filter(|estimate| estimate.open.is_none());
    let is_of_chain = |name: &str| name.strip_prefix(&chain.name).is_some_and(|behind| behind.starts_with('.'));
    let has_no_key = |name: &str| machine.parameter(name).is_ok_and(|parameter| parameter.key.is_none());
    identified.filter(|estimate| is_of_chain(&estimate.unknown.name) && has_no_key(&estimate.unknown.name)).collect()
}

/// Returns the TOML table of the identified errors of a chain; components of vectors that were not identified are 0.
fn chain_error_toml(chain: &Chain, errors: &[&Estimate]) -> String {
    let value = |behind: &str| {
        let name = format!("{}.{behind}", chain.name);
        errors.iter().find(|estimate| estimate.unknown.name == name).map(|estimate| estimate.value)
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
    toml::to_string(&ChainErrorTables { chain_error: [spec] }).expect("names and numbers can be written")
}
