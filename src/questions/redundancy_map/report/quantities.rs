//! Quantities, table and figures of a redundancy map: deflection at the best and the worst γ at each point.

use serde_json::{Value, json};

use crate::{
    answer::{GridMap, MapLayer, Quantity, QuantityTable, ShareWithin, Tolerance},
    figures::{Figure, Limit, Shading},
    files::exchange::{Cell, Kind, Row, Table, cells, numbers, texts},
    machine::Branch,
    page::Better::{Larger, Neither, Smaller},
    questions::redundancy_map::{GammaExtremes, RedundancyMap, RedundancyMapPoint, RedundancyMapStudy},
};

type Of = Quantity<GammaExtremes>;

pub(super) const BEST: Of =
    Of::new("best_deflection_mm", "deflection at the best γ", Smaller, |gammas| Some(gammas.best.deflection_mm));
const BEST_GAMMA: Of = Of::new("best_gamma_deg", "best γ", Neither, |gammas| rounded_degrees(gammas.best.gamma_deg));
const WORST: Of =
    Of::new("worst_deflection_mm", "deflection at the worst γ", Smaller, |gammas| Some(gammas.worst.deflection_mm));
pub(super) const WORST_OVER_BEST: Of = Of::new("worst_over_best", "worst over best", Neither, |gammas| {
    Some(gammas.best.deflection_mm).filter(|best| *best > 0.0).map(|best| gammas.worst.deflection_mm / best)
});
const POSSIBLE: Of = Of::cell("gammas_possible", "values of γ that are possible", Larger, Kind::Count, |gammas| {
    gammas.map_or(0, |gammas| gammas.possible).into()
});

/// Lists the quantities of the page's view, in its order.
pub(super) fn page_quantities() -> [Of; 5] {
    [BEST, WORST, WORST_OVER_BEST, BEST_GAMMA, POSSIBLE]
}

/// Rounds an angle to a thousandth of a degree; never `None`.
fn rounded_degrees(degrees: f64) -> Option<f64> {
    Some((degrees * 1e3).round() / 1e3 + 0.0)
}

/// Returns the table cell of a branch.
fn branch_cell(branch: Option<Branch>) -> Cell {
    branch.map(|branch| branch.label()).into()
}

/// Word in the rows that hold the worst of all directions.
pub(super) const ALL: &str = "all";

/// Makes the table, one row per direction and position, then one per position for the worst direction if there are several.
pub(super) fn table(report: &Report<'_>) -> Table {
    let lead = [
        numbers(["x_mm", "y_mm", "z_mm"]),
        texts(["direction"]),
        numbers(["tool_axis_x", "tool_axis_y", "tool_axis_z"]),
    ];
    let quantities = vec![
        BEST,
        BEST_GAMMA,
        Of::text("best_branch", |gammas| gammas.map_or(Cell::Missing, |gammas| branch_cell(gammas.best.branch))),
        Of::in_table("best_phi_deg", |gammas| rounded_degrees(gammas.best.phi_deg)),
        WORST,
        Of::in_table("worst_gamma_deg", |gammas| rounded_degrees(gammas.worst.gamma_deg)),
        Of::text("worst_branch", |gammas| gammas.map_or(Cell::Missing, |gammas| branch_cell(gammas.worst.branch))),
        Of::in_table("worst_phi_deg", |gammas| rounded_degrees(gammas.worst.phi_deg)),
        WORST_OVER_BEST,
        POSSIBLE,
    ];
    let axes = report.study.axes.len();
    let places = if axes > 1 { report.study.grid.len() } else { 0 };
    let worst = |place: usize| {
        let failed = || (0..axes).map(|axis| report.point(axis, place)).find(|point| point.gammas.is_err());
        report.worst_direction(place).map(|found| found.point).or_else(failed).unwrap_or_else(|| report.point(0, place))
    };
    let row = |direction: String, point: &'_ RedundancyMapPoint| {
        cells(point.position_mm).chain([direction.into()]).chain(cells(report.axis(point.axis))).collect::<Row>()
    };
    let own = report.map.points.iter().map(|point| (row(report.axis_name(point.axis), point), point.gammas.as_ref()));
    let worst_rows = (0..places).map(worst).map(|point| (row(ALL.into(), point), point.gammas.as_ref()));
    QuantityTable::new(lead.concat(), quantities).table(own.chain(worst_rows))
}

/// Returns all figures with their file stems: slices of the deflection at the best γ, of that γ and of its gain, and the positions in 3-D.
pub(super) fn figures(report: &Report<'_>, slices_z: &[f64]) -> Vec<(String, Figure)> {
    let study = report.study;
    let tool = match study.axes.len() {
        1 => format!("tool along {}", report.axis_name(0)),
        count => format!("worst of {count} directions of the tool"),
    };
    let drawn = |stem, title: &str, label: String, value: fn(&GammaExtremes) -> Option<f64>| MapLayer {
        stem,
        title: title.into(),
        label,
        setting: format!("{tool}, {}, {} values of γ", study.load_case.force_text(), study.gamma_count()),
        limit: None,
        of_limit: String::new(),
        shading: Shading::Ordered,
        value: Box::new(move |gammas: &Option<GammaExtremes>| value(gammas.as_ref()?)),
    };
    let best = drawn("best", "How far the tool moves at the best γ", BEST.axis_label(), |gammas| BEST.value(gammas));
    let gamma = drawn("gamma", "The best rotation γ about the tool axis", BEST_GAMMA.axis_label(), |gammas| {
        Some(gammas.best.gamma_deg.rem_euclid(360.0))
    });
    let gain = drawn("gain", "How much γ matters", "deflection at the worst γ over the best".into(), |gammas| {
        WORST_OVER_BEST.value(gammas)
    });
    let drawn = vec![
        MapLayer {
            limit: study.load_case.tolerance_mm.map(Limit::Most),
            of_limit: study.load_case.tolerance_mm.map_or_else(String::new, |most| Tolerance(most).hatched()),
            ..best
        },
        MapLayer { shading: Shading::Cyclic, ..gamma },
        gain,
    ];
    let mut map = GridMap::new(&study.load_case, &study.grid, slices_z, drawn);
    (map.missing, map.has_points) = ("no γ", false);
    (0..study.grid.len()).for_each(|place| map.add(&report.worst_direction(place).map(|found| *found.gammas)));
    let slices: Vec<(String, Figure)> = map.slices().collect();
    let answer = ("answer".to_string(), slices[0].1.clone());
    let in_3d = map.in_3d(0, format!("The places, coloured by {}", BEST.label));
    std::iter::once(answer).chain(slices).chain(in_3d.map(|figure| ("gamma_in_3d".into(), figure))).collect()
}

