//! Which pictures a path study gives.

use nalgebra::Vector3;

use crate::{
    figures::{Figure, LineFigure, LineSeries, amplification::amplification},
    files::{
        table::{drives_of, kind_word, shown_positions},
        words::counted,
    },
    machine::Motion,
    questions::path::{
        PathPart, PathStudy, Shown, Station,
        report::{
            cutting_force::{self, ForceCurves},
            magnified::{self, Moved},
            thinned::{Curve, drawn, step},
        },
    },
    simulation::{BySource, Source},
};

/// The values that pictures show, gathered part by part: a long path is thinned.
#[derive(Debug, Clone)]
pub struct Pictures {
    shown: Shown,
    /// |Δt| of each source, mm.
    displacement: BySource<Curve>,
    /// Length of the sum of the single sources' Δt, mm.
    superposed: Curve,
    /// Δρ of each drive, by source, in the unit of its kind.
    correction: BySource<Vec<Curve>>,
    /// τ of each drive under both sources, N or N·mm.
    force: Vec<Curve>,
    /// Points at which the path is drawn, ascending.
    drawn: Vec<usize>,
    /// What is added to the path there.
    shifts: Vec<Shifts>,
    /// The largest displacement by all sources and its point, mm.
    worst: Option<(usize, Vector3<f64>)>,
}

/// What is added to a point of the path to draw it, O axes, mm.
#[derive(Debug, Clone)]
struct Shifts {
    /// Displacements by the sources.
    displacement: BySource<Option<Vector3<f64>>>,
    commanded: Option<Vector3<f64>>,
    /// What compensation leaves.
    left: Option<Vector3<f64>>,
}

impl Pictures {
    /// For `study`, none of its points seen.
    pub fn new(study: &PathStudy, shown: Shown) -> Self {
        let curve = || Curve::new(study.stations.len());
        let of_drives = || vec![curve(); study.machine.drive_count()];
        Self {
            shown,
            displacement: BySource::of(&study.machine, |_| curve()),
            superposed: curve(),
            correction: BySource::of(&study.machine, |_| of_drives()),
            force: of_drives(),
            drawn: drawn(&study.wanted()),
            shifts: Vec::new(),
            worst: None,
        }
    }

    /// Takes the next part.
    pub fn add(&mut self, study: &PathStudy, part: &PathPart) {
        for k in part.points() {
            let displacement = BySource::of(&study.machine, |source| part.displacement(source, k));
            if let Some(moved) = displacement[Source::All]
                && self.worst.is_none_or(|(_, most)| moved.norm() > most.norm())
            {
                self.worst = Some((k, moved));
            }
            if self.drawn.get(self.shifts.len()) == Some(&k) {
                let left = part.compensated(Source::All, k).map(|answer| answer.position_error);
                let displacement = displacement.clone();
                self.shifts.push(Shifts { displacement, commanded: part.command_shift(study, k), left });
            }
            let Some(x) = along(self.shown, &study.stations[k]) else { continue };
            for (source, curve) in self.displacement.iter_mut() {
                displacement[source].iter().for_each(|d| curve.add(k, x, d.norm()));
            }
            let parts = Source::parts(&study.machine).iter().map(|source| displacement[*source]);
            if let Some(sum) = parts.sum::<Option<Vector3<f64>>>() {
                self.superposed.add(k, x, sum.norm());
            }
            for (source, curves) in self.correction.iter_mut() {
                let Some(answer) = part.compensated(source, k) else { continue };
                let corrections = shown_positions(&study.machine, &answer.delta_rho());
                curves.iter_mut().zip(corrections).for_each(|(curve, value)| curve.add(k, x, value));
                if source == Source::All {
                    self.force.iter_mut().zip(&answer.drive_forces).for_each(|(curve, force)| curve.add(k, x, *force));
                }
            }
        }
    }

    /// All pictures with their file stems.
    pub fn figures(&self, study: &PathStudy) -> Vec<(String, Figure)> {
        let machine = &study.machine;
        let mut figures = vec![("answer".to_string(), self.magnified(study))];
        figures.push(("displacement".to_string(), self.displacement(study)));
        figures.extend(machine.drive_kinds().map(|kind| {
            let stem = match machine.has_mixed_drives() {
                false => "delta_rho".to_string(),
                true => format!("delta_rho_{}", kind_word(machine, kind)),
            };
            (stem, self.corrections(study, kind))
        }));
        figures.extend(
            machine.drive_kinds().map(|kind| (format!("drive_{}", kind.force_word()), self.forces(study, kind))),
        );
        figures.extend(self.cutting_force(study).map(|figure| ("cutting_force".to_string(), figure)));
        figures.push(("paths".to_string(), self.paths(study)));
        for kind in machine.drive_kinds() {
            for (drive, label) in drives_of(machine, kind) {
                let figure = self.correction_by_source(study, kind, drive, &label);
                figures.push((format!("delta_rho_sources_{label}"), figure));
            }
        }
        figures
    }

    fn magnified(&self, study: &PathStudy) -> Figure {
        let points = self.drawn.iter().zip(&self.shifts);
        let moved =
            |(&point, shifts): (&usize, &Shifts)| Moved { point, displacement: shifts.displacement[Source::All] };
        magnified::figure(study, &points.map(moved).collect::<Vec<_>>(), self.worst, self.shown.is_circle)
    }

    fn displacement(&self, study: &PathStudy) -> Figure {
        let of_source =
            |(source, curve): (Source, &Curve)| series(self.shown, source.words(), source != Source::All, curve);
        let mut all: Vec<LineSeries> = self.displacement.iter().map(of_source).collect();
        // Directions differ, and so do the places of the peaks: lengths do not add up.
        let parts = if Source::parts(&study.machine).len() == 2 { "two" } else { "three" };
        let sum = format!("vector sum of the {parts}");
        all.push(series(self.shown, sum, true, &self.superposed));
        self.line_figure(study, "Distance from the path without compensation", "|Δt| [mm]".into(), all)
    }

