//! The pictures of a validation study: all quoted numbers in one, each against ours in tolerances, and what the study asks for.

use nalgebra::Vector3;

use super::compared::{Line, lines};
use crate::{
    answer::Quantity,
    figures::{
        AgreementFigure, AgreementRow, CurvePanel, Figure, LineFigure, LineSeries, Meant, PanelCurve, PanelFigure,
    },
    files::{
        table::{drives_of, kind_word},
        words::{if_any, typographic},
    },
    machine::{Machine, Motion},
    questions::{
        path::{
            AtPoint, PathResults,
            report::{displacement_along, drives},
        },
        validation::{FigureKind, Picture, Quoted, Relation, Shown, ValidationResults, resolve::MOST_FRAMES},
    },
    simulation::Source,
};

/// All pictures with their file stems: the numbers compared, and what the study asks for.
pub fn figures(results: &ValidationResults, shown: &Shown) -> Vec<(String, Figure)> {
    let picture = |picture: &Picture| {
        let path = &results.paths[picture.cases[0]];
        let drawn = match picture.kind {
            FigureKind::Paths => vec![paths(results, picture, path)],
            FigureKind::Superposition => vec![superposition(results, picture, path)],
            FigureKind::Curves => curves(results, picture),
            FigureKind::Sources => sources(results, picture, path),
        };
        picture.file_stems(&results.study.machine).into_iter().zip(drawn)
    };
    let answer = agreement(results).map(|figure| ("answer".to_string(), figure));
    answer.into_iter().chain(shown.pictures.iter().flat_map(picture)).collect()
}

fn subtitle(results: &ValidationResults, cases: &[usize]) -> String {
    let cases: Vec<&str> = cases.iter().map(|&case| results.study.cases[case].as_str()).collect();
    format!("{}, {}; {}", results.study.machine.short_title(), cases.join(", "), results.study.variants[0].name)
}

/// The wanted path with `error` added at each point.
fn moved(path: &PathResults, label: &str, dashed: bool, error: &dyn Fn(usize) -> Option<Vector3<f64>>) -> LineSeries {
    let at = |(k, point): (usize, Vector3<f64>)| error(k).map(|error| (point.x + error.x, point.y + error.y));
    LineSeries::new(label, path.study.wanted().into_iter().enumerate().filter_map(at).collect(), dashed)
}

fn plane(results: &ValidationResults, picture: &Picture, series: Vec<LineSeries>) -> Figure {
    Figure::Lines(LineFigure {
        title: picture.title.clone(),
        subtitle: format!("{}, seen along −z", subtitle(results, &picture.cases)),
        x_label: "x [mm]".into(),
        y_label: "y [mm]".into(),
        series,
        equal_axes: true,
        closed_note: Some("drawn to scale, errors not amplified".into()),
        ..LineFigure::default()
    })
}

fn paths(results: &ValidationResults, picture: &Picture, path: &PathResults) -> Figure {
    let by = |source| move |k| path.whole.displacement(source, k);
    let series = vec![
        moved(path, "1 target trajectory", false, &|_| Some(Vector3::zeros())),
        moved(path, "2 shifted by errors in serial chains", true, &by(Source::Errors)),
        moved(path, "3 shifted by the cutting force", true, &by(Source::Cutting)),
        moved(path, "4 shifted by both", false, &by(Source::All)),
        moved(path, "5 adjusted trajectory", false, &|k| path.whole.command_shift(&path.study, k)),
    ];
    plane(results, picture, series)
}

fn superposition(results: &ValidationResults, picture: &Picture, path: &PathResults) -> Figure {
    let by = |source| move |k| path.whole.displacement(source, k);
    let sum = |k| Some(by(Source::Cutting)(k)? + by(Source::Errors)(k)?);
    let series = vec![
        moved(path, "1 target trajectory", false, &|_| Some(Vector3::zeros())),
        moved(path, "2 shifted by errors in serial chains", true, &by(Source::Errors)),
        moved(path, "3 shifted by both: superposition", true, &sum),
        moved(path, "4 shifted by both: simultaneously", false, &by(Source::All)),
    ];
    plane(results, picture, series)
}

/// What curves over the tool angle show, its axis, and a name for each of them.
struct Drawn {
    what: String,
    y_label: String,
    curves: Vec<(String, Quantity<AtPoint>)>,
}

