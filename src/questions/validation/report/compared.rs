//! Quoted numbers beside ours: in words, at a glance, in tables and JSON.

use serde_json::{Value, json};

use crate::{
    files::{
        exchange::{Cell, Row, Table, numbers, texts},
        text_table::text_table,
        words::{counted, if_any, typographic},
    },
    page::headline::{Headline, KeyNumber},
    questions::validation::{Compared, Quoted, Relation, ValidationResults, ValidationStudy},
    simulation::SOLVED,
};

/// Below this, a number of ours beside a larger one quoted, or beside none, is rounding.
const NOTHING: f64 = 1e-9;

/// A quoted number beside ours.
pub(super) struct Line<'a> {
    study: &'a ValidationStudy,
    pub quoted: &'a Quoted,
    pub compared: &'a Compared,
}

/// All of them.
pub(super) fn lines(results: &ValidationResults) -> impl Iterator<Item = Line<'_>> {
    let study = &results.study;
    study.quoted.iter().zip(&results.compared).map(move |(quoted, compared)| Line { study, quoted, compared })
}

impl Line<'_> {
    /// The case that it is about.
    pub fn case(&self) -> &str {
        &self.study.cases[self.quoted.case]
    }

    /// What it is, in words.
    pub fn what(&self) -> String {
        self.quoted.quantity.label().replace('_', " ")
    }

    /// Ours under the first variant, if there is one.
    pub fn ours(&self) -> Option<f64> {
        self.compared.ours[0].as_ref().ok().copied()
    }

    /// Word for how it is meant.
    fn meant(&self) -> &'static str {
        match self.quoted.relation {
            Relation::About => "about",
            Relation::AtLeast => "at least",
            Relation::AtMost => "at most",
        }
    }

    /// A number of ours over the quoted one; `None` where that is 0.
    pub fn ratio(&self, ours: f64) -> Option<f64> {
        Some(ours / self.quoted.value).filter(|ratio| ratio.is_finite())
    }

    /// Why ours is another: only where it is.
    fn reason(&self) -> &str {
        match &self.compared.ours[0] {
            Err(reason) => reason,
            _ if self.compared.agrees => "",
            _ => &self.quoted.reason,
        }
    }

    /// The unit of files.
    pub fn file_unit(&self) -> &'static str {
        self.quoted.quantity.unit(&self.study.machine)
    }

    /// The unit behind a number; nothing for pure numbers.
    pub fn unit(&self) -> String {
        match self.file_unit() {
            "1" => String::new(),
            "Nmm" => " N·mm".into(),
            "deg" => "°".into(),
            unit => format!(" {unit}"),
        }
    }

    /// A number of ours, rounded.
    fn rounded(&self, value: f64) -> String {
        let is_larger = self.quoted.value == 0.0 || self.quoted.value.abs() > NOTHING;
        typographic(&match value.abs() {
            0.0 => "0".into(),
            _ if self.quoted.quantity.is_count() => value.to_string(),
            size if size < NOTHING && is_larger => format!("less than {NOTHING:e}"),
            size if size < 1e-3 => format!("{value:.1e}"),
            size if size < 10.0 => format!("{value:.3}"),
            _ => format!("{value:.1}"),
        })
    }

    /// The same with its unit.
    pub fn shown(&self, value: f64) -> String {
        self.rounded(value) + &self.unit()
    }

    /// The quoted number with all its digits and its unit.
    pub fn as_quoted(&self) -> String {
        typographic(&match self.quoted.value.abs() {
            size if size > 0.0 && size < 1e-3 => format!("{:e}", self.quoted.value),
            _ => self.quoted.value.to_string(),
        }) + &self.unit()
    }

    /// Why it differs, if it does.
    fn difference(&self) -> Option<String> {
        let ours = self.ours().map_or_else(|| "no value".into(), |value| self.shown(value));
        let (case, what, meant, quoted) = (self.case(), self.what(), self.meant(), self.as_quoted());
        let line = format!("{case}, {what}: {meant} {quoted} quoted, {ours} here. {}", self.reason());
        (!self.compared.agrees).then(|| format!("{}\n", line.trim_end()))
    }

    /// As a program reads it.
    fn json(&self) -> Value {
        json!({
            "source": self.quoted.source,
            "case": self.case(),
            "quantity": self.quoted.quantity.label(),
            "unit": self.file_unit(),
            "meant_as": self.meant(),
            "quoted": self.quoted.value,
            "ours": self.ours(),
            "ratio": self.ours().and_then(|ours| self.ratio(ours)),
            "agrees": self.compared.agrees,
            "reason": self.reason(),
        })
    }

    /// Whether it agrees, as a word.
    fn agrees(&self) -> &'static str {
        if self.compared.agrees { "yes" } else { "no" }
    }

    /// As a row of [`quoted_table`].
    fn row(&self) -> Row {
        vec![
            self.quoted.source.as_str().into(),
            self.case().into(),
            self.quoted.quantity.label().into(),
            self.file_unit().into(),
            self.meant().into(),
            self.quoted.value.into(),
            self.ours().into(),
            self.ours().and_then(|ours| self.ratio(ours)).into(),
            self.agrees().into(),
            self.reason().into(),
        ]
    }

    /// As rows of [`variants_table`].
    fn rows_of_variants(&self) -> Vec<Row> {
        let row = |(name, ours): (&str, &Result<f64, String>)| -> Row {
            let value = ours.as_ref().ok().copied();
            let change = value.zip(self.ours()).map(|(value, first)| value / first - 1.0);
            vec![
                self.case().into(),
                self.quoted.quantity.label().into(),
                self.file_unit().into(),
                self.quoted.value.into(),
                name.into(),
                status(ours).into(),
                ours.as_ref().err().map(String::as_str).into(),
                value.into(),
                value.and_then(|value| self.ratio(value)).into(),
                Cell::from(change.filter(|change| change.is_finite())),
            ]
        };
        let names = self.study.variants.iter().map(|variant| variant.name.as_str());
        names.zip(&self.compared.ours).map(row).collect()
    }
}

