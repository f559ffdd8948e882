//! Which pictures a superposition study gives.

use crate::{
    answer::{
        Shown,
        grid_slices::{drawn, drawn_nodes, panels, thinned_words},
        point_words,
    },
    figures::{Figure, LineFigure, LineSeries, Mark2, Shading, SliceFigure, SlicePanel},
    files::words::{counted, millimetres, position, typographic},
    process::MillingForce,
    questions::superposition::{
        DeparturePoint, LocationResult, Scaled, SuperpositionStudy,
        ablation::Cause,
        departure::{Followed, Sum},
        report::{contributions, words},
    },
};

/// A quantity of the map that is drawn.
struct Quantity {
    file_stem: &'static str,
    title: &'static str,
    label: &'static str,
    /// Words behind the setting.
    remark: fn(&SuperpositionStudy) -> String,
    /// Where a line is drawn.
    contour: fn(&SuperpositionStudy) -> Option<f64>,
    value: fn(&DeparturePoint) -> Option<f64>,
}

fn tolerance_words(study: &SuperpositionStudy) -> String {
    format!("; line: tolerance {} mm", study.tolerance)
}

const QUANTITIES: [Quantity; 5] = [
    Quantity {
        file_stem: "departure_tool",
        title: "Error of adding at the tool tip T",
        label: "departure of the tool tip [mm]",
        remark: tolerance_words,
        contour: |study| Some(study.tolerance),
        value: |p| Some(p.departures.as_ref().ok()?.superposition[0].departure_mm),
    },
    Quantity {
        file_stem: "departure_platform",
        title: "Error of adding at the platform point P",
        label: "departure of P [mm]",
        remark: |_| String::new(),
        contour: |_| None,
        value: |p| Some(p.departures.as_ref().ok()?.superposition[1].departure_mm),
    },
    Quantity {
        file_stem: "ratio_tool",
        title: "Error of adding as a share of the displacement",
        label: "departure / displacement, both at their largest [%]",
        remark: |_| String::new(),
        contour: |_| None,
        value: |p| Some(100.0 * p.departures.as_ref().ok()?.superposition[0].relative()?),
    },
    Quantity {
        file_stem: "aggregation_tool",
        title: "Error of adding aggregated chain errors, eqs. (14), (15)",
        label: "departure of the tool tip [mm]",
        remark: tolerance_words,
        contour: |study| Some(study.tolerance),
        value: |p| Some(p.departures.as_ref().ok()?.aggregation.as_ref().ok()?[0].departure_mm),
    },
    Quantity {
        file_stem: "safe_load",
        title: "Largest load for which adding is safe",
        label: "largest load / load of the study [1]",
        remark: |study| {
            format!("; line: the load of the study; departure of the tool tip up to {} mm", study.tolerance)
        },
        contour: |_| Some(1.0),
        value: |p| p.largest_load.factor(),
    },
];

/// The values that slices show, gathered point by point: a large grid is thinned.
#[derive(Debug, Clone)]
pub struct Pictures {
    /// Heights of the slices, mm.
    slices_z: Vec<f64>,
    /// Grid indices of the nodes shown, ascending.
    nodes: Vec<usize>,
    /// At each of them, the values of [`QUANTITIES`].
    values: Vec<[Option<f64>; QUANTITIES.len()]>,
    /// The largest departure of the tool tip, and where it is.
    largest: Option<(f64, [f64; 3])>,
    /// Indices along each axis of the nodes from which the slice through it is taken.
    all: [Vec<usize>; 3],
    /// Index of the next point.
    next: usize,
}

/// Most nodes along an axis of the slice through the largest departure.
const MOST_NODES: usize = 41;

impl Pictures {
    /// For the map of `study`, none of its points seen.
    pub fn new(study: &SuperpositionStudy, shown: &Shown) -> Self {
        let all = study.grid.counts().map(|count| drawn(count, MOST_NODES));
        let of = |[xs, ys, planes]: &[Vec<usize>; 3]| -> Vec<usize> {
            let rows = planes.iter().flat_map(|&z| ys.iter().map(move |&y| (y, z)));
            rows.flat_map(|(y, z)| xs.iter().map(move |&x| study.grid.index([x, y, z]))).collect()
        };
        let mut nodes = [of(&drawn_nodes(&study.grid, &shown.slices_z)), of(&all)].concat();
        nodes.sort_unstable();
        nodes.dedup();
        Self { slices_z: shown.slices_z.clone(), nodes, values: Vec::new(), largest: None, all, next: 0 }
    }

