//! Figures of a path study: curves along the path, and drawings of the displaced path.

use nalgebra::Vector3;

use super::{
    cutting_force::{self, ForceCurves},
    on_part::PathDrawing,
    quantities::{DISPLACEMENT, MEDIAN_RESIDUAL, P95_DISPLACEMENT, P95_RESIDUAL, WITHOUT_FORCE, drives},
    thinned::{Curve, points_per_step},
};
use crate::{
    answer::{
        Quantity,
        drive_columns::{drives_of_kind, kind_word},
    },
    figures::{Figure, LineFigure, LineSeries},
    files::words::counted,
    machine::Motion,
    questions::path::{PathPart, PathStudy, PointEffect, Shown, Station},
    simulation::Source,
};

/// A figure of curves along the path.
struct CurveFigure {
    stem: String,
    title: String,
    y_label: String,
    lines: Vec<FigureCurve>,
}

/// A curve of a figure, collected point by point and thinned where the path is long.
struct FigureCurve {
    label: String,
    dashed: bool,
    curve: Curve,
    value: Box<Value>,
}

/// What is drawn at a point.
type Value = dyn Fn(&PathPart, usize) -> Option<f64> + Send;

/// The figures of a study, collected part by part.
pub(super) struct Pictures<'a> {
    study: &'a PathStudy,
    shown: Shown,
    drawn: Vec<CurveFigure>,
    on_part: PathDrawing<'a>,
}

impl<'a> Pictures<'a> {
    /// Makes the figures of `study` without points yet.
    pub fn new(study: &'a PathStudy, shown: Shown) -> Self {
        Self { study, shown, drawn: curve_figures(study), on_part: PathDrawing::new(study) }
    }

    /// Adds the points of the next part.
    pub fn add(&mut self, part: &PathPart) {
        for k in part.points() {
            self.on_part.add(part, k);
            let Some(x) = horizontal_position(self.shown, &self.study.stations[k]) else { continue };
            for line in self.drawn.iter_mut().flat_map(|drawn| &mut drawn.lines) {
                (line.value)(part, k).into_iter().for_each(|value| line.curve.add(k, x, value));
            }
        }
    }

    /// Returns all figures with their file stems.
    pub fn figures(self) -> Vec<(String, Figure)> {
        let of_lines = |drawn: &CurveFigure| {
            let series = drawn.lines.iter().map(|line| self.series(&line.label, line.dashed, &line.curve));
            (drawn.stem.clone(), self.figure(&drawn.title, &drawn.y_label, series.collect()))
        };
        // What each source asks of a drive is shown last.
        let (of_path, by_source) = self.drawn.split_at(self.drawn.len() - self.study.machine.drive_count());
        let is_drawn = |drawn: &&CurveFigure| drawn.lines.iter().any(|line| !line.curve.points().is_empty());
        let mut figures = vec![("answer".to_string(), self.on_part.magnified_figure(self.shown))];
        figures.extend(of_path.iter().filter(is_drawn).map(of_lines));
        figures.extend(self.cutting_force().map(|figure| ("cutting_force".to_string(), figure)));
        figures.push(("paths".to_string(), self.on_part.top_view_figure()));
        figures.extend(by_source.iter().filter(is_drawn).map(of_lines));
        figures
    }

    /// Draws components and norm of the cutting force; `None` if there is no force.
    fn cutting_force(&self) -> Option<Figure> {
        let mut curves = ForceCurves::new(self.study.tasks.len());
        for (station, task) in self.study.stations.iter().zip(&self.study.tasks) {
            curves.add(horizontal_position(self.shown, station), task);
        }
        let series = curves.labelled_curves().into_iter().map(|(label, curve)| {
            let is_size = label == cutting_force::SIZE;
            self.series(&label, is_size, curve)
        });
        let series: Vec<LineSeries> = series.collect();
        (!series.is_empty()).then(|| self.figure(cutting_force::TITLE, "force [N]", series))
    }

    /// Makes a figure over the length of the path, or over φ on a circle.
    fn figure(&self, title: &str, y_label: &str, series: Vec<LineSeries>) -> Figure {
        let points = self.study.stations.len();
        let thinned = match points_per_step(points) {
            1 => String::new(),
            step => format!(", the smallest and the largest value of each {step} drawn"),
        };
        let subtitle = format!("{}, {}{thinned}", self.study.machine.name, counted(points, "point"));
        let x_label = if self.shown.is_circle { "tool angle φ [°]" } else { "path length [mm]" };
        Figure::Lines(LineFigure::new(title, subtitle, [x_label, y_label], series))
    }