/// Whether there is a number of ours.
pub(super) fn status(ours: &Result<f64, String>) -> &'static str {
    if ours.is_ok() { SOLVED } else { "not_solved" }
}

/// One row per quoted number: the number, ours, their ratio, and why they differ.
pub fn quoted_table(results: &ValidationResults) -> Table {
    let columns = [
        texts(["source", "case", "quantity", "unit", "meant_as"]),
        numbers(["quoted", "ours", "ratio"]),
        texts(["agrees", "reason"]),
    ];
    Table::new(columns.concat(), lines(results).map(|line| line.row()))
}

/// One row per quoted number and variant: what the choice of process changes.
pub fn variants_table(results: &ValidationResults) -> Table {
    let columns = [
        texts(["case", "quantity", "unit"]),
        numbers(["quoted"]),
        texts(["variant", "status", "reason"]),
        numbers(["value", "ratio", "change_to_first"]),
    ];
    Table::new(columns.concat(), lines(results).flat_map(|line| line.rows_of_variants()))
}

/// Quoted numbers and ours for the first variant, then for all variants.
pub(super) fn summary_table(results: &ValidationResults) -> String {
    let mut first = text_table(["case", "quantity", "quoted", "ours", "ratio", "agrees"], 2);
    let names = results.study.variants.iter().map(|variant| variant.name.as_str());
    let mut all = text_table(["case", "quantity"].into_iter().chain(names), 2);
    for line in lines(results) {
        let named = [line.case().to_string(), line.what()];
        let values = line.compared.ours.iter();
        let values: Vec<String> = values.map(|ours| if_any(ours.as_ref().ok(), |value| line.rounded(*value))).collect();
        let ratio = line.ours().and_then(|ours| line.ratio(ours));
        first.add_row(named.iter().cloned().chain([
            format!("{} {}", line.meant(), line.as_quoted()),
            values[0].clone(),
            if_any(ratio, |ratio| typographic(&format!("{ratio:.2}"))),
            line.agrees().into(),
        ]));
        all.add_row(named.into_iter().chain(values));
    }
    format!("{first}\n\n{all}\n")
}

/// Why numbers that do not agree differ, a line each.
pub fn differences(results: &ValidationResults) -> String {
    lines(results).filter_map(|line| line.difference()).collect()
}

/// The same as `summary.csv`.
pub(super) fn summary_json(results: &ValidationResults) -> Value {
    let variants: Vec<&String> = results.study.variants.iter().map(|variant| &variant.name).collect();
    let rows: Vec<Value> = lines(results).map(|line| line.json()).collect();
    json!({ "schema": 1, "variants": variants, "quoted": rows })
}

/// The answer at a glance.
pub(super) fn headline(results: &ValidationResults, cautions: &str) -> Headline {
    let study = &results.study;
    let count = |is_meant: &dyn Fn(&Line<'_>) -> bool| lines(results).filter(|line| is_meant(line)).count();
    let all = results.compared.len();
    let agreeing = count(&|line| line.compared.agrees);
    let differing = all - agreeing - count(&|line| line.ours().is_none());
    let explained = count(&|line| !line.compared.agrees && !line.quoted.reason.is_empty());
    let basis = format!("{}, process \"{}\"", counted(study.cases.len(), "path"), study.variants[0].name);
    let numbers = counted(all, "quoted number");
    let sentence = match agreeing {
        0 => format!("None of the {numbers} agrees with ours."),
        agreeing if agreeing == all => format!("All {numbers} agree with ours."),
        agreeing => format!("{agreeing} of {numbers} agree with ours; {differing} differ."),
    };
    let of_all = format!("of {} agree", counted(all, "number"));
    let agree = KeyNumber::new(&agreeing.to_string(), of_all, "each within its tolerance, in the table below");
    let told = format!("{explained} with a reason, below");
    let differ = (differing > 0).then(|| KeyNumber::new(&differing.to_string(), "differ", told));
    Headline::new(sentence, basis).with_cautions(cautions).with(agree).with_all(differ).with_all(farthest(results))
}

/// The number that is off by the largest ratio.
fn farthest(results: &ValidationResults) -> Option<KeyNumber> {
    let differing = lines(results).filter(|line| !line.compared.agrees && line.quoted.relation == Relation::About);
    let off = differing.filter_map(|line| {
        let ours = line.ours()?;
        let ratio = line.ratio(ours).filter(|ratio| *ratio > 0.0)?;
        Some((ratio.ln().abs(), ours, line))
    });
    let (_, ours, line) = off.max_by(|a, b| a.0.total_cmp(&b.0))?;
    let percent = 100.0 * (ours / line.quoted.value - 1.0);
    let what = format!("largest difference of a quoted value: {} of {}", line.what(), line.case());
    let against = format!("{} here, {} quoted", line.shown(ours), line.as_quoted());
    Some(KeyNumber::new(&typographic(&format!("{percent:+.0} %")), what, against))
}
