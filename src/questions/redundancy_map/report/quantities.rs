//! The numbers of a redundancy map and what is asked of them: at each place, each direction of the tool at its best γ; over all directions, the
//! worst of them. Its table, and its pictures: slices at the heights asked for, and the places in 3-D.

use serde_json::{Value, json};

use crate::{
    answer::{Drawn, GridMap, Quantity, ShareWithin, TableOf},
    figures::{Figure, Shading},
    files::exchange::{Cell, Kind, Row, Table, cells, numbers, texts},
    machine::Branch,
    page::Better::{Larger, Neither, Smaller},
    questions::redundancy_map::{Gammas, RedundancyMap, RedundancyMapPoint, RedundancyMapStudy},
};

type Of = Quantity<Gammas>;

pub(super) const BEST: Of =
    Of::new("best_deflection_mm", "deflection at the best γ", Smaller, |gammas| Some(gammas.best.deflection_mm));
const BEST_GAMMA: Of = Of::new("best_gamma_deg", "best γ", Neither, |gammas| tidy(gammas.best.gamma_deg));
const WORST: Of =
    Of::new("worst_deflection_mm", "deflection at the worst γ", Smaller, |gammas| Some(gammas.worst.deflection_mm));
pub(super) const WORST_OVER_BEST: Of = Of::new("worst_over_best", "worst over best", Neither, |gammas| {
    Some(gammas.best.deflection_mm).filter(|best| *best > 0.0).map(|best| gammas.worst.deflection_mm / best)
});
const POSSIBLE: Of = Of::cell("gammas_possible", "values of γ that are possible", Larger, Kind::Count, |gammas| {
    gammas.map_or(0, |gammas| gammas.possible).into()
});

/// Those of a page, in its order.
pub(super) fn on_page() -> [Of; 5] {
    [BEST, WORST, WORST_OVER_BEST, BEST_GAMMA, POSSIBLE]
}

/// Angles γ are written to a thousandth of a degree.
fn tidy(degrees: f64) -> Option<f64> {
    Some((degrees * 1e3).round() / 1e3 + 0.0)
}

fn word(branch: Option<Branch>) -> Cell {
    branch.map(|branch| branch.label()).into()
}

/// Word of the rows that hold the worst of all directions.
pub(super) const ALL: &str = "all";

/// One row per direction and place, then, of several directions, one per place for all of them: that whose best γ moves the tool most.
pub(super) fn table(report: &Report<'_>) -> Table {
    let lead = [
        numbers(["x_mm", "y_mm", "z_mm"]),
        texts(["direction"]),
        numbers(["tool_axis_x", "tool_axis_y", "tool_axis_z"]),
    ];
    let quantities = vec![
        BEST,
        BEST_GAMMA,
        Of::text("best_branch", |gammas| gammas.map_or(Cell::Missing, |gammas| word(gammas.best.branch))),
        Of::in_table("best_phi_deg", |gammas| tidy(gammas.best.phi_deg)),
        WORST,
        Of::in_table("worst_gamma_deg", |gammas| tidy(gammas.worst.gamma_deg)),
        Of::text("worst_branch", |gammas| gammas.map_or(Cell::Missing, |gammas| word(gammas.worst.branch))),
        Of::in_table("worst_phi_deg", |gammas| tidy(gammas.worst.phi_deg)),
        WORST_OVER_BEST,
        POSSIBLE,
    ];
    let axes = report.study.axes.len();
    let places = if axes > 1 { report.study.grid.len() } else { 0 };
    let worst = |place: usize| {
        let failed = || (0..axes).map(|axis| report.point(axis, place)).find(|point| point.gammas.is_err());
        report.all_axes(place).map(|found| found.point).or_else(failed).unwrap_or_else(|| report.point(0, place))
    };
    let row = |direction: String, point: &'_ RedundancyMapPoint| {
        cells(point.position_mm).chain([direction.into()]).chain(cells(report.axis(point.axis))).collect::<Row>()
    };
    let own = report.map.points.iter().map(|point| (row(report.axis_name(point.axis), point), point.gammas.as_ref()));
    let all = (0..places).map(worst).map(|point| (row(ALL.into(), point), point.gammas.as_ref()));
    TableOf::new(lead.concat(), quantities).table(own.chain(all))
}

