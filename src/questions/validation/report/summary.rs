//! A validation study on the screen and as JSON.

use serde_json::{Value, json};

use crate::{
    files::{text_table::text_table, words::typographic},
    questions::validation::{
        Compared, Quoted, ValidationResults, ValidationStudy,
        report::tables::{ratio, reason, relation_word},
    },
};

/// Below this, a number of ours beside a larger one quoted, or beside none, is rounding.
const NOTHING: f64 = 1e-9;

/// A number of ours, rounded.
pub(super) fn shown(quoted: &Quoted, value: f64) -> String {
    let is_larger = quoted.value == 0.0 || quoted.value.abs() > NOTHING;
    typographic(&match value.abs() {
        0.0 => "0".into(),
        _ if quoted.quantity.is_count() => value.to_string(),
        size if size < NOTHING && is_larger => format!("less than {NOTHING:e}"),
        size if size < 1e-3 => format!("{value:.1e}"),
        size if size < 10.0 => format!("{value:.3}"),
        _ => format!("{value:.1}"),
    })
}

/// The quoted number with all its digits.
pub(super) fn as_quoted(quoted: &Quoted) -> String {
    typographic(&match quoted.value.abs() {
        size if size > 0.0 && size < 1e-3 => format!("{:e}", quoted.value),
        _ => quoted.value.to_string(),
    })
}

/// The unit behind a number; nothing for pure numbers.
pub(super) fn unit(quoted: &Quoted, study: &ValidationStudy) -> String {
    match quoted.quantity.unit(&study.machine) {
        "1" => String::new(),
        "Nmm" => " N·mm".into(),
        "deg" => "°".into(),
        unit => format!(" {unit}"),
    }
}

/// Quoted numbers and ours for the first variant, then for all variants.
pub(crate) fn summary_table(results: &ValidationResults) -> String {
    let study = &results.study;
    let mut first = text_table(["case", "quantity", "quoted", "ours", "ratio", "agrees"], 2);
    let names = study.variants.iter().map(|variant| variant.name.as_str());
    let mut all = text_table(["case", "quantity"].into_iter().chain(names), 2);
    for (quoted, compared) in study.quoted.iter().zip(&results.compared) {
        let unit = unit(quoted, study);
        let what = [study.cases[quoted.case].clone(), quoted.quantity.label().replace('_', " ")];
        let values: Vec<String> = compared
            .ours
            .iter()
            .map(|ours| ours.as_ref().map_or_else(|_| "–".into(), |value| shown(quoted, *value)))
            .collect();
        first.add_row(what.iter().cloned().chain([
            format!("{} {}{unit}", relation_word(quoted.relation), as_quoted(quoted)),
            values[0].clone(),
            ratio(quoted, &compared.ours[0]).map_or_else(|| "–".into(), |ratio| typographic(&format!("{ratio:.2}"))),
            if compared.agrees { "yes" } else { "no" }.into(),
        ]));
        all.add_row(what.into_iter().chain(values));
    }
    format!("{first}\n\n{all}\n")
}

/// Why numbers that do not agree differ, a line each.
pub fn differences(results: &ValidationResults) -> String {
    let study = &results.study;
    let mut text = String::new();
    for (quoted, compared) in study.quoted.iter().zip(&results.compared).filter(|(_, compared)| !compared.agrees) {
        let unit = unit(quoted, study);
        let ours = match &compared.ours[0] {
            Ok(value) => shown(quoted, *value) + &unit,
            Err(_) => "no value".into(),
        };
        let line = format!(
            "{}, {}: {} {}{unit} quoted, {ours} here. {}",
            study.cases[quoted.case],
            quoted.quantity.label().replace('_', " "),
            relation_word(quoted.relation),
            as_quoted(quoted),
            reason(quoted, compared)
        );
        text += &format!("{}\n", line.trim_end());
    }
    text
}

/// The same as `summary.csv`.
pub fn summary_json(results: &ValidationResults) -> Value {
    let study = &results.study;
    let row = |(quoted, compared): (&Quoted, &Compared)| {
        json!({
            "source": quoted.source,
            "case": study.cases[quoted.case],
            "quantity": quoted.quantity.label(),
            "unit": quoted.quantity.unit(&study.machine),
            "meant_as": relation_word(quoted.relation),
            "quoted": quoted.value,
            "ours": compared.ours[0].as_ref().ok(),
            "ratio": ratio(quoted, &compared.ours[0]),
            "agrees": compared.agrees,
            "reason": reason(quoted, compared),
        })
    };
    let rows: Vec<Value> = study.quoted.iter().zip(&results.compared).map(row).collect();
    json!({ "schema": 1, "variants": study.variants.iter().map(|v| &v.name).collect::<Vec<_>>(), "quoted": rows })
}