    /// Makes a series of a curve, closed to one revolution on a circle.
    fn series(&self, label: &str, dashed: bool, curve: &Curve) -> LineSeries {
        let mut points = curve.points();
        if self.shown.is_circle {
            points.sort_by(|a, b| a.0.total_cmp(&b.0));
            // One turn: the curve ends at the angle at which it begins.
            points.extend(points.first().map(|&(phi, value)| (phi + 360.0, value)));
        }
        LineSeries::new(label, points, dashed)
    }
}

/// Returns the horizontal position of a point: φ in degrees on a circle, else the length along the path, mm; `None` where a point of a circle has no
/// φ.
fn horizontal_position(shown: Shown, station: &Station) -> Option<f64> {
    if shown.is_circle { station.phi_deg } else { Some(station.arc_length_mm) }
}

/// Lists the figures of curves, still empty: displacements, drive corrections and forces, and the correction of each drive by source.
fn curve_figures(study: &PathStudy) -> Vec<CurveFigure> {
    let machine = &study.machine;
    let line = |label: String, dashed: bool, value: Box<Value>| FigureCurve {
        label,
        dashed,
        curve: Curve::new(study.stations.len()),
        value,
    };
    let of = |label: String, dashed: bool, source: Source, quantity: &Quantity<PointEffect>| {
        let quantity = quantity.clone();
        line(label, dashed, Box::new(move |part, k| quantity.value(part.at(source, k))))
    };
    let by_source = |quantity: &Quantity<PointEffect>| -> Vec<FigureCurve> {
        let sources = Source::of(machine).iter();
        sources.map(|source| of(source.text().into(), *source != Source::All, *source, quantity)).collect()
    };
    let of_drives = |kind: Motion, quantities: &[Quantity<PointEffect>]| -> Vec<FigureCurve> {
        let drives = drives_of_kind(machine, kind);
        drives.map(|(drive, label)| of(format!("drive {label}"), false, Source::All, &quantities[drive])).collect()
    };
    let mut distances = by_source(&DISPLACEMENT);
    // Directions differ, and so do the places of the peaks: lengths do not add up.
    let parts = Source::parts(machine);
    let sum = format!("vector sum of the {}", if parts.len() == 2 { "two" } else { "three" });
    distances.push(line(
        sum,
        true,
        Box::new(|part, k| {
            let displacements = parts.iter().map(|source| part.displacement(*source, k));
            displacements.sum::<Option<Vector3<f64>>>().map(|sum| sum.norm())
        }),
    ));
    let mut all = vec![CurveFigure {
        stem: "displacement".into(),
        title: "Distance from the path without compensation".into(),
        y_label: "|Δt| [mm]".into(),
        lines: distances,
    }];
    if study.uncertainty.is_some() {
        let of_all = |label: &str, dashed, quantity| of(label.into(), dashed, Source::All, &quantity);
        all.push(CurveFigure {
            stem: "spread".into(),
            title: "Distance from the path where inputs are uncertain".into(),
            y_label: "distance [mm]".into(),
            lines: vec![
                of_all("without compensation, nominal", true, DISPLACEMENT),
                of_all("without compensation, 95 % below", false, P95_DISPLACEMENT),
                of_all("compensated, median", true, MEDIAN_RESIDUAL),
                of_all("compensated, 95 % below", false, P95_RESIDUAL),
                of_all("compensated, no cutting force", true, WITHOUT_FORCE),
            ],
        });
    }
    let each = drives(machine).each;
    let (corrections, forces) = each.split_at(machine.drive_count());
    all.extend(machine.drive_kinds().map(|kind| CurveFigure {
        stem: match machine.has_mixed_drives() {
            false => "delta_rho".into(),
            true => format!("delta_rho_{}", kind.label()),
        },
        title: format!("Corrections of the {}", kind_word(machine, kind)),
        y_label: format!("Δρ [{}]", kind.shown_position_unit()),
        lines: of_drives(kind, corrections),
    }));
    all.extend(machine.drive_kinds().map(|kind| CurveFigure {
        stem: format!("drive_{}", kind.force_word()),
        title: format!("Drive {}s along the compensated path", kind.force_word()),
        y_label: format!("τ [{}]", kind.shown_force_unit()),
        lines: of_drives(kind, forces),
    }));
    for kind in machine.drive_kinds() {
        all.extend(drives_of_kind(machine, kind).map(|(drive, label)| CurveFigure {
            stem: format!("delta_rho_sources_{label}"),
            title: format!("Which source asks drive {label} for what"),
            y_label: format!("Δρ {label} [{}]", kind.shown_position_unit()),
            lines: by_source(&corrections[drive]),
        }));
    }
    all
}