/// All pictures with their file stems.
pub(super) fn figures(report: &Report<'_>, slices_z: &[f64]) -> Vec<(String, Figure)> {
    let study = report.study;
    let tool = match study.axes.len() {
        1 => format!("tool along {}", report.axis_name(0)),
        count => format!("worst of {count} directions of the tool"),
    };
    let drawn = |stem, title: &str, label: String, value: fn(&Gammas) -> Option<f64>| Drawn {
        stem,
        title: title.into(),
        label,
        under: format!("{tool}, {}, {} values of γ", study.scene.force_words(), study.gammas()),
        contour: None,
        line: String::new(),
        shading: Shading::Ordered,
        value: Box::new(move |gammas: &Option<Gammas>| value(gammas.as_ref()?)),
    };
    let best = drawn("best", "How far the tool moves at the best γ", BEST.axis_label(), |gammas| BEST.value(gammas));
    let turn = drawn("gamma", "The best rotation γ about the tool axis", BEST_GAMMA.axis_label(), |gammas| {
        Some(gammas.best.gamma_deg.rem_euclid(360.0))
    });
    let gain = drawn("gain", "How much γ matters", "deflection at the worst γ over the best".into(), |gammas| {
        WORST_OVER_BEST.value(gammas)
    });
    let drawn =
        vec![Drawn { contour: study.scene.tolerance_mm, ..best }, Drawn { shading: Shading::Cyclic, ..turn }, gain];
    let mut map = GridMap::new(&study.scene, &study.grid, slices_z, drawn);
    (map.missing, map.has_points) = ("no γ", false);
    (0..study.grid.len()).for_each(|place| map.add(&report.all_axes(place).map(|found| *found.gammas)));
    let slices: Vec<(String, Figure)> = map.slices().collect();
    let answer = ("answer".to_string(), slices[0].1.clone());
    let in_3d = map.in_3d(0, format!("The places, coloured by {}", BEST.label));
    std::iter::once(answer).chain(slices).chain(in_3d.map(|figure| ("gamma_in_3d".into(), figure))).collect()
}

/// A redundancy map with what is asked of it.
pub(super) struct Report<'a> {
    pub study: &'a RedundancyMapStudy,
    pub map: &'a RedundancyMap,
}

/// A value of a quantity, and the place at which it is found.
#[derive(Clone, Copy)]
pub(super) struct Found<'a> {
    pub value: f64,
    pub point: &'a RedundancyMapPoint,
    pub gammas: &'a Gammas,
}

impl<'a> Report<'a> {
    /// The point with this direction at a place of the grid.
    pub fn point(&self, axis: usize, place: usize) -> &'a RedundancyMapPoint {
        &self.map.points[axis * self.study.grid.len() + place]
    }

    /// All that has a value of `quantity`.
    fn found(&self, quantity: &Quantity<Gammas>) -> impl Iterator<Item = Found<'a>> {
        self.map.points.iter().filter_map(|point| Found::of(quantity, point))
    }

    /// Of the best γ, the one at which the tool moves least.
    pub fn least(&self) -> Option<Found<'a>> {
        self.found(&BEST).min_by(|a, b| a.value.total_cmp(&b.value))
    }

    /// Of the best γ, the one at which the tool moves most.
    pub fn most(&self) -> Option<Found<'a>> {
        largest(self.found(&BEST))
    }

    /// Where the choice of γ counts most.
    pub fn widest(&self) -> Option<Found<'a>> {
        largest(self.found(&WORST_OVER_BEST))
    }

    /// At a place, the direction whose best γ moves the tool most; `None` where some direction has none.
    pub fn all_axes(&self, place: usize) -> Option<Found<'a>> {
        let found = (0..self.study.axes.len()).map(|axis| Found::of(&BEST, self.point(axis, place)));
        largest(found.collect::<Option<Vec<_>>>()?)
    }

    /// Share of the grid points at which every direction has a γ within the tolerance; of nothing without one.
    pub fn share_within(&self) -> ShareWithin {
        let mut share = ShareWithin::default();
        if let Some(tolerance) = self.study.scene.tolerance_mm {
            for place in 0..self.study.grid.len() {
                share.add(1.0, self.all_axes(place).is_some_and(|found| found.value <= tolerance));
            }
        }
        share
    }

    /// Name of a direction.
    pub fn axis_name(&self, axis: usize) -> String {
        let [x, y, z] = self.axis(axis);
        format!("({x}, {y}, {z})")
    }

    /// A direction without the rounding of how it was computed.
    pub fn axis(&self, axis: usize) -> [f64; 3] {
        <[f64; 3]>::from(self.study.axes[axis]).map(|c| (c * 1e6).round() / 1e6 + 0.0)
    }

    /// The answer for programs.
    pub fn json(&self) -> Value {
        let found = |Found { point, gammas, .. }: Found<'_>| {
            let axis = self.axis(point.axis);
            json!({ "position_mm": point.position_mm, "tool_axis": axis, "best": gammas.best, "worst": gammas.worst })
        };
        json!({
            "schema": 1,
            "least": self.least().map(found),
            "most": self.most().map(found),
            "largest_gain": self.widest().map(found),
            "share_within_tolerance": self.share_within().get(),
        })
    }
}

/// The last of those that are largest.
fn largest<'a>(all: impl IntoIterator<Item = Found<'a>>) -> Option<Found<'a>> {
    all.into_iter().max_by(|a, b| a.value.total_cmp(&b.value))
}

impl<'a> Found<'a> {
    /// At `point`, if there is a value of `quantity`.
    fn of(quantity: &Quantity<Gammas>, point: &'a RedundancyMapPoint) -> Option<Self> {
        let gammas = point.gammas.as_ref().ok()?;
        Some(Found { value: quantity.value(gammas)?, point, gammas })
    }
}
