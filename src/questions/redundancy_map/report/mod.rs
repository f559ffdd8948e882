//! Reports of a redundancy map: on the first screen how far the tool moves at the best γ and what a badly chosen one costs.

mod quantities;

use serde_json::json;

use crate::{
    answer::{Output, Quantity, Run, layers, size_words},
    files::{
        Manifest,
        text_table::text_table,
        words::{counted, if_any, millimetres, millimetres_in_table, position, typographic},
    },
    input::error::Result,
    page::{
        Description, Explorer, Fact, Group, GroupValue, Section, TableNote,
        headline::{Extreme, Headline, InTable, KeyNumber},
    },
    questions::{
        Answered,
        over_workspace::Shown,
        redundancy_map::{Gammas, RedundancyMapStudy, run},
    },
    simulation::status_of,
};
use quantities::{BEST, Found, Report, WORST_OVER_BEST};

impl Answered for RedundancyMapStudy {
    fn answer(&self, shown: &Shown, asked: &Run<'_>) -> Result<Output> {
        let map = run(self, asked.work)?;
        let report = Report { study: self, map: &map };
        Ok(Output {
            tables: vec![("redundancy_map".into(), quantities::table(&report))],
            figures: asked.drawn(|| quantities::figures(&report, &shown.slices_z)),
            details: details(&report),
            ..Output::of(
                json!({
                    "grid": self.grid.counts(),
                    "directions": self.axes.len(),
                    "gammas": self.gammas(),
                    "tool_angles": self.scene.phis.len(),
                }),
                Manifest::count(map.points.iter().map(|point| status_of(&point.gammas))),
                report.json(),
                Description { headline: headline(&report, &shown.not_used), ..page(&report) },
            )
        })
    }
}

/// Title of the view.
const MAP: &str = "Redundancy map";

/// Sections, setting, views and tables; first screen, figures and question are added by the run.
fn page(report: &Report<'_>) -> Description {
    let caption =
        "One row per place and direction of the tool; of several directions, then one per place for the worst of them.";
    let mut description = report.study.scene.description("redundancy_map", "the tool tip");
    description.terms.push(Fact::new(
        "γ",
        "rotation of the platform about the tool axis, right-handed about the direction from the spindle to the tip, counted \
         from the smallest rotation that brings the tool from home into its direction",
    ));
    Description {
        setting: setting(report),
        explorers: vec![explorer(report)],
        tables: vec![TableNote::ranked("redundancy_map.csv", caption, &quantities::BEST.name)],
        sections: vec![
            Section::new("How far does the tool move at the best γ?", "the map, to slice, turn and click")
                .text(&details(report))
                .explorers([MAP])
                .figures(&["slices_best", "gamma_"]),
            Section::new("Which γ?", "the best γ, and how much it matters").figures(&["slices_gamma", "slices_gain"]),
        ],
        ..description
    }
}

fn setting(report: &Report<'_>) -> Vec<Fact> {
    let RedundancyMapStudy { scene, grid, axes, turn } = report.study;
    let directions: Vec<String> = (0..axes.len()).map(|axis| report.axis_name(axis)).collect();
    scene.facts([
        Fact::new("directions of the tool", typographic(&format!("{}, from tip to spindle", directions.join(", ")))),
        Fact::new("values of γ", format!("{} in steps of {}°", report.study.gammas(), turn.step_deg)),
        Fact::new(
            "kept from singularities",
            format!("inverse condition number of {} at least", turn.min_singularity_distance),
        ),
        scene.angles_fact("directions of the force"),
        Fact::new("grid", format!("{}, {}", size_words(grid), counted(grid.len(), "grid point"))),
    ])
}

fn explorer(report: &Report<'_>) -> Explorer {
    let axes = report.study.axes.len();
    let value = |cell: String, label: String| GroupValue { cells: vec![cell], label };
    let own = (0..axes).map(|axis| value(report.axis_name(axis), format!("along {}", report.axis_name(axis))));
    let all = (axes > 1).then(|| value(quantities::ALL.into(), "the worst of all directions".into()));
    let (columns, label) = (vec!["direction".into()], "direction of the tool".into());
    let group = Group { columns, label, values: all.into_iter().chain(own).collect() };
    let layers = layers(&quantities::on_page());
    Explorer { marks: Vec::new(), ..report.study.scene.view(MAP, "redundancy_map.csv", Some(group), layers) }
}

