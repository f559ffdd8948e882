//! Figures of a validation study: the agreement of all quoted numbers, and those that the study asks for.

use nalgebra::Vector3;

use super::compared::{QuotedLine, lines};
use crate::{
    answer::{
        Quantity,
        drive_columns::{drives_of_kind, kind_word},
    },
    figures::{
        AgreementFigure, AgreementRow, Criterion, CurvePanel, Figure, LineFigure, LineSeries, PanelCurve, PanelFigure,
    },
    files::words::{or_dash, typographic},
    machine::{Machine, Motion},
    questions::{
        path::{
            PathResults, PointEffect,
            report::{displacement_components, drives},
        },
        validation::{FigureKind, Picture, Quoted, Relation, Shown, ValidationResults, resolve::MAX_FRAMES},
    },
    simulation::Source,
};

/// Draws all figures, with their file stems.
pub fn figures(results: &ValidationResults, shown: &Shown) -> Vec<(String, Figure)> {
    let picture = |picture: &Picture| {
        let path = &results.paths[picture.cases[0]];
        let drawn = match picture.kind {
            FigureKind::Paths => vec![paths_figure(results, picture, path)],
            FigureKind::Superposition => vec![superposition_figure(results, picture, path)],
            FigureKind::Curves => curves_by_case(results, picture),
            FigureKind::Sources => curves_by_source(results, picture, path),
        };
        picture.file_stems(&results.study.machine).into_iter().zip(drawn)
    };
    let answer = agreement(results).map(|figure| ("answer".to_string(), figure));
    answer.into_iter().chain(shown.pictures.iter().flat_map(picture)).collect()
}

/// Returns the subtitle of a figure: machine, cases, process.
fn subtitle(results: &ValidationResults, cases: &[usize]) -> String {
    let cases: Vec<&str> = cases.iter().map(|&case| results.study.cases[case].as_str()).collect();
    format!("{}, {}; {}", results.study.machine.name, cases.join(", "), results.study.variants[0].name)
}

/// Returns the target path in the xy-plane with `error` (mm, by index of the point) added, as a line, without points that have none (`None`).
fn shifted(path: &PathResults, label: &str, dashed: bool, error: &dyn Fn(usize) -> Option<Vector3<f64>>) -> LineSeries {
    let at = |(k, point): (usize, Vector3<f64>)| error(k).map(|error| (point.x + error.x, point.y + error.y));
    LineSeries::new(label, path.study.wanted_positions().into_iter().enumerate().filter_map(at).collect(), dashed)
}

/// Makes a figure of lines in the xy-plane.
fn xy_figure(results: &ValidationResults, picture: &Picture, series: Vec<LineSeries>) -> Figure {
    let subtitle = format!("{}, seen along −z", subtitle(results, &picture.cases));
    Figure::Lines(LineFigure {
        equal_axes: true,
        closed_note: Some("drawn to scale, errors not amplified".into()),
        ..LineFigure::new(&picture.title, subtitle, ["x [mm]", "y [mm]"], series)
    })
}

/// Draws the target path, the path displaced by each source and by both, and the commanded path.
fn paths_figure(results: &ValidationResults, picture: &Picture, path: &PathResults) -> Figure {
    let by = |source| move |k| path.whole.displacement(source, k);
    let series = vec![
        shifted(path, "1 target trajectory", false, &|_| Some(Vector3::zeros())),
        shifted(path, "2 shifted by errors in serial chains", true, &by(Source::Geometry)),
        shifted(path, "3 shifted by the cutting force", true, &by(Source::Cutting)),
        shifted(path, "4 shifted by both", false, &by(Source::All)),
        shifted(path, "5 adjusted trajectory", false, &|k| path.whole.command_shift(&path.study, k)),
    ];
    xy_figure(results, picture, series)
}

/// Draws the target path, and the path displaced by chain errors, by the sum of both sources, and by both at once.
fn superposition_figure(results: &ValidationResults, picture: &Picture, path: &PathResults) -> Figure {
    let by = |source| move |k| path.whole.displacement(source, k);
    let sum = |k| Some(by(Source::Cutting)(k)? + by(Source::Geometry)(k)?);
    let series = vec![
        shifted(path, "1 target trajectory", false, &|_| Some(Vector3::zeros())),
        shifted(path, "2 shifted by errors in serial chains", true, &by(Source::Geometry)),
        shifted(path, "3 shifted by both: superposition", true, &sum),
        shifted(path, "4 shifted by both: simultaneously", false, &by(Source::All)),
    ];
    xy_figure(results, picture, series)
}

