//! Page and maps of a correction table.

use super::{CorrectionFormat, Report, tables::comp_ini, text};
use crate::{
    answer::{facts_of, grid_view, machine::described},
    figures::{Figure, Limit, Shading, SliceFigure, SlicePanel},
    files::words::typographic,
    page::{Better, Description, Explorer, Fact, Group, Quantity, Section, TableNote},
    process::uncertainty::Draws,
    products::correction::{CorrectionQuestion, ResidualPoint},
    questions::spread_report,
    simulation::ROUNDING_MM,
};

/// Returns the page with its sections, facts, views and tables; first screen and figures are added later.
pub(super) fn page(report: &Report<'_>) -> Description {
    let question = report.question;
    let has_table = report.has(CorrectionFormat::Csv);
    let caption = "One row per node: the coefficients of each drive.";
    let mut tables = vec![TableNote::ranked(
        "residual.csv",
        "One row per point and way to correct, worst over no force and the largest one along each axis.",
        "error_mm",
    )];
    tables.extend(has_table.then(|| TableNote::new("correction.csv", caption)));
    let caption = "One row per check position and way to correct, worst over its loads in each draw.";
    tables.extend(report.answer.spread.is_some().then(|| TableNote::ranked("field.csv", caption, "error_p95_mm")));
    Description {
        name: format!("Correction table of {}", question.machine.name),
        question: "What must a controller add to the drives so that the loaded tool stays where it is wanted?".into(),
        setting: setting_facts(report),
        terms: vec![
            Fact::new("Positions", "of the platform point P, from the origin of the machine's base"),
            Fact::new("Error", "distance of the loaded tool from where it is wanted, as far as the drives control it"),
        ],
        explorers: vec![residual_explorer(report)],
        tables,
        sections: sections(report),
        ..Description::new("correction", described(&question.machine))
    }
}

/// Title of the view of residual errors.
const MAP: &str = "Residual error";

/// Returns the sections of the page.
fn sections(report: &Report<'_>) -> Vec<Section> {
    let mut table =
        Section::new("How is the table used?", "positions, forces, interpolation").text(&text::how_to_use(report));
    if report.has(CorrectionFormat::Csv) {
        table = table.tables(["correction.csv"]);
    }
    let mut joints = Section::new("And with a table for each joint alone?", "what controls have for errors of screws")
        .text(&text::per_joint_text(report));
    if let Ok((tables, _)) = &report.answer.per_joint {
        joints = joints.figures(&["slices_error_per_joint"]);
        if report.has(CorrectionFormat::Comp) {
            joints = joints.to_copy(comp_ini(tables));
        }
    }
    let field = Section::new("What is left on machines as they may be?", "where inputs are uncertain")
        .text(&text::field_text(report))
        .tables(["field.csv"]);
    let mut all = Vec::from_iter(report.field().map(|_| field));
    all.extend([
        Section::new("Where is the residual error?", "without correction, with the table, with exact corrections")
            .text(&text::residual_text(report))
            .explorers([MAP])
            .figures(&["slices_error_none", "slices_error_table", "slices_error_exact"])
            .tables(["residual.csv"]),
        table,
        joints,
    ]);
    all
}

/// Returns the facts about machine, box, forces and tolerance that the page lists.
fn setting_facts(report: &Report<'_>) -> Vec<Fact> {
    let question = report.question;
    let [min, max] = question.corners;
    let span = |axis: usize| {
        let name = ["x", "y", "z"][axis];
        match min[axis] < max[axis] {
            true => format!("{name} {} to {}", rounded(min[axis]), rounded(max[axis])),
            false => format!("{name} {}", rounded(min[axis])),
        }
    };
    let (uncertain, tolerance) = (question.uncertainty.as_ref(), question.tolerance_mm);
    let tolerance = match uncertain {
        None => format!("{tolerance} mm"),
        Some(_) => format!(
            "{} mm on real machines; the table was made to be within {tolerance} mm with nominal numbers",
            question.judged_mm
        ),
    };
    let facts = [
        Fact::new("box", typographic(&format!("{} mm, positions of P", [0, 1, 2].map(span).join(", ")))),
        Fact::new("forces", format!("up to {} N on the tool tip, in any direction", report.force())),
        Fact::new("tolerance", tolerance),
        Fact::new("table", format!("{} nodes", report.size())),
        Fact::new("compensation holds", question.target.text()),
    ];
    let draws = uncertain.map(|_| spread_report::fact_of_draws(uncertain, Draws::PER_SCRAMBLE));
    facts_of(&question.machine, &question.errors, facts.into_iter().chain(draws))
}

