//! The first screen of a correction table: how large it is, what it leaves, and what there is without it.

use super::{CorrectionFormat, Report, text};
use crate::{
    files::words::{counted, millimetres, position},
    page::headline::{Headline, KeyNumber},
    products::correction::Worst,
    simulation::ROUNDING_MM,
};

/// The answer at a glance.
pub(super) fn headline(report: &Report<'_>) -> Headline {
    let answer = report.answer;
    let basis = format!("{} and forces off the grid", counted(answer.with_table.looked_at, "position"));
    Headline::new(sentence(report), basis)
        .with_cautions(&text::cautions(report))
        .with(with_table(report))
        .with(number(&answer.without, "largest error without correction", against(report, &answer.without)))
        .with_all(per_joint(report))
}

/// What does harm is said first.
fn sentence(report: &Report<'_>) -> String {
    let answer = report.answer;
    match &answer.per_joint {
        Ok((_, worst)) if answer.is_per_joint_harmful() && report.has(CorrectionFormat::Comp) => format!(
            "Do not use the tables for single joints: with them the tool is off by up to {}, without any correction by {}. {}",
            millimetres(worst.error_mm, 4),
            millimetres(answer.without.error_mm, 4),
            of_table(report)
        ),
        _ => of_table(report),
    }
}

fn of_table(report: &Report<'_>) -> String {
    let (question, answer) = (report.question, report.answer);
    let (name, size) = (question.machine.short_title(), report.size());
    let [left, without] = [&answer.with_table, &answer.without].map(|worst| millimetres(worst.error_mm, 4));
    if answer.without.error_mm <= ROUNDING_MM {
        return format!("The tool of the {name} is where it is wanted without correction: the table is one of zeros.");
    }
    match report.is_kept() {
        true => format!(
            "With a table of {size} points the tool of the {name} stays within {} mm anywhere in the box (worst found: {left}); without \
             any it is off by up to {without}.",
            question.tolerance_mm
        ),
        false => format!(
            "A table of {size} points leaves the tool of the {name} off by up to {left}, more than the {} mm asked for; without any it \
             is off by up to {without}.",
            question.tolerance_mm
        ),
    }
}

fn with_table(report: &Report<'_>) -> KeyNumber {
    let against = format!(
        "tolerance {} mm; {} at the nodes themselves",
        report.question.tolerance_mm,
        millimetres(report.answer.at_nodes_mm, 4)
    );
    number(&report.answer.with_table, "largest error with the table that was found", against)
}

fn per_joint(report: &Report<'_>) -> Option<KeyNumber> {
    let (_, worst) = report.answer.per_joint.as_ref().ok().filter(|_| report.has(CorrectionFormat::Comp))?;
    Some(number(worst, "largest error with a table for each joint alone", against(report, worst)))
}

fn against(report: &Report<'_>, worst: &Worst) -> String {
    let left = report.answer.with_table.error_mm;
    if left <= ROUNDING_MM { String::new() } else { format!("{:.0} times that with the table", worst.error_mm / left) }
}

fn number(worst: &Worst, what: &str, against: String) -> KeyNumber {
    KeyNumber::new(&millimetres(worst.error_mm, 4), format!("{what}, {}", place(worst)), against)
}

/// Where, and under what force.
pub(super) fn place(worst: &Worst) -> String {
    let [x, y, z] = worst.position_mm;
    let force = nalgebra::Vector3::from(worst.force_N).norm();
    let under = if force == 0.0 { "without force".into() } else { format!("under {force:.0} N") };
    format!("at {} {under}", position(x, y, z))
}
