//! Sentences about a correction table.

use super::{CorrectionFormat, Report};
use crate::{
    answer::cautions,
    compensation::Target,
    files::words::{counted, millimetres, position},
    page::headline::{Headline, KeyNumber, State, Verdict},
    process::uncertainty::Draws,
    products::{
        correction::{CorrectionQuestion, ForceTerms, Worst},
        field_report::share_text,
    },
    questions::spread_report::quantile_text,
    simulation::ROUNDING_MM,
};

/// Returns the cautions of the result, a sentence per line.
pub(super) fn cautions(report: &Report<'_>) -> String {
    let CorrectionQuestion { machine, errors, corners, tolerance_mm, .. } = report.question;
    let mut text = String::new();
    if !report.is_within() {
        text += &match report.answer.spread {
            None => format!("The table is out of tolerance ({tolerance_mm} mm).\n"),
            Some(_) => format!(
                "The table is off by more than the {tolerance_mm} mm it was asked to keep with nominal numbers.\n"
            ),
        };
    }
    text += &field_cautions(report);
    text += &cautions::machine_cautions(machine, errors, "box corner", corners.iter().copied());
    if let Some(axes) = machine.uncontrolled_names() {
        text += &format!("Errors along {axes} stay: the drives do not control {axes}.\n");
    }
    text
}

/// Returns the cautions where inputs are uncertain: tables for single joints, what is not judged, and what the distributions rest on; else empty.
fn field_cautions(report: &Report<'_>) -> String {
    let Some(field) = report.field() else { return String::new() };
    let joints = field.spread.ways.get(2).filter(|_| report.has(CorrectionFormat::Comp)).map(|joints| {
        format!(
            "With the tables for single joints the tool stays within {} with 95 % probability; they are better than no correction with {} probability, worse \
             with {}.\n",
            quantile_text(joints.largest.p95_mm),
            share_text(joints.better),
            share_text(joints.worse)
        )
    });
    let orientation = match report.question.target {
        Target::FullPose => {
            "The distributions are of distances alone: the orientation that full_pose holds is not judged.\n"
        }
        _ => "",
    };
    joints.unwrap_or_default() + orientation + &field.cautions()
}

/// Returns what is left on machines as they may be, in sentences; empty where inputs are taken as exact.
pub(super) fn field_text(report: &Report<'_>) -> String {
    let names = ["without correction", "with the table", "with tables for single joints"];
    let Some(field) = report.field() else { return String::new() };
    field.details(&names) + "The maps and errors elsewhere on this page are those with nominal numbers.\n"
}

/// Returns the residual error with the table, and how it was found.
pub(super) fn residual_text(report: &Report<'_>) -> String {
    let (question, answer) = (report.question, report.answer);
    let worst = &answer.with_table;
    if answer.without.error_mm <= ROUNDING_MM {
        return "Nothing is off without correction.\n".into();
    }
    let size = counted(answer.table.grid.len(), "node");
    let smallest = match question.counts {
        Some(_) => "a size that was given",
        None => "with one node less along any axis it was found to be out of tolerance",
    };
    format!(
        "The table has {} ({}), {smallest}.\nThe largest error found with it is {}, {}; without correction {}, {}.\n\
         How that was found: the loaded machine was solved at {} and forces off the grid, on a lattice of half cells, at \
         points spread evenly over position and force, and by climbing from the worst of them. A search is no proof: it may have \
         missed a larger error, but that is not likely.\nAt the nodes themselves up to {} is left: what {} miss of \
         the correction, whatever the grid.\n",
        report.size(),
        size,
        millimetres(worst.error_mm, 5),
        worst_place(worst),
        millimetres(answer.without.error_mm, 4),
        worst_place(&answer.without),
        counted(worst.looked_at, "position"),
        millimetres(answer.at_nodes_mm, 5),
        match answer.table.terms {
            ForceTerms::Constant => "rounding may",
            ForceTerms::Linear => "terms linear in the force",
            ForceTerms::Quadratic => "terms up to the square of the force",
        },
    )
}