/// Returns `value` rounded to 1e-6, without the digits of rounding errors.
fn rounded(value: f64) -> f64 {
    (value * 1e6).round() / 1e6
}

/// Returns the interactive map of the largest residual error at each grid point, mm, with a selector of the correction method.
fn residual_explorer(report: &Report<'_>) -> Explorer {
    let method_count = report.residuals.first().map_or(0, |point| point.residual_mm.len());
    let methods = ResidualPoint::CORRECTION_METHODS.into_iter().take(method_count);
    let group = Group::by_column("correction", "correction", methods.map(|[word, label, _]| (word, label)));
    let quantity = Quantity::new(["error_mm"], "largest error of the tool", "mm", Better::Smaller);
    grid_view(&report.question.machine, MAP, "residual.csv", Some(group), vec![quantity])
}

/// Most planes of a figure.
const PLANES: usize = 3;
const AXES: [&str; 3] = ["x", "y", "z"];

/// Returns the maps of the residual errors by file name, that with the table first as `answer`; none where the box has no area.
pub(super) fn figures(report: &Report<'_>) -> Vec<(String, Figure)> {
    let Some(plane) = slice_axes(report.question) else { return Vec::new() };
    let method_count = report.residuals.first().map_or(0, |point| point.residual_mm.len());
    let map = |method: usize| Figure::Slices(slice_figure(report, plane, method));
    let table = ("answer".to_string(), map(TABLE));
    let methods = ResidualPoint::CORRECTION_METHODS.into_iter().take(method_count).enumerate();
    let all = methods.map(|(method, [word, ..])| (format!("slices_error_{word}"), map(method)));
    std::iter::once(table).chain(all).collect()
}

/// Positions of the table and of exact corrections in [`ResidualPoint::CORRECTION_METHODS`].
const TABLE: usize = 1;
const EXACT: usize = 2;

/// Returns the common colour range of the maps with the table and with exact corrections, from 0, mm; `None` for others.
fn colour_range(report: &Report<'_>, method: usize) -> Option<(f64, f64)> {
    let errors = report.residuals.iter().map(|point| point.residual_mm[TABLE]);
    [TABLE, EXACT].contains(&method).then(|| (0.0, errors.fold(report.question.tolerance_mm, f64::max)))
}

/// Returns the axes of O across, up and through the maps; `None` where the box has no area.
fn slice_axes(question: &CorrectionQuestion) -> Option<[usize; 3]> {
    let mut axes: Vec<usize> = question.axes().collect();
    axes.extend((0..3).filter(|axis| !question.axes().any(|used| used == *axis)));
    (question.axes().count() >= 2).then(|| [axes[0], axes[1], axes[2]])
}

/// Returns the map of the residual errors of one correction method, in planes through the box.
fn slice_figure(report: &Report<'_>, [across, up, through]: [usize; 3], method: usize) -> SliceFigure {
    let grid = report.grid;
    let value = |i: usize, j: usize, k: usize| {
        let mut node = [0; 3];
        (node[across], node[up], node[through]) = (i, j, k);
        let error = report.residuals[grid.index(node)].residual_mm[method];
        // Rounding is no pattern.
        Some(if error <= ROUNDING_MM { 0.0 } else { error })
    };
    let count = grid.axes[through].len();
    let mut planes: Vec<usize> = (0..PLANES).map(|k| k * (count - 1) / (PLANES - 1)).collect();
    planes.dedup();
    let panel = |&k: &usize| SlicePanel {
        title: typographic(&format!("{} = {:.2} mm", AXES[through], grid.axes[through][k])),
        x: grid.axes[across].clone(),
        y: grid.axes[up].clone(),
        values: (0..grid.axes[up].len())
            .flat_map(|j| (0..grid.axes[across].len()).map(move |i| (i, j)))
            .map(|(i, j)| value(i, j, k))
            .collect(),
        marks: Vec::new(),
    };
    SliceFigure {
        title: ResidualPoint::CORRECTION_METHODS[method][2].into(),
        subtitle: format!(
            "{}, forces of {} N along each axis and none, table of {} nodes",
            report.question.machine.name,
            report.force(),
            report.size()
        ),
        x_label: format!("{} [mm]", AXES[across]),
        y_label: format!("{} [mm]", AXES[up]),
        quantity: "largest error of the tool [mm]".into(),
        panels: planes.iter().map(panel).collect(),
        range: colour_range(report, method),
        limit: (method == TABLE).then_some(Limit::Most(report.question.tolerance_mm)),
        shading: Shading::Ordered,
        remark: String::new(),
        missing: "no solution".into(),
    }
}