/// A redundancy map with its study, as the report reads it.
pub(super) struct Report<'a> {
    pub study: &'a RedundancyMapStudy,
    pub map: &'a RedundancyMap,
}

/// A value of a quantity with the point at which it occurs.
#[derive(Clone, Copy)]
pub(super) struct FoundValue<'a> {
    pub value: f64,
    pub point: &'a RedundancyMapPoint,
    pub gammas: &'a GammaExtremes,
}

impl<'a> Report<'a> {
    /// Returns the point of the map with the tool direction `axis` at the grid point `place` (indices).
    pub fn point(&self, axis: usize, place: usize) -> &'a RedundancyMapPoint {
        &self.map.points[axis * self.study.grid.len() + place]
    }

    /// Returns all values of `quantity`.
    fn values_of(&self, quantity: &Quantity<GammaExtremes>) -> impl Iterator<Item = FoundValue<'a>> {
        self.map.points.iter().filter_map(|point| FoundValue::of(quantity, point))
    }

    /// Returns the smallest deflection at the best γ, with its point; `None` if no point has a γ.
    pub fn smallest_at_best(&self) -> Option<FoundValue<'a>> {
        self.values_of(&BEST).min_by(|a, b| a.value.total_cmp(&b.value))
    }

    /// Returns the largest deflection at the best γ, with its point; `None` if no point has a γ.
    pub fn largest_at_best(&self) -> Option<FoundValue<'a>> {
        largest_value(self.values_of(&BEST))
    }

    /// Returns the largest ratio of the deflections at the worst and the best γ, with its point; `None` if no point has a γ.
    pub fn largest_gain(&self) -> Option<FoundValue<'a>> {
        largest_value(self.values_of(&WORST_OVER_BEST))
    }

    /// Returns the direction whose best γ moves the tool most at the grid point `place`; `None` where some direction has no γ.
    pub fn worst_direction(&self, place: usize) -> Option<FoundValue<'a>> {
        let values = (0..self.study.axes.len()).map(|axis| FoundValue::of(&BEST, self.point(axis, place)));
        largest_value(values.collect::<Option<Vec<_>>>()?)
    }

    /// Returns the share of the box, over all directions, in which the best γ is within tolerance; an empty share without a tolerance.
    pub fn share_within(&self) -> ShareWithin {
        let mut share = ShareWithin::default();
        if let Some(tolerance) = self.study.load_case.tolerance_mm {
            for (index, point) in self.map.points.iter().enumerate() {
                // Each grid point stands for the cell around it.
                let cell = self.study.grid.cell_share(index % self.study.grid.len());
                share.add(cell, FoundValue::of(&BEST, point).is_some_and(|found| found.value <= tolerance));
            }
        }
        share
    }

    /// Returns a tool direction in words.
    pub fn axis_name(&self, axis: usize) -> String {
        let [x, y, z] = self.axis(axis);
        format!("({x}, {y}, {z})")
    }

    /// Returns the tool direction with this index, a unit vector of O rounded to 1e-6.
    pub fn axis(&self, axis: usize) -> [f64; 3] {
        <[f64; 3]>::from(self.study.axes[axis]).map(|c| (c * 1e6).round() / 1e6 + 0.0)
    }

    /// Returns the summary as JSON: smallest and largest deflection at the best γ, largest gain, and share within tolerance.
    pub fn json(&self) -> Value {
        let found = |FoundValue { point, gammas, .. }: FoundValue<'_>| {
            let axis = self.axis(point.axis);
            json!({ "position_mm": point.position_mm, "tool_axis": axis, "best": gammas.best, "worst": gammas.worst })
        };
        json!({
            "schema": 1,
            "least": self.smallest_at_best().map(found),
            "most": self.largest_at_best().map(found),
            "largest_gain": self.largest_gain().map(found),
            "share_within_tolerance": self.share_within().get(),
        })
    }
}

/// Returns the largest of the values, the last of equal ones; `None` if there are none.
fn largest_value<'a>(values: impl IntoIterator<Item = FoundValue<'a>>) -> Option<FoundValue<'a>> {
    values.into_iter().max_by(|a, b| a.value.total_cmp(&b.value))
}

impl<'a> FoundValue<'a> {
    /// Returns the value of `quantity` at `point`, if there is one.
    fn of(quantity: &Quantity<GammaExtremes>, point: &'a RedundancyMapPoint) -> Option<Self> {
        let gammas = point.gammas.as_ref().ok()?;
        Some(FoundValue { value: quantity.value(gammas)?, point, gammas })
    }
}
