//! Finds parameters whose size suggests a wrong unit.

use std::f64::consts::TAU;

use super::{Findings, machine_size, survey::Droop};
use crate::machine::{Machine, Parameter, Unit};

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
/// Length of which nothing in a machine is the longest, mm.
const TINY_MM: f64 = 10.0;
/// Length, mm and as a share of the machine's size, below which a link or a tool may be in metres.
const SHORT_MM: f64 = 5.0;
const SHORT: f64 = 0.005;
/// Shares of the machine's size between which a length of links, tool or workspace is.
const LENGTHS: [f64; 2] = [0.02, 5.0];
/// Mass that no part of a machine has, kg, and that of a block of steel, kg/mm³.
const HEAVIEST_KG: f64 = 1e5;
const STEEL_KG_PER_MM3: f64 = 7.85e-6;
/// Stiffness below which slides with a screw or a linear motor are not, N/mm; in N/µm they have this number and less.
const SOFT_SLIDE: f64 = 500.0;

/// Returns questions about parameters that seem wrong by a factor of about a thousand.
pub(super) fn unit_questions(machine: &Machine, findings: &Findings, parameters: &[Parameter]) -> Vec<String> {
    let mut questions: Vec<String> =
        parameters.iter().filter_map(|param| odd_one_out(machine, param, parameters)).collect();
    questions.extend(parameters.iter().filter_map(|param| odd_modulus(machine, param)));
    questions.extend(parameters.iter().filter_map(|param| soft_slide(machine, param)));
    questions.extend(odd_gravity(machine));
    questions
        .extend(findings.survey.as_ref().and_then(|survey| survey.droop.as_ref()).and_then(|d| odd_droop(machine, d)));
    questions.extend(findings.tool_stiffness.filter(|principal| principal[0] < SOFTEST).map(|[least, ..]| {
        format!("tool stiffness: {least:.2e} N/mm is less than anything cuts with; are stiffnesses 1000 times too small (unit)?")
    }));
    questions
}

/// Returns the last part of a parameter's name, which says its kind, such as `stiffness`.
fn name_kind(parameter: &Parameter) -> &str {
    parameter.name.rsplit('.').next().unwrap_or_default()
}

/// Returns questions about lengths, masses and angles that seem to be in another unit.
pub(super) fn geometry_questions(machine: &Machine, findings: &Findings, parameters: &[Parameter]) -> Vec<String> {
    let in_file: Vec<&Parameter> = parameters.iter().filter(|param| param.key.is_some()).collect();
    let is_length = |param: &&&Parameter| param.unit == Unit::MM && param.value.is_some_and(|value| value != 0.0);
    let longest = in_file.iter().filter(is_length).max_by(|a, b| value_of(a).abs().total_cmp(&value_of(b).abs()));
    if let Some(longest) = longest.filter(|param| value_of(param).abs() < TINY_MM) {
        return vec![format!("{}: no length is larger; are lengths in metres?", shown(machine, longest))];
    }
    let mut questions: Vec<String> = in_file.iter().filter_map(|param| short_link(machine, param, &in_file)).collect();
    // The components of a vector, and the ends of intervals, have the key in common.
    for same_key in in_file.chunk_by(|a, b| a.key == b.key) {
        questions.extend(short_offset(machine, same_key));
        questions.extend(small_travel(machine, same_key, findings));
    }
    questions.extend(small_workspace(machine));
    questions.extend(in_file.iter().filter_map(|param| huge_mass(machine, param)));
    questions
}

/// Returns the value of a parameter; not a number where it is unknown.
fn value_of(param: &Parameter) -> f64 {
    param.value.unwrap_or(f64::NAN)
}

/// Returns a parameter in words: name, value, unit, key and line of the machine file.
fn shown(machine: &Machine, param: &Parameter) -> String {
    format!("{} = {:?} {}{}", param.name, value_of(param), param.unit, place_in_file(machine, param))
}

/// Returns key and line of a parameter in the machine file, in words in brackets; empty where it has no key.
fn place_in_file(machine: &Machine, param: &Parameter) -> String {
    let Some(key) = &param.key else { return String::new() };
    let line = machine.line_of(key).map_or_else(String::new, |line| format!(", line {line}"));
    format!(" ({key}{line})")
}

/// Returns whether `length`, mm, is next to none in this machine but would fit it if it were in metres.
fn may_be_metres(machine: &Machine, length: f64) -> bool {
    let (size, [least, largest]) = (machine_size(machine), LENGTHS);
    length > 0.0 && length < SHORT_MM.min(SHORT * size) && (least * size..=largest * size).contains(&(1e3 * length))
}

/// Returns a question about a link or a cutter of next to no length, unless it is known to be as long as thick; else `None`.
fn short_link(machine: &Machine, own: &Parameter, all: &[&Parameter]) -> Option<String> {
    let (element, kind) = own.name.rsplit_once('.')?;
    if !["length", "advance", "stick_out"].contains(&kind) || !may_be_metres(machine, own.value?) {
        return None;
    }
    let is_akin = |other: &&&Parameter| {
        other.unit == Unit::MM
            && other
                .name
                .rsplit_once('.')
                .is_some_and(|(of, kind)| of == element && !["length", "advance"].contains(&kind))
    };
    let is_flexure = all.iter().filter(is_akin).any(|other| other.name != own.name && value_of(other) <= value_of(own));
    (!is_flexure).then(|| format!("{}: is it in metres?", shown(machine, own)))
}

