//! A validation study as CSV (RFC 4180).

use crate::study::validation::{Compared, Quoted, Relation, ValidationResults};

/// Word for how a number is meant.
pub(super) fn relation_word(relation: Relation) -> &'static str {
    match relation {
        Relation::About => "about",
        Relation::AtLeast => "at least",
        Relation::AtMost => "at most",
    }
}

/// Ours over the quoted number; `None` where that is 0 or there is none.
pub(super) fn ratio(quoted: &Quoted, ours: &Result<f64, String>) -> Option<f64> {
    ours.as_ref().ok().map(|ours| ours / quoted.value).filter(|ratio| ratio.is_finite())
}

/// Why ours is another: only where it is.
pub(super) fn reason<'a>(quoted: &'a Quoted, compared: &'a Compared) -> &'a str {
    match compared.ours.first() {
        Some(Err(reason)) => reason,
        _ if compared.agrees => "",
        _ => &quoted.reason,
    }
}

fn number(value: Option<f64>) -> String {
    value.map_or_else(String::new, |value| value.to_string())
}

/// One row per quoted number: the number, ours, their ratio, and why they differ.
pub fn summary_csv(results: &ValidationResults) -> csv::Result<Vec<u8>> {
    let study = &results.study;
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record([
        "source", "case", "quantity", "unit", "meant_as", "quoted", "ours", "ratio", "agrees", "reason",
    ])?;
    for (quoted, compared) in study.quoted.iter().zip(&results.compared) {
        let ours = &compared.ours[0];
        writer.write_record([
            quoted.source.as_str(),
            &study.cases[quoted.case],
            quoted.quantity.label(),
            quoted.quantity.unit(&study.machine),
            relation_word(quoted.relation),
            &quoted.value.to_string(),
            &number(ours.as_ref().ok().copied()),
            &number(ratio(quoted, ours)),
            if compared.agrees { "yes" } else { "no" },
            reason(quoted, compared),
        ])?;
    }
    writer.into_inner().map_err(|e| csv::Error::from(e.into_error()))
}

/// One row per quoted number and variant: what the choice of process changes.
pub fn variants_csv(results: &ValidationResults) -> csv::Result<Vec<u8>> {
    let study = &results.study;
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record([
        "case",
        "quantity",
        "unit",
        "quoted",
        "variant",
        "status",
        "reason",
        "value",
        "ratio",
        "change_to_first",
    ])?;
    for (quoted, compared) in study.quoted.iter().zip(&results.compared) {
        let first = compared.ours[0].as_ref().ok();
        for (variant, ours) in study.variants.iter().zip(&compared.ours) {
            let change = ours.as_ref().ok().zip(first).map(|(ours, first)| ours / first - 1.0);
            writer.write_record([
                study.cases[quoted.case].as_str(),
                quoted.quantity.label(),
                quoted.quantity.unit(&study.machine),
                &quoted.value.to_string(),
                &variant.name,
                if ours.is_ok() { "solved" } else { "not_solved" },
                ours.as_ref().err().map_or("", String::as_str),
                &number(ours.as_ref().ok().copied()),
                &number(ratio(quoted, ours)),
                &number(change.filter(|change| change.is_finite())),
            ])?;
        }
    }
    writer.into_inner().map_err(|e| csv::Error::from(e.into_error()))
}
