//! Comparison of quoted numbers with the model's, in words, tables and JSON, and the first screen.

use serde_json::{Value, json};

use crate::{
    files::{
        exchange::{Cell, Row, Table, numbers, texts},
        text_table::text_table,
        words::{counted, or_dash, typographic},
    },
    page::headline::{Headline, KeyNumber, State, Verdict},
    questions::validation::{Compared, Quoted, Relation, ValidationResults, ValidationStudy},
    simulation::SOLVED,
};

/// Size below which a number of ours is rounding, if the quoted one is larger or 0.
const NOTHING: f64 = 1e-9;

/// One quoted number with its comparison and study.
pub(super) struct QuotedLine<'a> {
    study: &'a ValidationStudy,
    pub quoted: &'a Quoted,
    pub compared: &'a Compared,
}

/// Returns the comparison of each quoted number.
pub(super) fn lines(results: &ValidationResults) -> impl Iterator<Item = QuotedLine<'_>> {
    let study = &results.study;
    study.quoted.iter().zip(&results.compared).map(move |(quoted, compared)| QuotedLine { study, quoted, compared })
}

impl QuotedLine<'_> {
    /// Returns the name of the case that the quoted number is about.
    pub fn case(&self) -> &str {
        &self.study.cases[self.quoted.case]
    }

    /// Returns the quantity of the quoted number in words.
    pub fn what(&self) -> String {
        self.quoted.quantity.label().replace('_', " ")
    }

    /// Returns the model's value under the first variant, if there is one.
    pub fn ours(&self) -> Option<f64> {
        self.compared.ours[0].as_ref().ok().copied()
    }

    /// Returns the word for how the quoted number is to be compared.
    fn relation_word(&self) -> &'static str {
        match self.quoted.relation {
            Relation::About => "about",
            Relation::AtLeast => "at least",
            Relation::AtMost => "at most",
        }
    }

    /// Returns the ratio of a value of the model to the quoted one; `None` where that is 0.
    pub fn ratio(&self, ours: f64) -> Option<f64> {
        Some(ours / self.quoted.value).filter(|ratio| ratio.is_finite())
    }

    /// Returns why the model's value differs or is missing; empty where it agrees.
    fn reason(&self) -> &str {
        match &self.compared.ours[0] {
            Err(reason) => reason,
            _ if self.compared.agrees => "",
            _ => &self.quoted.reason,
        }
    }

    /// Returns the unit of the quoted number as files have it.
    pub fn file_unit(&self) -> &'static str {
        self.quoted.quantity.unit(&self.study.machine)
    }

    /// Returns the unit as it follows the quoted number, with the space before it (" N·mm", "°"); empty for pure numbers.
    pub fn unit_suffix(&self) -> String {
        match self.file_unit() {
            "1" => String::new(),
            "Nmm" => " N·mm".into(),
            "deg" => "°".into(),
            unit => format!(" {unit}"),
        }
    }

    /// Formats a value of the model, rounded.
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

    /// Formats a value of the model, rounded, with its unit.
    pub fn shown(&self, value: f64) -> String {
        self.rounded(value) + &self.unit_suffix()
    }

    /// Formats the quoted value with all its digits and its unit.
    pub fn as_quoted(&self) -> String {
        typographic(&match self.quoted.value.abs() {
            size if size > 0.0 && size < 1e-3 => format!("{:e}", self.quoted.value),
            _ => self.quoted.value.to_string(),
        }) + &self.unit_suffix()
    }

    /// Returns a line that says why the model's value differs from the quoted one; `None` where they agree.
    fn difference(&self) -> Option<String> {
        let ours = self.ours().map_or_else(|| "no value".into(), |value| self.shown(value));
        let (case, what, relation_word, quoted) = (self.case(), self.what(), self.relation_word(), self.as_quoted());
        let line = format!("{case}, {what}: {relation_word} {quoted} quoted, {ours} here. {}", self.reason());
        (!self.compared.agrees).then(|| format!("{}\n", line.trim_end()))
    }

    /// Returns the comparison of the quoted number as JSON.
    fn json(&self) -> Value {
        json!({
            "source": self.quoted.source,
            "case": self.case(),
            "quantity": self.quoted.quantity.label(),
            "unit": self.file_unit(),
            "meant_as": self.relation_word(),
            "quoted": self.quoted.value,
            "ours": self.ours(),
            "ratio": self.ours().and_then(|ours| self.ratio(ours)),
            "agrees": self.compared.agrees,
            "reason": self.reason(),
        })
    }

    /// Returns "yes" where the model's value agrees with the quoted one, else "no".
    fn agrees_word(&self) -> &'static str {
        if self.compared.agrees { "yes" } else { "no" }
    }

    /// Returns the row of the quoted number in [`quoted_table`].
    fn row(&self) -> Row {
        vec![
            self.quoted.source.as_str().into(),
            self.case().into(),
            self.quoted.quantity.label().into(),
            self.file_unit().into(),
            self.relation_word().into(),
            self.quoted.value.into(),
            self.ours().into(),
            self.ours().and_then(|ours| self.ratio(ours)).into(),
            self.agrees_word().into(),
            self.reason().into(),
        ]
    }

    /// Returns the rows of the quoted number in [`variants_table`], one for each variant.
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

/// Returns the status in tables of a value of the model: solved or not.
pub(super) fn status(ours: &Result<f64, String>) -> &'static str {
    if ours.is_ok() { SOLVED } else { "not_solved" }
}

/// Makes the table of quoted numbers: a row for each, with the model's value, their ratio, and why they differ.
pub fn quoted_table(results: &ValidationResults) -> Table {
    let columns = [
        texts(["source", "case", "quantity", "unit", "meant_as"]),
        numbers(["quoted", "ours", "ratio"]),
        texts(["agrees", "reason"]),
    ];
    Table::new(columns.concat(), lines(results).map(|line| line.row()))
}