/// Returns a question about a translation or a tool tip, given by its components to three decimals at most, that is next to none; else `None`.
fn short_offset(machine: &Machine, components: &[&Parameter]) -> Option<String> {
    let (first, key) = (components.first()?, components.first()?.key.as_ref()?);
    let length = components.iter().map(|param| value_of(param).powi(2)).sum::<f64>().sqrt();
    let is_offset = key.ends_with("translation_mm") || key.ends_with("tool_tip_mm");
    // Measured offsets of a fraction of a millimetre have more digits.
    let is_round = components.iter().all(|param| !has_more_decimals(value_of(param), 3));
    (is_offset && is_round && may_be_metres(machine, length)).then(|| {
        let name = first.name.trim_end_matches(".x");
        format!("{name}: {length:.3} mm long{}: is it in metres?", place_in_file(machine, first))
    })
}

/// Returns whether `value` has more than `count` digits behind the point.
fn has_more_decimals(value: f64, count: i32) -> bool {
    let scaled = value * 10f64.powi(count);
    (scaled - scaled.round()).abs() > 1e-9 * scaled.abs().max(1.0)
}

/// Returns a question about a revolute joint whose travel or limits, given by their `ends` in degrees, fit in a turn in radians: it is asked where
/// they have decimals as angles in degrees seldom have, or where a place is not reached; else `None`.
fn small_travel(machine: &Machine, ends: &[&Parameter], findings: &Findings) -> Option<String> {
    let (first, key) = (ends.first()?, ends.first()?.key.as_ref()?);
    let is_travel = key.ends_with("travel_deg") || key.ends_with("limits_deg");
    let is_small = ends.iter().all(|end| value_of(end).abs() < 1.001 * TAU);
    let is_odd = ends.iter().any(|end| has_more_decimals(value_of(end), 1));
    let is_short = || findings.reached.iter().any(|(_, _, reached)| reached.is_err());
    (is_travel && is_small && (is_odd || is_short())).then(|| {
        let name = first.name.trim_end_matches(".min");
        let ends: Vec<String> = ends.iter().map(|end| format!("{:?}°", value_of(end))).collect();
        format!("{name}: {}{}: is it in radians?", ends.join(" to "), place_in_file(machine, first))
    })
}

/// Returns a question about a workspace that is next to a point, else `None`.
fn small_workspace(machine: &Machine) -> Option<String> {
    let diagonal = (machine.workspace.max - machine.workspace.min).norm();
    may_be_metres(machine, diagonal).then(|| {
        let line = machine.line_of("workspace").map_or_else(String::new, |line| format!(" (line {line})"));
        format!("workspace: its diagonal is {diagonal:.3} mm{line}: is it in metres?")
    })
}

/// Returns a question about a mass larger than that of a block of steel of the machine's size, else `None`.
fn huge_mass(machine: &Machine, own: &Parameter) -> Option<String> {
    let heaviest = (STEEL_KG_PER_MM3 * machine_size(machine).powi(3)).min(HEAVIEST_KG);
    (own.unit == Unit::KG && own.value? > heaviest).then(|| {
        format!("{}: no part of such a machine is heavier than {heaviest:.0} kg; is it in grams?", shown(machine, own))
    })
}

/// Returns a question about a prismatic joint too soft for a screw or a linear motor, else `None`.
fn soft_slide(machine: &Machine, param: &Parameter) -> Option<String> {
    let is_slide = param.key.as_ref()?.contains("prismatic_drive.") && param.unit == Unit::N_PER_MM;
    (is_slide && param.value? <= SOFT_SLIDE).then(|| {
        format!("{}: drives of prismatic joints have more; is it in N/µm (1 N/µm = 1000 N/mm)?", shown(machine, param))
    })
}

/// Returns a question about a parameter far from the median of others of its kind; `None` if it is near it, for under [`FEWEST_OTHERS`] of these,
/// and for kinds that are not compared ([`ALIKE`]) and values that are unknown or 0.
fn odd_one_out(machine: &Machine, own: &Parameter, all: &[Parameter]) -> Option<String> {
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
    Some(format!("{}: {times:.0} times {size} than others of its kind; is its unit another?", shown(machine, own)))
}

/// Returns a question about a Young's modulus that no material has, else `None`.
fn odd_modulus(machine: &Machine, param: &Parameter) -> Option<String> {
    let value = param.value.filter(|_| name_kind(param) == "youngs_modulus")?;
    let [least, largest] = MODULI;
    (!(least..=largest).contains(&value)).then(|| {
        format!("{}: materials have {least:e} to {largest:e}; is its unit another (GPa, Pa)?", shown(machine, param))
    })
}

/// Returns a question about a gravity that acts on masses and is not that of Earth, else `None`.
fn odd_gravity(machine: &Machine) -> Option<String> {
    let norm = machine.gravity.norm();
    (norm != 0.0 && machine.has_weight() && !(GRAVITY[0]..=GRAVITY[1]).contains(&norm))
        .then(|| format!("gravity_m_per_s2: the magnitude is {norm:.3} m/s², on Earth 9.81"))
}

/// Returns a question about a displacement by weight that is large for the machine's size, else `None`.
fn odd_droop(machine: &Machine, droop: &Droop) -> Option<String> {
    let [_, largest] = droop.range_mm;
    (largest > FAR_DROOP * machine_size(machine)).then(|| {
        format!(
            "weight moves the tool by {largest:.1} mm: are masses 1000 times too large (kg) or stiffnesses 1000 times too small?"
        )
    })
}
