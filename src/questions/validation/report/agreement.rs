//! All quoted numbers in one figure: each against ours, in tolerances.

use super::compared::{Line, lines};
use crate::{
    figures::{AgreementFigure, AgreementRow, Figure, Meant},
    files::words::{if_any, typographic},
    questions::validation::{Quoted, Relation, ValidationResults},
};

/// The figure; `None` where nothing is quoted.
pub(super) fn figure(results: &ValidationResults) -> Option<Figure> {
    let study = &results.study;
    let rows: Vec<AgreementRow> = lines(results).map(|line| row(&line)).collect();
    let agreeing = rows.iter().filter(|row| row.agrees).count();
    (!rows.is_empty()).then(|| {
        Figure::Agreement(AgreementFigure {
            title: format!("{agreeing} of {} quoted numbers agree", rows.len()),
            subtitle: format!("{}; {}", study.machine.short_title(), study.variants[0].name),
            numbers: "quoted, ours".into(),
            rows,
        })
    })
}

fn row(line: &Line<'_>) -> AgreementRow {
    let (quoted, ours) = (line.quoted, line.ours());
    let unit = match line.file_unit() {
        "1" => String::new(),
        "deg" => "°".into(),
        unit => format!(" {unit}"),
    };
    let (sign, meant) = match quoted.relation {
        Relation::About => ("", Meant::About),
        Relation::AtLeast => ("≥ ", Meant::AtLeast),
        Relation::AtMost => ("≤ ", Meant::AtMost),
    };
    let shown = if_any(ours, |ours| short(ours, quoted.value));
    AgreementRow {
        label: format!("{}: {}", line.case(), line.what()),
        numbers: typographic(&format!("{sign}{}, {shown}{unit}", quoted.value)),
        meant,
        difference: ours.map(|ours| in_tolerances(quoted, ours)),
        agrees: line.compared.agrees,
    }
}

/// Differences of more tolerances than this are drawn, like it, beyond the axis.
const FAR: f64 = 1e3;

/// Ours less the quoted number over what counts as none; where nothing does, the sign of it, far out.
fn in_tolerances(quoted: &Quoted, ours: f64) -> f64 {
    let difference = ours - quoted.value;
    let share = difference / quoted.allowed();
    match share.is_finite() {
        true => share.clamp(-FAR, FAR),
        false if difference == 0.0 => 0.0,
        false => FAR.copysign(difference),
    }
}

/// Our number with three digits, and no more decimals than show beside the quoted one.
pub fn short(ours: f64, quoted: f64) -> String {
    let size = ours.abs().max(quoted.abs());
    let decimals = if size > 0.0 { (2.0 - size.log10().floor()).clamp(0.0, 4.0) as usize } else { 0 };
    let text = format!("{ours:.decimals$}");
    if text.trim_start_matches('-').chars().all(|c| c == '0' || c == '.') { "0".into() } else { text }
}