    /// Takes the next point, in grid order.
    pub fn add(&mut self, point: &DeparturePoint) {
        let departure = (QUANTITIES[0].value)(point).filter(|value| value.is_finite());
        if let Some(value) = departure.filter(|value| self.largest.is_none_or(|(most, _)| *value > most)) {
            self.largest = Some((value, point.position_mm));
        }
        if self.nodes.get(self.values.len()) == Some(&self.next) {
            self.values.push(std::array::from_fn(|k| (QUANTITIES[k].value)(point)));
        }
        self.next += 1;
    }

    /// All pictures with their file stems: slices of departures and of the largest safe load, and of each location how the
    /// departure grows and where it comes from.
    pub fn figures(&self, study: &SuperpositionStudy, locations: &[LocationResult]) -> Vec<(String, Figure)> {
        let slices = |(k, quantity): (usize, &Quantity)| {
            (format!("slices_{}", quantity.file_stem), Figure::Slices(self.slices(study, k)))
        };
        let answer = self.answer(study).map(|figure| ("answer".to_string(), Figure::Slices(figure)));
        let mut figures: Vec<(String, Figure)> =
            answer.into_iter().chain(QUANTITIES.iter().enumerate().map(slices)).collect();
        for (index, location) in locations.iter().enumerate() {
            let name = &location.location.name;
            let plain: String = name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
            let stem = |kind: &str| format!("{kind}_{}_{plain}", index + 1);
            let drawn = [("growth", growth(study, location)), ("ablation", ablation(study, location))];
            figures.extend(drawn.into_iter().filter_map(|(kind, figure)| Some((stem(kind), Figure::Lines(figure?)))));
        }
        figures
    }

    fn value(&self, study: &SuperpositionStudy, node: [usize; 3], quantity: usize) -> Option<f64> {
        let place = self.nodes.binary_search(&study.grid.index(node)).ok()?;
        self.values.get(place)?[quantity]
    }

    fn slices(&self, study: &SuperpositionStudy, quantity: usize) -> SliceFigure {
        let Quantity { title, label, remark, contour, .. } = &QUANTITIES[quantity];
        let value = |node| self.value(study, node, quantity);
        SliceFigure {
            title: (*title).into(),
            subtitle: format!("{}{}", setting(study, &self.slices_z), remark(study)),
            x_label: "x [mm]".into(),
            y_label: "y [mm]".into(),
            quantity: (*label).into(),
            panels: panels(&study.scene.machine, &study.grid, &self.slices_z, &value),
            range: None,
            contour: contour(study),
            shading: Shading::Ordered,
            remark: if quantity == 0 { point_words::points(&study.scene.machine) } else { String::new() },
            missing: "no solution".into(),
        }
    }

    /// The slice through the place of the largest departure; where nothing is solved, the lowest one.
    fn answer(&self, study: &SuperpositionStudy) -> Option<SliceFigure> {
        let z = self.largest.map_or(f64::NEG_INFINITY, |(_, at)| at[2]);
        let [columns, rows, planes] = &self.all;
        let [xs, ys, zs] = &study.grid.axes;
        let gap = |&&k: &&usize| (zs[k] - z.max(zs[0])).abs();
        let plane = planes.iter().min_by(|a, b| gap(a).total_cmp(&gap(b))).copied()?;
        let nodes = rows.iter().flat_map(|&y| columns.iter().map(move |&x| [x, y, plane]));
        let mark =
            |(most, [x, y, _]): (f64, [f64; 3])| Mark2 { label: format!("largest {}", millimetres(most, 3)), x, y };
        Some(SliceFigure {
            title: "Where adding the effects is most wrong".into(),
            subtitle: format!("{}{}", setting_of(study, &self.all[..2]), tolerance_words(study)),
            x_label: "x [mm]".into(),
            y_label: "y [mm]".into(),
            quantity: QUANTITIES[0].label.into(),
            panels: vec![SlicePanel {
                title: typographic(&format!("z = {:.2} mm", zs[plane])),
                x: columns.iter().map(|&x| xs[x]).collect(),
                y: rows.iter().map(|&y| ys[y]).collect(),
                values: nodes.map(|node| self.value(study, node, 0)).collect(),
                marks: self.largest.map(mark).into_iter().collect(),
            }],
            range: None,
            contour: Some(study.tolerance),
            shading: Shading::Ordered,
            remark: String::new(),
            missing: "no solution".into(),
        })
    }
}

fn force(study: &SuperpositionStudy) -> String {
    let MillingForce { radial, tangential, axial, .. } = study.scene.force;
    typographic(&format!("force {radial} / {tangential} / {axial} N (radial / tangential / axial)"))
}