/// Makes the table of variants: a row for each quoted number and variant, which shows what the choice of process changes.
pub fn variants_table(results: &ValidationResults) -> Table {
    let columns = [
        texts(["case", "quantity", "unit"]),
        numbers(["quoted"]),
        texts(["variant", "status", "reason"]),
        numbers(["value", "ratio", "change_to_first"]),
    ];
    Table::new(columns.concat(), lines(results).flat_map(|line| line.rows_of_variants()))
}

/// Returns two tables as text: quoted numbers with the value of the model under the first variant, and the values under all variants.
pub(super) fn summary_text(results: &ValidationResults) -> String {
    let mut comparison = text_table(["case", "quantity", "quoted", "ours", "ratio", "agrees"], 2);
    let names = results.study.variants.iter().map(|variant| variant.name.as_str());
    let mut variants = text_table(["case", "quantity"].into_iter().chain(names), 2);
    for line in lines(results) {
        let labels = [line.case().to_string(), line.what()];
        let values = line.compared.ours.iter();
        let values: Vec<String> =
            values.map(|ours| or_dash(ours.as_ref().ok(), |value| line.rounded(*value))).collect();
        let ratio = line.ours().and_then(|ours| line.ratio(ours));
        comparison.add_row(labels.iter().cloned().chain([
            format!("{} {}", line.relation_word(), line.as_quoted()),
            values[0].clone(),
            or_dash(ratio, |ratio| typographic(&format!("{ratio:.2}"))),
            line.agrees_word().into(),
        ]));
        variants.add_row(labels.into_iter().chain(values));
    }
    format!("{comparison}\n\n{variants}\n")
}

/// Returns a line for each number that does not agree, which says why.
pub fn differences(results: &ValidationResults) -> String {
    lines(results).filter_map(|line| line.difference()).collect()
}

/// Returns the comparison of all quoted numbers as JSON.
pub(super) fn summary_json(results: &ValidationResults) -> Value {
    let variants: Vec<&String> = results.study.variants.iter().map(|variant| &variant.name).collect();
    let rows: Vec<Value> = lines(results).map(|line| line.json()).collect();
    json!({ "schema": 1, "variants": variants, "quoted": rows })
}

/// Returns the first screen: main sentence, cautions and key numbers.
pub(super) fn headline(results: &ValidationResults, cautions: &str) -> Headline {
    let study = &results.study;
    let count = |is_meant: &dyn Fn(&QuotedLine<'_>) -> bool| lines(results).filter(|line| is_meant(line)).count();
    let total = results.compared.len();
    let agreeing = count(&|line| line.compared.agrees);
    let differing = total - agreeing - count(&|line| line.ours().is_none());
    let explained = count(&|line| !line.compared.agrees && !line.quoted.reason.is_empty());
    let basis = format!("{}, process \"{}\"", counted(study.cases.len(), "path"), study.variants[0].name);
    let numbers = counted(total, "quoted number");
    let (sentence, state) = match agreeing {
        0 => (format!("None of the {numbers} agrees with ours."), State::Bad),
        _ if agreeing == total => (format!("All {numbers} agree with ours."), State::Good),
        _ => {
            let differ = match (differing, differing == explained) {
                (1, true) => "1 differs, with a reason".into(),
                (_, true) => format!("{differing} differ, each with a reason"),
                (_, false) => format!("{differing} differ, {explained} with a reason"),
            };
            (format!("Agreeing is within each number's tolerance; {differ}."), State::Partly)
        }
    };
    let of_all = format!("of {} agree", counted(total, "number"));
    let agree = KeyNumber::new(&agreeing.to_string(), of_all, "each within its tolerance, in the table below");
    let with_reason = format!("{explained} with a reason, below");
    let differ = (differing > 0).then(|| KeyNumber::new(&differing.to_string(), "differ", with_reason));
    let farthest = farthest(results);
    let place = |line: &QuotedLine<'_>| format!("{} of {}", line.what(), line.case());
    let next = match &farthest {
        _ if agreeing == total => "trust the model where the paper was: its machine, its force, its errors.".into(),
        Some((_, line)) => format!("before you rely on the {}, measure it: it differs most.", place(line)),
        None => "before you rely on what differs, read its reason below.".to_owned(),
    };
    Headline::new(sentence, basis)
        .next(next)
        .judged(Verdict::new(state, format!("{agreeing} of {total} quoted numbers agree")), false)
        .with_cautions(&differences(results))
        .with_cautions(cautions)
        .with(agree)
        .with_numbers(differ)
        .with_numbers(farthest.map(|(ours, line)| {
            let percent = 100.0 * (ours / line.quoted.value - 1.0);
            let what = format!("largest difference of a quoted value: {}", place(&line));
            let against = format!("{} here, {} quoted", line.shown(ours), line.as_quoted());
            KeyNumber::new(&typographic(&format!("{percent:+.0} %")), what, against)
        }))
}

/// Returns the model's value with the largest ratio to the quoted one, either way, and its line; `None` if all agree.
fn farthest(results: &ValidationResults) -> Option<(f64, QuotedLine<'_>)> {
    let differing = lines(results).filter(|line| !line.compared.agrees && line.quoted.relation == Relation::About);
    let deviations = differing.filter_map(|line| {
        let ours = line.ours()?;
        let ratio = line.ratio(ours).filter(|ratio| *ratio > 0.0)?;
        Some((libm::log(ratio).abs(), ours, line))
    });
    deviations.max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, ours, line)| (ours, line))
}