fn of_drives(machine: &Machine, kind: Motion, all: &[Quantity<AtPoint>]) -> Vec<(String, Quantity<AtPoint>)> {
    drives_of(machine, kind).map(|(drive, label)| (format!("drive {label}"), all[drive].clone())).collect()
}

/// Corrections of the drives, those of slides and of hinges apart.
fn corrections(machine: &Machine) -> impl Iterator<Item = Drawn> {
    let each = drives(machine).each;
    machine.drive_kinds().map(move |kind| Drawn {
        what: match machine.has_mixed_drives() {
            false => "drive corrections".into(),
            true => format!("corrections of {}", kind_word(machine, kind)),
        },
        y_label: format!("Δρ [{}]", kind.shown_position_unit()),
        curves: of_drives(machine, kind, &each),
    })
}

/// Their forces.
fn forces(machine: &Machine) -> impl Iterator<Item = Drawn> {
    let each = drives(machine).each;
    machine.drive_kinds().map(move |kind| Drawn {
        what: format!("drive {}s", kind.force_word()),
        y_label: format!("τ [{}]", kind.shown_force_unit()),
        curves: of_drives(machine, kind, &each[machine.drive_count()..]),
    })
}

fn displacement(what: &str) -> Drawn {
    let names = ["Δx", "Δy", "Δz"].map(String::from);
    Drawn {
        what: what.into(),
        y_label: "Δt [mm]".into(),
        curves: names.into_iter().zip(displacement_along()).collect(),
    }
}

/// A curve over the tool angle, broken where there is no value; it ends at the angle at which it begins.
fn over_angle(path: &PathResults, source: Source, quantity: &Quantity<AtPoint>) -> PanelCurve {
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

fn panels(
    results: &ValidationResults,
    picture: &Picture,
    (what, y_label): (&str, String),
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

/// Under all sources, a frame for each case.
fn curves(results: &ValidationResults, picture: &Picture) -> Vec<Figure> {
    let machine = &results.study.machine;
    let moved = displacement("displacement that is compensated");
    let figure = |Drawn { what, y_label, curves }: Drawn| {
        let frame = |&case: &usize| {
            let of_case = |(_, quantity): &(_, _)| over_angle(&results.paths[case], Source::All, quantity);
            CurvePanel { title: results.study.cases[case].clone(), curves: curves.iter().map(of_case).collect() }
        };
        let frames = picture.cases.iter().map(frame).collect();
        let names = curves.iter().map(|(name, _)| (name.clone(), false)).collect();
        panels(results, picture, (&what, y_label), names, frames)
    };
    corrections(machine).chain([moved]).chain(forces(machine)).map(figure).collect()
}

/// Of each source, a frame for each quantity.
fn sources(results: &ValidationResults, picture: &Picture, path: &PathResults) -> Vec<Figure> {
    let machine = &results.study.machine;
    let sources = Source::of(machine);
    let name = |source: &Source| match source {
        Source::Errors => "errors in serial chains",
        other => other.words(),
    };
    let figure = |Drawn { what, y_label, curves }: Drawn| {
        let frame = |(title, quantity): (String, Quantity<AtPoint>)| CurvePanel {
            title,
            curves: sources.iter().map(|source| over_angle(path, *source, &quantity)).collect(),
        };
        let frames = curves.into_iter().take(MOST_FRAMES).map(frame).collect();
        let names = sources.iter().map(|source| (name(source).to_string(), *source != Source::All)).collect();
        panels(results, picture, (&format!("{what} by source"), y_label), names, frames)
    };
    corrections(machine).chain([displacement("displacement")]).map(figure).collect()
}

/// The figure; `None` where nothing is quoted.
fn agreement(results: &ValidationResults) -> Option<Figure> {
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
    let (sign, meant) = match quoted.relation {
        Relation::About => ("", Meant::About),
        Relation::AtLeast => ("≥ ", Meant::AtLeast),
        Relation::AtMost => ("≤ ", Meant::AtMost),
    };
    let shown = if_any(ours, |ours| short(ours, quoted.value));
    AgreementRow {
        label: format!("{}: {}", line.case(), line.what()),
        // The unit as axes and files write it.
        numbers: typographic(&format!("{sign}{}, {shown}{}", quoted.value, line.unit().replace("N·mm", "Nmm"))),
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