/// Returns how a controller uses the table.
pub(super) fn how_to_use(report: &Report<'_>) -> String {
    let force = match report.answer.table.terms {
        ForceTerms::Constant => "There is no force: each drive has one coefficient, its correction.".to_string(),
        ForceTerms::Linear => format!(
            "For each drive: Δρ = c + c_x F_x + c_y F_y + c_z F_z, with the force F on the tool tip in the axes of the base, measured or \
             predicted, up to {} N. A torque about the tool tip is not in it.",
            report.force()
        ),
        ForceTerms::Quadratic => format!(
            "For each drive: Δρ = c + c_x F_x + c_y F_y + c_z F_z + c_xx F_x² + c_yy F_y² + c_zz F_z² + c_xy F_x F_y + c_xz F_x F_z + \
             c_yz F_y F_z, with the force F on the tool tip in the axes of the base, measured or predicted, up to {} N: terms linear \
             in the force would leave more than half of the tolerance. A torque about the tool tip is not in it.",
            report.force()
        ),
    };
    format!(
        "The table is over positions of the platform point P in the base frame, as the program wants them, not corrected.\n\
         Between nodes each coefficient is linear along each axis (of eight corners of a cell, each with the product of its three \
         shares).\n{force}\nΔρ is added to the position that the kinematics of the rigid machine give the drive.\n"
    )
}

/// Returns what a table of each drive alone achieves.
pub(super) fn per_joint_text(report: &Report<'_>) -> String {
    let not_written = match report.has(CorrectionFormat::Comp) {
        false if report.answer.is_per_joint_harmful() => "Tables for joints do harm: no files are written.\n",
        false if !report.answer.is_per_joint_of_use() => "Tables for joints are of no use: no files are written.\n",
        _ => "",
    };
    match &report.answer.per_joint {
        Ok((_, worst)) => format!(
            "A control that knows only a table for each joint over its own position can take the part of the correction that depends \
             on neither the other joints nor the force: the middle between the smallest and the largest correction of a drive that \
             stands there. Such tables leave up to {}, {}; the full table leaves {}, and no correction {}.\n{not_written}",
            millimetres(worst.error_mm, 4),
            worst_place(worst),
            millimetres(report.answer.with_table.error_mm, 4),
            millimetres(report.answer.without.error_mm, 4)
        ),
        Err(reason) => format!("No files for single joints (LinuxCNC's COMP_FILE): {reason}.\n"),
    }
}

/// Returns the full report for a terminal.
pub(super) fn details(report: &Report<'_>) -> String {
    field_text(report) + &residual_text(report) + &how_to_use(report) + &per_joint_text(report)
}

/// Returns main sentence, numbers and cautions.
pub(super) fn headline(report: &Report<'_>) -> Headline {
    let answer = report.answer;
    let basis = format!("{} and forces off the grid", counted(answer.with_table.looked_at, "position"));
    if let Some(field) = report.field() {
        let basis = format!("{basis}, {}", counted(Draws::PER_SCRAMBLE, "draw"));
        let headline =
            Headline::new(first_sentence(report), basis).judged(state(report), false).next(next_step(report));
        let headline = headline.with_cautions(&sentence(report)).with_cautions(&cautions(report));
        return headline.with_numbers(field.numbers().into_iter().chain([table_number(report)]));
    }
    Headline::new(first_sentence(report), basis)
        .judged(state(report), true)
        .next(next_step(report))
        .with_cautions(&sentence(report))
        .with_cautions(&cautions(report))
        .with(table_number(report))
        .with(error_number(&answer.without, "largest error without correction", ratio_text(report, &answer.without)))
        .with_numbers(joint_number(report))
}

/// Returns the verdict in a few words.
fn state(report: &Report<'_>) -> Verdict {
    match (report.field(), report.is_within()) {
        _ if report.answer.is_per_joint_harmful() && report.has(CorrectionFormat::Comp) => {
            Verdict::new(State::Bad, "Do not use tables for single joints")
        }
        (Some(field), _) => field.state(),
        (None, true) => Verdict::new(State::Good, "Within tolerance with the table"),
        (None, false) => Verdict::new(State::Bad, "Out of tolerance with the table"),
    }
}