/// Curves over the tool angle with one axis, each with its name.
struct CurveGroup {
    what: String,
    y_label: String,
    curves: Vec<(String, Quantity<PointEffect>)>,
}

/// Returns label and quantity of each drive of this `kind`; `all` are the quantities of all drives, in their order.
fn kind_curves(machine: &Machine, kind: Motion, all: &[Quantity<PointEffect>]) -> Vec<(String, Quantity<PointEffect>)> {
    drives_of_kind(machine, kind).map(|(drive, label)| (format!("drive {label}"), all[drive].clone())).collect()
}

/// Returns the corrections of the drives, those of prismatic and of revolute ones apart.
fn corrections(machine: &Machine) -> impl Iterator<Item = CurveGroup> {
    let each = drives(machine).each;
    machine.drive_kinds().map(move |kind| CurveGroup {
        what: match machine.has_mixed_drives() {
            false => "drive corrections".into(),
            true => format!("corrections of {}", kind_word(machine, kind)),
        },
        y_label: format!("Δρ [{}]", kind.shown_position_unit()),
        curves: kind_curves(machine, kind, &each),
    })
}

/// Returns the forces of the drives, those of prismatic and of revolute ones apart.
fn forces(machine: &Machine) -> impl Iterator<Item = CurveGroup> {
    let each = drives(machine).each;
    machine.drive_kinds().map(move |kind| CurveGroup {
        what: format!("drive {}s", kind.force_word()),
        y_label: format!("τ [{}]", kind.shown_force_unit()),
        curves: kind_curves(machine, kind, &each[machine.drive_count()..]),
    })
}

/// Returns the components of the displacement of the tool, called `what` in titles.
fn displacement(what: &str) -> CurveGroup {
    let names = ["Δx", "Δy", "Δz"].map(String::from);
    CurveGroup {
        what: what.into(),
        y_label: "Δt [mm]".into(),
        curves: names.into_iter().zip(displacement_components()).collect(),
    }
}

/// Returns a curve of a quantity over the tool angle, closed over a turn, and broken where there is no value.
fn over_angle(path: &PathResults, source: Source, quantity: &Quantity<PointEffect>) -> PanelCurve {
    let mut order: Vec<(f64, usize)> =
        path.study.stations.iter().enumerate().filter_map(|(k, station)| Some((station.phi_deg?, k))).collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0));
    let first = order.first().map(|&(phi, k)| (phi + 360.0, k));
    let mut pieces = vec![Vec::new()];
    for (phi, k) in order.into_iter().chain(first) {
        match quantity.value(path.whole.at(source, k)) {
            Some(value) => pieces.last_mut().into_iter().for_each(|piece: &mut Vec<_>| piece.push((phi, value))),
            None => pieces.push(Vec::new()),
        }
    }
    PanelCurve { pieces }
}

/// Makes a figure of panels over the tool angle, with the names of its curves and whether they are dashed.
fn panels(
    results: &ValidationResults,
    picture: &Picture,
    what: &str,
    y_label: String,
    curves: Vec<(String, bool)>,
    panels: Vec<CurvePanel>,
) -> Figure {
    Figure::Panels(PanelFigure {
        title: format!("{}: {what}", picture.title),
        subtitle: subtitle(results, &picture.cases),
        x_label: "tool angle φ [°]".into(),
        y_label,
        curves,
        panels,
        equal_axes: false,
        note: String::new(),
    })
}

/// Draws corrections, displacement and forces under all sources, a panel for each case.
fn curves_by_case(results: &ValidationResults, picture: &Picture) -> Vec<Figure> {
    let machine = &results.study.machine;
    let moved = displacement("displacement that is compensated");
    let figure = |CurveGroup { what, y_label, curves }: CurveGroup| {
        let frame = |&case: &usize| {
            let of_case = |(_, quantity): &(_, _)| over_angle(&results.paths[case], Source::All, quantity);
            CurvePanel { title: results.study.cases[case].clone(), curves: curves.iter().map(of_case).collect() }
        };
        let frames = picture.cases.iter().map(frame).collect();
        let names = curves.iter().map(|(name, _)| (name.clone(), false)).collect();
        panels(results, picture, &what, y_label, names, frames)
    };
    corrections(machine).chain([moved]).chain(forces(machine)).map(figure).collect()
}