/// The answer at a glance.
fn headline(report: &Report<'_>, not_used: &[&str]) -> Headline {
    let RedundancyMapStudy { scene, grid, axes, .. } = report.study;
    let basis = format!(
        "{}, {} of the tool, {} values of γ, {} of the force",
        counted(grid.len(), "grid point"),
        counted(axes.len(), "direction"),
        report.study.gammas(),
        counted(scene.phis.len(), "direction"),
    );
    let tip = scene.machine.home.pose.rotation * scene.machine.tool_tip;
    let positions = (0..grid.len()).map(|place| grid.position(place) - tip);
    let at_best =
        |found: Option<Found<'_>>, what: &str, extreme| found.map(|found| at_best_gamma(report, &found, what, extreme));
    Headline::new(sentence(report), basis)
        .with_cautions(&scene.cautions(not_used, "place", positions))
        .with_all(at_best(report.most(), "largest deflection at the best γ", Extreme::Largest))
        .with_all(at_best(report.least(), "smallest", Extreme::Smallest))
        .with_all(report.widest().map(|widest| gain(report, &widest)))
}

fn sentence(report: &Report<'_>) -> String {
    let name = report.study.scene.machine.short_title();
    let (Some(least), Some(most)) = (report.least(), report.most()) else {
        return format!(
            "No γ is possible for the {name} at any grid point and direction; redundancy_map.csv says why."
        );
    };
    let met = report.share_within().words(report.study.scene.tolerance_mm, "at … of the grid points");
    let met = met.map_or_else(String::new, |met| format!(" So rotated, it is {met}."));
    let times = |widest: Found<'_>| format!(" At the worst γ it moves up to {:.1} times as far.", widest.value);
    let gain = report.widest().map_or_else(String::new, times);
    format!(
        "At the best rotation γ about its tool, the {name} moves by {} at best and {} at worst.{met}{gain}",
        millimetres(least.value, 3),
        millimetres(most.value, 3),
    )
}

fn place(report: &Report<'_>, found: &Found<'_>) -> String {
    let [x, y, z] = found.point.position_mm;
    let at = position(x, y, z);
    match report.study.axes.len() {
        1 => at,
        _ => format!("{at} with the tool along {}", report.axis_name(found.point.axis)),
    }
}

fn in_table(report: &Report<'_>, found: &Found<'_>, quantity: &Quantity<Gammas>, extreme: Extreme) -> InTable {
    quantity.found_in("redundancy_map.csv", &[["direction", &report.axis_name(found.point.axis)]], extreme, found.value)
}

fn at_best_gamma(report: &Report<'_>, found: &Found<'_>, what: &str, extreme: Extreme) -> KeyNumber {
    let best = &found.gammas.best;
    let branch = best.branch.map_or_else(String::new, |branch| format!(", {}", branch.label()));
    let against = format!("γ = {:.0}°{branch}", best.gamma_deg);
    let what = format!("{what}, at {}", place(report, found));
    KeyNumber::new(&millimetres(found.value, 3), what, against).found(in_table(report, found, &BEST, extreme))
}

fn gain(report: &Report<'_>, found: &Found<'_>) -> KeyNumber {
    let [worst, best] = [&found.gammas.worst, &found.gammas.best]
        .map(|turn| format!("{} at {:.0}°", millimetres(turn.deflection_mm, 3), turn.gamma_deg));
    let what = format!("times as far at the worst γ as at the best, at {}", place(report, found));
    let number = KeyNumber::new(&format!("{:.2}", found.value), what, format!("{worst} against {best}"));
    number.found(in_table(report, found, &WORST_OVER_BEST, Extreme::Largest))
}

/// A row for each direction of the tool.
fn details(report: &Report<'_>) -> String {
    let mut table = text_table(["tool along", "solved", "least", "most", "worst γ", "values of γ"], 1);
    let places = report.study.grid.len();
    for (axis, points) in report.map.points.chunks(places).enumerate() {
        let gammas: Vec<&Gammas> = points.iter().filter_map(|point| point.gammas.as_ref().ok()).collect();
        let best = |of: fn(f64, f64) -> f64| gammas.iter().map(|gammas| gammas.best.deflection_mm).reduce(of);
        let worst = gammas.iter().map(|gammas| gammas.worst.deflection_mm).reduce(f64::max);
        let possible = gammas.iter().map(|gammas| gammas.possible as f64).sum::<f64>() / gammas.len().max(1) as f64;
        let shown = |value: Option<f64>| if_any(value, |value| millimetres_in_table(value, 3));
        table.add_row([
            report.axis_name(axis),
            format!("{} of {places}", gammas.len()),
            shown(best(f64::min)),
            shown(best(f64::max)),
            shown(worst),
            format!("{possible:.0} of {}", report.study.gammas()),
        ]);
    }
    format!(
        "Deflection of the tool at the best γ of each grid point (least, most), at the worst γ of any, and values of γ that are possible \
         on some branch:\n{table}\n"
    )
}
