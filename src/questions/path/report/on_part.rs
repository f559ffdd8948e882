//! Drawings of the wanted path and of the path as the sources displace it; deviations are magnified.

use nalgebra::Vector3;

use super::thinned::drawn_indices;
use crate::{
    figures::{Figure, LineFigure, LineSeries, Look, PlanFigure, PlanShape, amplification::amplification},
    files::words::{counted, millimetres},
    questions::path::{PathPart, PathStudy, Shown},
    simulation::{BySource, Source},
};

const AXES: [&str; 3] = ["x", "y", "z"];

/// Deviations from the wanted path at one point, O axes, mm.
#[derive(Debug, Clone)]
struct Deviations {
    /// Displacement by each source; `None` where there is no equilibrium.
    displacement: BySource<Option<Vector3<f64>>>,
    commanded: Option<Vector3<f64>>,
    /// Residual error after compensation.
    left: Option<Vector3<f64>>,
}

/// Data of the two drawings of a path, collected point by point; of a long path not every point is drawn.
#[derive(Debug, Clone)]
pub(super) struct PathDrawing<'a> {
    study: &'a PathStudy,
    wanted: Vec<Vector3<f64>>,
    /// Indices of the points drawn, ascending.
    drawn: Vec<usize>,
    /// Deviations at the points drawn.
    shifts: Vec<Deviations>,
    /// The point with the largest displacement by all sources, and that displacement, O axes, mm.
    worst: Option<(usize, Vector3<f64>)>,
}

impl<'a> PathDrawing<'a> {
    /// Makes the drawings of `study` without deviations yet.
    pub fn new(study: &'a PathStudy) -> Self {
        let wanted = study.wanted_positions();
        Self { study, drawn: drawn_indices(&wanted), wanted, shifts: Vec::new(), worst: None }
    }

    /// Adds the next point, with the index `k`.
    pub fn add(&mut self, part: &PathPart, k: usize) {
        let displacement = BySource::of(&self.study.machine, |source| part.displacement(source, k));
        if let Some(deviation) = displacement[Source::All]
            && self.worst.is_none_or(|(_, largest)| deviation.norm() > largest.norm())
        {
            self.worst = Some((k, deviation));
        }
        if self.drawn.get(self.shifts.len()) == Some(&k) {
            let left = part.at(Source::All, k).compensated().map(|answer| answer.position_error);
            self.shifts.push(Deviations { displacement, commanded: part.command_shift(self.study, k), left });
        }
    }

    /// Returns the wanted position and the deviations of each point drawn.
    fn points(&self) -> impl Iterator<Item = (Vector3<f64>, &Deviations)> {
        self.drawn.iter().map(|&k| self.wanted[k]).zip(&self.shifts)
    }

    /// Returns the factor by which deviations are magnified in a figure over the axes `across` and `up` (0 to 2).
    fn amplification_along(&self, [across, up]: [usize; 2]) -> f64 {
        let in_plane: Vec<Vector3<f64>> = self.wanted.iter().map(|p| Vector3::new(p[across], p[up], 0.0)).collect();
        amplification(&in_plane, self.worst.map_or(0.0, |(_, largest)| largest.norm()))
    }

    /// Returns the axes of the view in which the path spreads most, or in which more shows of how far the tool is off it, where that one hides more than half.
    fn shown_axes(&self) -> [usize; 3] {
        let axes @ [across, up, along] = view_axes(&self.wanted);
        let displacements = || self.shifts.iter().filter_map(|shifts| shifts.displacement[Source::All]);
        let squares = displacements().fold(Vector3::zeros(), |sum, own| sum + own.component_mul(&own));
        if 2.0 * squares[along] <= squares.sum() {
            return axes;
        }
        axes_along(if squares[across] < squares[up] { across } else { up })
    }