/// Draws corrections and displacement of one case, a panel for each component, a curve for each source.
fn curves_by_source(results: &ValidationResults, picture: &Picture, path: &PathResults) -> Vec<Figure> {
    let machine = &results.study.machine;
    let sources = Source::of(machine);
    let name = |source: &Source| match source {
        Source::Geometry => "errors in serial chains",
        other => other.text(),
    };
    let figure = |CurveGroup { what, y_label, curves }: CurveGroup| {
        let frame = |(title, quantity): (String, Quantity<PointEffect>)| CurvePanel {
            title,
            curves: sources.iter().map(|source| over_angle(path, *source, &quantity)).collect(),
        };
        let frames = curves.into_iter().take(MAX_FRAMES).map(frame).collect();
        let names = sources.iter().map(|source| (name(source).to_string(), *source != Source::All)).collect();
        panels(results, picture, &format!("{what} by source"), y_label, names, frames)
    };
    corrections(machine).chain([displacement("displacement")]).map(figure).collect()
}

/// Draws the agreement of all quoted numbers; `None` where nothing is quoted.
fn agreement(results: &ValidationResults) -> Option<Figure> {
    let study = &results.study;
    let mut rows: Vec<AgreementRow> = lines(results).map(|line| agreement_row(&line)).collect();
    rows.sort_by_key(|row| row.agrees);
    let agreeing = rows.iter().filter(|row| row.agrees).count();
    (!rows.is_empty()).then(|| {
        Figure::Agreement(AgreementFigure {
            title: format!("{agreeing} of {} quoted numbers agree", rows.len()),
            subtitle: format!("{}; {}", study.machine.name, study.variants[0].name),
            numbers: ["quoted", "ours"].map(String::from),
            rows,
        })
    })
}

/// Returns the row of one quoted number in the figure of agreement.
fn agreement_row(line: &QuotedLine<'_>) -> AgreementRow {
    let (quoted, ours) = (line.quoted, line.ours());
    let (sign, criterion) = match quoted.relation {
        Relation::About => ("", Criterion::About),
        Relation::AtLeast => ("≥ ", Criterion::AtLeast),
        Relation::AtMost => ("≤ ", Criterion::AtMost),
    };
    let shown = or_dash(ours, |ours| short_number(ours, quoted.value));
    AgreementRow {
        label: format!("{}: {}", line.case(), line.what()),
        // The unit as axes and files write it.
        numbers: [
            typographic(&format!("{sign}{}", quoted.value)),
            typographic(&format!("{shown}{}", line.unit_suffix().replace("N·mm", "Nmm"))),
        ],
        criterion,
        difference: ours.map(|ours| in_tolerances(quoted, ours)),
        agrees: line.compared.agrees,
    }
}

/// Largest difference that is drawn, in tolerances; larger ones are drawn there.
const FAR: f64 = 1e3;

/// Returns `ours` less the quoted value, in tolerances, at most [`FAR`] either way.
fn in_tolerances(quoted: &Quoted, ours: f64) -> f64 {
    let difference = ours - quoted.value;
    let share = difference / quoted.allowed();
    match share.is_finite() {
        true => share.clamp(-FAR, FAR),
        false if difference == 0.0 => 0.0,
        false => FAR.copysign(difference),
    }
}

/// Formats a value of the model with three digits, and no more decimals than show beside the quoted one.
pub fn short_number(ours: f64, quoted: f64) -> String {
    let size = ours.abs().max(quoted.abs());
    let decimals = if size > 0.0 { (2.0 - libm::log10(size).floor()).clamp(0.0, 4.0) as usize } else { 0 };
    let text = format!("{ours:.decimals$}");
    if text.trim_start_matches('-').chars().all(|c| c == '0' || c == '.') { "0".into() } else { text }
}