fn setting(study: &SuperpositionStudy, slices_z: &[f64]) -> String {
    setting_of(study, &drawn_nodes(&study.grid, slices_z)[..2])
}

/// The setting of a slice that shows the nodes with the indices `drawn` along x and y.
fn setting_of(study: &SuperpositionStudy, drawn: &[Vec<usize>]) -> String {
    let [nx, ny, nz] = study.grid.counts();
    format!(
        "{}, worst of {}, {}, grid {nx} × {ny} × {nz}{}",
        study.scene.machine.short_title(),
        counted(study.scene.phis.len(), "tool angle"),
        force(study),
        thinned_words(&study.grid, drawn)
    )
}

/// Where a location is.
fn place(location: &LocationResult) -> String {
    let [x, y, z]: [f64; 3] = location.location.position.into();
    position(x, y, z)
}

/// Departures of the tool tip over the factor on the sources; `None` where there are none.
fn growth(study: &SuperpositionStudy, location: &LocationResult) -> Option<LineFigure> {
    let mut series = Vec::new();
    // Load and errors alone often give the same curve, and so do aggregated errors: dashes over the solid line, and dots over
    // these, leave all of them to be seen.
    for (sum, order) in [
        (Sum::Superposition, [Scaled::Load, Scaled::Errors, Scaled::Both]),
        (Sum::Aggregation, [Scaled::Errors, Scaled::Load, Scaled::Both]),
    ] {
        for scaled in order {
            let growth = &location.growth[scaled as usize];
            let points = growth.measured(sum, Followed::Tool);
            if let Some(fit) = growth.fit(sum, Followed::Tool) {
                let what = match scaled {
                    Scaled::Load => "load",
                    Scaled::Errors => "chain errors",
                    Scaled::Both => "both",
                };
                let kind = if sum == Sum::Aggregation { "linearly aggregated, " } else { "" };
                let slope = match fit.is_power_law() {
                    true => format!("slope {:.2}", fit.slope),
                    false => "not a power law".into(),
                };
                let label = format!("{kind}{what} scaled: {slope}");
                let dashed = sum == Sum::Aggregation || scaled == Scaled::Errors;
                series.push(LineSeries { label, points, dashed, band: Vec::new() });
            }
        }
    }
    (!series.is_empty()).then(|| LineFigure {
        title: format!("How the error of adding grows at {}", location.location.name),
        subtitle: format!(
            "{}, {}, worst of {}, {}; factor 1: load and errors of the study",
            study.scene.machine.short_title(),
            place(location),
            counted(study.scene.phis.len(), "tool angle"),
            force(study)
        ),
        x_label: "factor on the scaled sources [1]".into(),
        y_label: "departure of the tool tip [mm]".into(),
        series,
        equal_axes: false,
        log_x: true,
        log_y: true,
        closed_note: None,
    })
}

/// Values over φ, in degrees, up to the full turn, where that of 0° comes again.
fn closed(values: impl Iterator<Item = (f64, f64)>) -> Vec<(f64, f64)> {
    let mut values: Vec<(f64, f64)> = values.collect();
    values.extend(values.first().filter(|(phi, _)| *phi == 0.0).map(|(_, value)| (360.0, *value)));
    values
}

/// Contributions to the departure of the tool tip over φ; `None` where there is none.
fn ablation(study: &SuperpositionStudy, location: &LocationResult) -> Option<LineFigure> {
    let angles = location.ablation.as_ref().ok()?;
    let found: Vec<(f64, f64, [f64; 5])> = angles
        .iter()
        .filter_map(|a| Some((a.phi_deg, a.departure.tool.norm(), contributions(a, Followed::Tool)?)))
        .collect();
    if found.is_empty() {
        return None;
    }
    let all = found.iter().map(|(phi, length, _)| (*phi, *length));
    let mut series =
        vec![LineSeries { label: "departure".into(), points: closed(all), dashed: false, band: Vec::new() }];
    for (index, cause) in Cause::ALL.into_iter().enumerate() {
        let points = closed(found.iter().map(|(phi, _, parts)| (*phi, parts[index])));
        series.push(LineSeries { label: words(cause).into(), points, dashed: index > 1, band: Vec::new() });
    }
    Some(LineFigure {
        title: format!("What makes adding wrong at {}", location.location.name),
        subtitle: format!(
            "{}, {}, {}; parts along the departure of the tool tip, which at each angle add up to it",
            study.scene.machine.short_title(),
            place(location),
            force(study)
        ),
        x_label: "tool angle φ [°]".into(),
        y_label: "part of the departure [mm]".into(),
        series,
        equal_axes: false,
        log_x: false,
        log_y: false,
        closed_note: None,
    })
}