    /// Draws the wanted and the displaced path, coloured by the size of the deviation.
    pub fn magnified_figure(&self, shown: Shown) -> Figure {
        let [across, up, along] = self.shown_axes();
        let factor = self.amplification_along([across, up]);
        let flat = |p: Vector3<f64>| (p[across], p[up]);
        let mut coloured: Vec<Vec<(f64, f64, f64)>> = vec![Vec::new()];
        for (wanted, shifts) in self.points() {
            match shifts.displacement[Source::All] {
                Some(displacement) => {
                    let (x, y) = flat(wanted + displacement * factor);
                    coloured.last_mut().into_iter().for_each(|piece| piece.push((x, y, displacement.norm())));
                }
                None => coloured.push(Vec::new()),
            }
        }
        coloured.retain(|piece| !piece.is_empty());
        let thinned = match self.shifts.len() {
            all if all == self.wanted.len() => String::new(),
            some => format!(", {some} of them drawn"),
        };
        let mark = |(farthest, largest): (usize, Vector3<f64>)| {
            let (x, y) = flat(self.wanted[farthest] + largest * factor);
            let station = &self.study.stations[farthest];
            let angle = station.phi_deg.filter(|_| shown.is_circle);
            let angle = angle.map(|phi| format!("\ntool angle {phi:.0}°")).unwrap_or_default();
            (x, y, format!("worst {}\n{:.1} mm along{angle}", millimetres(largest.norm(), 3), station.arc_length_mm))
        };
        let (name, points) = (&self.study.machine.name, counted(self.wanted.len(), "point"));
        let along = AXES[along];
        Figure::Plan(Box::new(PlanFigure {
            title: match self.worst {
                Some(_) => format!("Path without compensation, ×{factor}, {along} in the colour only"),
                None => "Path: nothing of it is solved".into(),
            },
            subtitle: format!("{name}, {points}{thinned}, seen along {along}; thin: wanted"),
            x_label: format!("{} [mm]", AXES[across]),
            y_label: format!("{} [mm]", AXES[up]),
            quantity: "distance from the wanted path [mm]".into(),
            field: None,
            shapes: vec![PlanShape {
                look: Look::TargetPath,
                points: self.points().map(|(wanted, _)| flat(wanted)).collect(),
                label: String::new(),
            }],
            coloured,
            marks: self.worst.map(mark).into_iter().collect(),
            note: String::new(),
        }))
    }

    /// Draws the path in the xy-plane: wanted, displaced, commanded and compensated.
    pub fn top_view_figure(&self) -> Figure {
        let factor = self.amplification_along([0, 1]);
        let drawn = |label: &str, dashed: bool, shift: &dyn Fn(&Deviations) -> Option<Vector3<f64>>| {
            let at = |(wanted, shifts): (Vector3<f64>, &Deviations)| Some(wanted + shift(shifts)? * factor);
            let points = self.points().filter_map(at).map(|at| (at.x, at.y)).collect();
            LineSeries::new(label, points, dashed)
        };
        let thinned = match self.drawn.len() {
            all if all == self.wanted.len() => String::new(),
            some => format!(", {some} of {} drawn", counted(self.wanted.len(), "point")),
        };
        let series = vec![
            drawn("wanted", false, &|_| Some(Vector3::zeros())),
            drawn("moved by chain errors", true, &|shifts| shifts.displacement[Source::Geometry]),
            drawn("moved by the cutting force", true, &|shifts| shifts.displacement[Source::Cutting]),
            drawn("moved by all", false, &|shifts| shifts.displacement[Source::All]),
            drawn("commanded instead", false, &|shifts| shifts.commanded),
            drawn("after compensation", true, &|shifts| shifts.left),
        ];
        let subtitle = format!("{}, seen along −z{thinned}", self.study.machine.name);
        Figure::Lines(LineFigure {
            equal_axes: true,
            closed_note: Some(format!("deviations from the wanted path drawn {factor} times as large")),
            ..LineFigure::new("Path wanted, real, commanded and compensated", subtitle, ["x [mm]", "y [mm]"], series)
        })
    }
}

/// Returns the axes (0 to 2) rightward, upward and along the sight of the view in which the path spreads most, preferably along z.
pub fn view_axes(wanted: &[Vector3<f64>]) -> [usize; 3] {
    let extent = |axis: usize| {
        let (low, high) = wanted.iter().fold((f64::MAX, f64::MIN), |(l, h), p| (l.min(p[axis]), h.max(p[axis])));
        high - low
    };
    let hidden = [2, 1, 0].into_iter().reduce(|a, b| if extent(b) < 0.999 * extent(a) { b } else { a }).unwrap_or(2);
    axes_along(hidden)
}

/// Returns the axes rightward, upward and along the sight of the view along the axis `hidden`.
fn axes_along(hidden: usize) -> [usize; 3] {
    match hidden {
        0 => [1, 2, 0],
        1 => [0, 2, 1],
        _ => [0, 1, 2],
    }
}
