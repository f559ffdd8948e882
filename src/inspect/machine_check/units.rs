//! Parameters whose size suggests a wrong unit.

use super::{Findings, size, survey::Droop};
use crate::machine::{Machine, Parameter};

/// A number farther than this factor from the median of the others of its kind is asked about: one that is a thousand times
/// off, and should be up to 16 times beside that median.
const FAR: f64 = 60.0;
/// Fewer others have no median worth the name.
const FEWEST_OTHERS: usize = 2;
/// What numbers of a machine are alike, by the last part of their names.
const ALIKE: [&str; 4] = ["stiffness", "kg", "force_limit", "torque_limit"];
/// Young's moduli of what machines are made of lie within, N/mm².
const MODULI: [f64; 2] = [1e3, 1.5e6];
/// The gravity of this planet lies within, m/s².
const GRAVITY: [f64; 2] = [9.76, 9.84];
/// A tool that its weight moves farther asks for a word, as a share of the machine's size.
const FAR_DROOP: f64 = 0.02;
/// A tool that is softer cuts nothing, N/mm.
const SOFTEST: f64 = 1.0;

/// Questions about numbers that look off by a factor of a thousand or more.
pub(super) fn questions(machine: &Machine, findings: &Findings) -> Vec<String> {
    let parameters = machine.parameters();
    let mut questions: Vec<String> = parameters.iter().filter_map(|own| odd_one_out(own, &parameters)).collect();
    questions.extend(parameters.iter().filter_map(modulus));
    questions.extend(gravity(machine));
    questions.extend(findings.survey.as_ref().and_then(|survey| survey.droop.as_ref()).and_then(|d| far(machine, d)));
    questions.extend(findings.tool_stiffness.filter(|principal| principal[0] < SOFTEST).map(|[least, ..]| {
        format!("tool stiffness: {least:.2e} N/mm is less than anything cuts with; are stiffnesses 1000 times too small (unit)?")
    }));
    questions
}

fn last_part(parameter: &Parameter) -> &str {
    parameter.name.rsplit('.').next().unwrap_or_default()
}

fn odd_one_out(own: &Parameter, all: &[Parameter]) -> Option<String> {
    let (kind, value) = (last_part(own), own.value?);
    if !ALIKE.contains(&kind) || value == 0.0 {
        return None;
    }
    let is_alike = |other: &&Parameter| other.name != own.name && last_part(other) == kind && other.unit == own.unit;
    let mut others: Vec<f64> =
        all.iter().filter(is_alike).filter_map(|other| other.value).filter(|v| *v != 0.0).collect();
    others.sort_by(f64::total_cmp);
    let median = others[..].get(others.len() / 2).copied().filter(|_| others.len() >= FEWEST_OTHERS)?;
    let ratio = value / median;
    let (times, size) = match ratio {
        _ if ratio > FAR => (ratio, "larger"),
        _ if ratio < 1.0 / FAR => (1.0 / ratio, "smaller"),
        _ => return None,
    };
    Some(format!(
        "{} = {value:?} {}: {times:.0} times {size} than others of its kind; is its unit another?",
        own.name, own.unit
    ))
}

fn modulus(own: &Parameter) -> Option<String> {
    let value = own.value.filter(|_| last_part(own) == "youngs_modulus")?;
    let [least, largest] = MODULI;
    (!(least..=largest).contains(&value)).then(|| {
        format!(
            "{} = {value:?} {}: materials have {least:e} to {largest:e}; is its unit another (GPa, Pa)?",
            own.name, own.unit
        )
    })
}

fn gravity(machine: &Machine) -> Option<String> {
    let norm = machine.gravity.norm();
    (norm != 0.0 && machine.has_weight() && !(GRAVITY[0]..=GRAVITY[1]).contains(&norm))
        .then(|| format!("gravity_m_per_s2: its length is {norm:.3} m/s², on Earth it is 9.81"))
}

fn far(machine: &Machine, droop: &Droop) -> Option<String> {
    let [_, largest] = droop.range_mm;
    (largest > FAR_DROOP * size(machine)).then(|| {
        format!(
            "weight moves the tool by {largest:.1} mm: are masses 1000 times too large (kg) or stiffnesses 1000 times too small?"
        )
    })
}
