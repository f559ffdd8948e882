//! The tables of a validation study.

use crate::{
    files::exchange::{Row, Table, numbers, texts},
    questions::validation::{Compared, Quoted, Relation, ValidationResults},
};

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

/// One row per quoted number: the number, ours, their ratio, and why they differ.
pub fn quoted_table(results: &ValidationResults) -> Table {
    let study = &results.study;
    let mut columns = texts(["source", "case", "quantity", "unit", "meant_as"]);
    columns.extend(numbers(["quoted", "ours", "ratio"]));
    columns.extend(texts(["agrees", "reason"]));
    let rows = study.quoted.iter().zip(&results.compared).map(|(quoted, compared)| {
        let ours = &compared.ours[0];
        vec![
            quoted.source.as_str().into(),
            study.cases[quoted.case].as_str().into(),
            quoted.quantity.label().into(),
            quoted.quantity.unit(&study.machine).into(),
            relation_word(quoted.relation).into(),
            quoted.value.into(),
            ours.as_ref().ok().copied().into(),
            ratio(quoted, ours).into(),
            if compared.agrees { "yes" } else { "no" }.into(),
            reason(quoted, compared).into(),
        ]
    });
    Table::new(columns, rows)
}

/// One row per quoted number and variant: what the choice of process changes.
pub fn variants_table(results: &ValidationResults) -> Table {
    let study = &results.study;
    let mut columns = texts(["case", "quantity", "unit"]);
    columns.extend(numbers(["quoted"]));
    columns.extend(texts(["variant", "status", "reason"]));
    columns.extend(numbers(["value", "ratio", "change_to_first"]));
    let mut rows: Vec<Row> = Vec::new();
    for (quoted, compared) in study.quoted.iter().zip(&results.compared) {
        let first = compared.ours[0].as_ref().ok();
        for (variant, ours) in study.variants.iter().zip(&compared.ours) {
            let change = ours.as_ref().ok().zip(first).map(|(ours, first)| ours / first - 1.0);
            rows.push(vec![
                study.cases[quoted.case].as_str().into(),
                quoted.quantity.label().into(),
                quoted.quantity.unit(&study.machine).into(),
                quoted.value.into(),
                variant.name.as_str().into(),
                if ours.is_ok() { "solved" } else { "not_solved" }.into(),
                ours.as_ref().err().map(String::as_str).into(),
                ours.as_ref().ok().copied().into(),
                ratio(quoted, ours).into(),
                change.filter(|change| change.is_finite()).into(),
            ]);
        }
    }
    Table::new(columns, rows)
}