/// Returns the first sentence: the error with and without the table.
fn first_sentence(report: &Report<'_>) -> String {
    let [left, without] =
        [&report.answer.with_table, &report.answer.without].map(|worst| millimetres(worst.error_mm, 4));
    format!("Tool off by up to {left} with the table, {without} without.")
}

/// Returns what to do next.
fn next_step(report: &Report<'_>) -> &'static str {
    match state(report).state {
        State::Bad if report.answer.is_per_joint_harmful() && report.has(CorrectionFormat::Comp) => {
            "use the full table in the controller, not those for single joints."
        }
        State::Bad => "allow more points, or a larger tolerance, and export again.",
        _ => "put the table into the controller: how stands below.",
    }
}

/// Returns the main sentence; tables that do harm come first.
fn sentence(report: &Report<'_>) -> String {
    let answer = report.answer;
    let of_table = report.field().map_or_else(|| table_sentence(report), |field| field.verdict());
    match &answer.per_joint {
        Ok((_, worst)) if answer.is_per_joint_harmful() && report.has(CorrectionFormat::Comp) => format!(
            "Do not use the tables for single joints: with them the tool is off by up to {}, without any correction by {}. {}",
            millimetres(worst.error_mm, 4),
            millimetres(answer.without.error_mm, 4),
            of_table
        ),
        _ => of_table,
    }
}

/// Returns the sentence on the error with and without the table.
fn table_sentence(report: &Report<'_>) -> String {
    let (question, answer) = (report.question, report.answer);
    let (name, size) = (&question.machine.name, report.size());
    let [left, without] = [&answer.with_table, &answer.without].map(|worst| millimetres(worst.error_mm, 4));
    if answer.without.error_mm <= ROUNDING_MM {
        return format!("The tool of {name} is where it is wanted without correction: the table is one of zeros.");
    }
    match report.is_within() {
        true => format!(
            "With a table of {size} points the tool of {name} stays within {} mm anywhere in the box (worst found: {left}); without \
             a table it is off by up to {without}.",
            question.tolerance_mm
        ),
        false => format!(
            "A table of {size} points leaves the tool of {name} off by up to {left}, more than the {} mm asked for; without a \
             table by up to {without}.",
            question.tolerance_mm
        ),
    }
}

/// Returns the largest error with the table as a key number.
fn table_number(report: &Report<'_>) -> KeyNumber {
    let (nominally, tolerance) = match report.answer.spread {
        None => ("", "tolerance"),
        Some(_) => (" with nominal numbers", "made to be within"),
    };
    let against = format!(
        "{tolerance} {} mm; {} at the nodes themselves",
        report.question.tolerance_mm,
        millimetres(report.answer.at_nodes_mm, 4)
    );
    let what = format!("largest error with the table that was found{nominally}");
    error_number(&report.answer.with_table, &what, against)
}

/// Returns the largest error with a table of each drive alone as a key number, if such tables are written, else `None`.
fn joint_number(report: &Report<'_>) -> Option<KeyNumber> {
    let (_, worst) = report.answer.per_joint.as_ref().ok().filter(|_| report.has(CorrectionFormat::Comp))?;
    Some(error_number(worst, "largest error with a table for each joint alone", ratio_text(report, worst)))
}

/// Returns in words how many times as large as that with the table an error is; empty if the latter is rounding.
fn ratio_text(report: &Report<'_>, worst: &Worst) -> String {
    let left = report.answer.with_table.error_mm;
    if left <= ROUNDING_MM { String::new() } else { format!("{:.0} times that with the table", worst.error_mm / left) }
}

/// Returns an error and its place as a key number.
fn error_number(worst: &Worst, what: &str, against: String) -> KeyNumber {
    KeyNumber::new(&millimetres(worst.error_mm, 4), format!("{what}, {}", worst_place(worst)), against)
}

/// Returns place and force of an error in words.
pub(super) fn worst_place(worst: &Worst) -> String {
    let [x, y, z] = worst.position_mm;
    let force = nalgebra::Vector3::from(worst.force_N).norm();
    let under = if force == 0.0 { "without force".into() } else { format!("under {force:.0} N") };
    format!("at {} {under}", position(x, y, z))
}