    fn corrections(&self, study: &PathStudy, kind: Motion) -> Figure {
        let all = self.of_drives(study, kind, &self.correction[Source::All]);
        let title = format!("What the {} must be told instead", kind_word(&study.machine, kind));
        self.line_figure(study, &title, format!("Δρ [{}]", kind.shown_position_unit()), all)
    }

    fn forces(&self, study: &PathStudy, kind: Motion) -> Figure {
        let title = format!("Drive {}s along the compensated path", kind.force_word());
        self.line_figure(
            study,
            &title,
            format!("τ [{}]", kind.shown_force_unit()),
            self.of_drives(study, kind, &self.force),
        )
    }

    /// Components and size of the cutting force, if there is any.
    fn cutting_force(&self, study: &PathStudy) -> Option<Figure> {
        let mut curves = ForceCurves::new(study.demands.len());
        for (station, demand) in study.stations.iter().zip(&study.demands) {
            curves.add(along(self.shown, station), demand);
        }
        let of_curve =
            |(label, curve): (String, &Curve)| series(self.shown, &label, label == cutting_force::SIZE, curve);
        let all: Vec<LineSeries> = curves.labelled().into_iter().map(of_curve).collect();
        (!all.is_empty()).then(|| self.line_figure(study, cutting_force::TITLE, "force [N]".into(), all))
    }

    fn correction_by_source(&self, study: &PathStudy, kind: Motion, drive: usize, label: &str) -> Figure {
        let of_source = |(source, curves): (Source, &Vec<Curve>)| {
            series(self.shown, source.words(), source != Source::All, &curves[drive])
        };
        let all = self.correction.iter().map(of_source).collect();
        let title = format!("Which source asks drive {label} for what");
        self.line_figure(study, &title, format!("Δρ {label} [{}]", kind.shown_position_unit()), all)
    }

    /// The curves of the drives of one kind.
    fn of_drives(&self, study: &PathStudy, kind: Motion, curves: &[Curve]) -> Vec<LineSeries> {
        let drives = drives_of(&study.machine, kind);
        drives.map(|(drive, label)| series(self.shown, format!("drive {label}"), false, &curves[drive])).collect()
    }

    fn line_figure(&self, study: &PathStudy, title: &str, y_label: String, series: Vec<LineSeries>) -> Figure {
        let thinned = match step(study.stations.len()) {
            1 => String::new(),
            step => format!(", the smallest and the largest value of each {step} drawn"),
        };
        let x_label = if self.shown.is_circle { "tool angle φ [°]" } else { "path length [mm]" };
        Figure::Lines(LineFigure {
            title: title.into(),
            subtitle: format!("{}, {}{thinned}", study.machine.short_title(), counted(study.stations.len(), "point")),
            x_label: x_label.into(),
            y_label,
            series,
            equal_axes: false,
            log_x: false,
            log_y: false,
            closed_note: None,
        })
    }

    /// The path in the xy-plane: wanted, as the tool goes without compensation, as it is commanded and as it goes then.
    fn paths(&self, study: &PathStudy) -> Figure {
        let wanted = study.wanted();
        let amplification = amplification(&wanted, self.worst.map_or(0.0, |(_, most)| most.norm()));
        let drawn = |label: &str, dashed: bool, shift: &dyn Fn(&Shifts) -> Option<Vector3<f64>>| {
            let points = self.drawn.iter().zip(&self.shifts).filter_map(|(&k, shifts)| {
                let at = wanted[k] + shift(shifts)? * amplification;
                Some((at.x, at.y))
            });
            LineSeries { label: label.into(), points: points.collect(), dashed, band: Vec::new() }
        };
        let series = vec![
            drawn("wanted", false, &|_| Some(Vector3::zeros())),
            drawn("moved by chain errors", true, &|shifts| shifts.displacement[Source::Errors]),
            drawn("moved by the cutting force", true, &|shifts| shifts.displacement[Source::Cutting]),
            drawn("moved by all", false, &|shifts| shifts.displacement[Source::All]),
            drawn("commanded instead", false, &|shifts| shifts.commanded),
            drawn("after compensation", true, &|shifts| shifts.left),
        ];
        let thinned = match self.drawn.len() {
            all if all == wanted.len() => String::new(),
            some => format!(", {some} of {} drawn", counted(wanted.len(), "point")),
        };
        Figure::Lines(LineFigure {
            title: "Path wanted, real, commanded and compensated".into(),
            subtitle: format!("{}, seen along −z{thinned}", study.machine.short_title()),
            x_label: "x [mm]".into(),
            y_label: "y [mm]".into(),
            series,
            equal_axes: true,
            log_x: false,
            log_y: false,
            closed_note: Some(format!("deviations from the wanted path drawn {amplification} times as large")),
        })
    }
}

/// Where a point stands on the axis of the curves.
fn along(shown: Shown, station: &Station) -> Option<f64> {
    if shown.is_circle { station.phi_deg } else { Some(station.arc_length_mm) }
}

fn series(shown: Shown, label: impl Into<String>, dashed: bool, curve: &Curve) -> LineSeries {
    let mut points = curve.points();
    if shown.is_circle {
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        // One turn: the curve ends at the angle at which it begins.
        points.extend(points.first().map(|&(phi, value)| (phi + 360.0, value)));
    }
    LineSeries { label: label.into(), points, dashed, band: Vec::new() }
}
