//! Finds parameters whose size suggests a wrong unit.

use super::{Findings, size, survey::Droop};
use crate::machine::{Machine, Parameter};

/// Factor from the median of similar parameters beyond which a parameter is questioned: a wrong unit makes 1000, honest variety up to 16.
const FAR: f64 = 60.0;
/// Fewest other parameters for a median.
const FEWEST_OTHERS: usize = 2;
/// Kinds of parameters that are compared, by the last part of their names.
const ALIKE: [&str; 4] = ["stiffness", "kg", "force_limit", "torque_limit"];
/// Range of Young's moduli of machine materials, N/mm².
const MODULI: [f64; 2] = [1e3, 1.5e6];
/// Range of gravity on Earth, m/s².
const GRAVITY: [f64; 2] = [9.76, 9.84];
/// Displacement by weight that is questioned, as a share of the machine's size.
const FAR_DROOP: f64 = 0.02;
/// Tool stiffness below which nothing can be cut, N/mm.
const SOFTEST: f64 = 1.0;

/// Returns questions about parameters that seem wrong by a factor of about a thousand.
pub(super) fn unit_questions(machine: &Machine, findings: &Findings) -> Vec<String> {
    let parameters = machine.parameters();
    let mut questions: Vec<String> = parameters.iter().filter_map(|own| odd_one_out(own, &parameters)).collect();
    questions.extend(parameters.iter().filter_map(odd_modulus));
    questions.extend(odd_gravity(machine));
    questions
        .extend(findings.survey.as_ref().and_then(|survey| survey.droop.as_ref()).and_then(|d| odd_droop(machine, d)));
    questions.extend(findings.tool_stiffness.filter(|principal| principal[0] < SOFTEST).map(|[least, ..]| {
        format!("tool stiffness: {least:.2e} N/mm is less than anything cuts with; are stiffnesses 1000 times too small (unit)?")
    }));
    questions
}

/// Returns the last part of a parameter's name, which says its kind.
fn name_kind(parameter: &Parameter) -> &str {
    parameter.name.rsplit('.').next().unwrap_or_default()
}

/// Returns a question about a parameter far from the median of others of its kind.
fn odd_one_out(own: &Parameter, all: &[Parameter]) -> Option<String> {
    let (kind, value) = (name_kind(own), own.value?);
    if !ALIKE.contains(&kind) || value == 0.0 {
        return None;
    }
    let is_alike = |other: &&Parameter| other.name != own.name && name_kind(other) == kind && other.unit == own.unit;
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

/// Returns a question about a Young's modulus that no material has.
fn odd_modulus(own: &Parameter) -> Option<String> {
    let value = own.value.filter(|_| name_kind(own) == "youngs_modulus")?;
    let [least, largest] = MODULI;
    (!(least..=largest).contains(&value)).then(|| {
        format!(
            "{} = {value:?} {}: materials have {least:e} to {largest:e}; is its unit another (GPa, Pa)?",
            own.name, own.unit
        )
    })
}

/// Returns a question about a gravity that is not that of Earth.
fn odd_gravity(machine: &Machine) -> Option<String> {
    let norm = machine.gravity.norm();
    (norm != 0.0 && machine.has_weight() && !(GRAVITY[0]..=GRAVITY[1]).contains(&norm))
        .then(|| format!("gravity_m_per_s2: the magnitude is {norm:.3} m/s², on Earth 9.81"))
}

/// Returns a question about a large displacement by weight.
fn odd_droop(machine: &Machine, droop: &Droop) -> Option<String> {
    let [_, largest] = droop.range_mm;
    (largest > FAR_DROOP * size(machine)).then(|| {
        format!(
            "weight moves the tool by {largest:.1} mm: are masses 1000 times too large (kg) or stiffnesses 1000 times too small?"
        )
    })
}
