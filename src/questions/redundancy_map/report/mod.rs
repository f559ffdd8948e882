//! Report of a redundancy map: deflection at the best γ, and by how much a badly chosen γ increases it.

mod quantities;

use serde_json::json;

use crate::{
    answer::{Output, Quantity, Run, layers, size_text},
    files::{
        Manifest,
        text_table::text_table,
        words::{counted, millimetres, millimetres_in_table, or_dash, position, typographic},
    },
    input::error::Result,
    page::{
        Description, Explorer, Fact, Group, Section, TableNote,
        headline::{Extreme, Headline, InTable, KeyNumber, State, Verdict},
    },
    questions::{
        Answered,
        over_workspace::Shown,
        redundancy_map::{GammaExtremes, RedundancyMapStudy, run},
    },
    simulation::status_of,
};
use quantities::{BEST, FoundValue, Report, WORST_OVER_BEST};

impl Answered for RedundancyMapStudy {
    /// Computes the map, and makes table, figures, page and summary.
    fn answer(&self, shown: &Shown, asked: &Run<'_>) -> Result<Output> {
        let map = run(self, asked.work)?;
        let report = Report { study: self, map: &map };
        Ok(Output {
            tables: vec![("redundancy_map".into(), quantities::table(&report))],
            figures: asked.draw_figures(|| quantities::figures(&report, &shown.slices_z)),
            details: directions_table(&report),
            ..Output::of(
                json!({
                    "grid": self.grid.counts(),
                    "directions": self.axes.len(),
                    "gammas": self.gamma_count(),
                    "tool_angles": self.load_case.phis.len(),
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

/// Returns the page without first screen, figures and question, which the run adds.
fn page(report: &Report<'_>) -> Description {
    let caption =
        "One row per place and direction of the tool; of several directions, then one per place for the worst of them.";
    let mut description = report.study.load_case.description("redundancy_map", "the tool tip");
    description.terms.push(Fact::new(
        "γ",
        "rotation of the platform about the tool axis, right-handed about the direction from the spindle to the tip, counted \
         from the smallest rotation that brings the tool from home into its direction",
    ));
    Description {
        setting: setting(report),
        explorers: vec![map_view(report)],
        tables: vec![TableNote::ranked("redundancy_map.csv", caption, &quantities::BEST.name)],
        sections: vec![
            Section::new("How far does the tool move at the best γ?", "the map, to slice, turn and click")
                .text(&directions_table(report))
                .explorers([MAP])
                .figures(&["slices_best", "gamma_"]),
            Section::new("Which γ?", "the best γ, and how much it matters").figures(&["slices_gamma", "slices_gain"]),
        ],
        ..description
    }
}

/// Returns the facts about directions, values of γ, force and grid that head the page.
fn setting(report: &Report<'_>) -> Vec<Fact> {
    let RedundancyMapStudy { load_case, grid, axes, settings } = report.study;
    let directions: Vec<String> = (0..axes.len()).map(|axis| report.axis_name(axis)).collect();
    load_case.facts([
        Fact::new("directions of the tool", typographic(&format!("{}, from tip to spindle", directions.join(", ")))),
        Fact::new("values of γ", format!("{} in steps of {}°", report.study.gamma_count(), settings.step_deg)),
        Fact::new(
            "kept from singularities",
            format!("inverse condition number of {} at least", settings.min_singularity_distance),
        ),
        load_case.angles_fact("directions of the force"),
        Fact::new("grid", format!("{}, {}", size_text(grid), counted(grid.len(), "grid point"))),
    ])
}

/// Returns the view of the map, to be filtered by direction.
fn map_view(report: &Report<'_>) -> Explorer {
    let axes = report.study.axes.len();
    let directions = (0..axes).map(|axis| (report.axis_name(axis), format!("along {}", report.axis_name(axis))));
    let worst = (axes > 1).then(|| (quantities::ALL.into(), "the worst of all directions".into()));
    let group = Group::by_column("direction", "direction of the tool", worst.into_iter().chain(directions));
    let layers = layers(&quantities::page_quantities());
    Explorer { marks: Vec::new(), ..report.study.load_case.view(MAP, "redundancy_map.csv", Some(group), layers) }
}

/// Returns the first screen: one sentence, key numbers and cautions.
fn headline(report: &Report<'_>, not_used: &[&str]) -> Headline {
    let RedundancyMapStudy { load_case, grid, axes, .. } = report.study;
    let basis = format!(
        "{}, {} of the tool, {} values of γ, {} of the force",
        counted(grid.len(), "grid point"),
        counted(axes.len(), "direction"),
        report.study.gamma_count(),
        counted(load_case.phis.len(), "direction"),
    );
    let tip = load_case.machine.home.pose.rotation * load_case.machine.tool_tip;
    let positions = (0..grid.len()).map(|place| grid.position(place) - tip);
    let at_best = |found: Option<FoundValue<'_>>, what: &str, extreme| {
        found.map(|found| best_gamma_number(report, &found, what, extreme))
    };
    let verdict = match report.smallest_at_best() {
        None => Verdict::new(State::Bad, "No rotation about the tool is possible"),
        Some(_) => Verdict::of_deflection(report.share_within().get(), load_case.tolerance_mm),
    };
    let sentence = match (report.smallest_at_best(), report.largest_at_best()) {
        (Some(least), Some(most)) => {
            let [least, most] = [least, most].map(|own| millimetres(own.value, 3));
            format!("Tool deflection at the best γ: {least} to {most}.")
        }
        _ => "No γ is possible at any grid point and direction.".into(),
    };
    Headline::new(sentence, basis)
        .judged(verdict, true)
        .next("rotate the tool by the best γ: [redundancy] in a process file finds it along a path.")
        .with_cautions(&answer_sentence(report))
        .with_cautions(&load_case.cautions(not_used, "place", positions))
        .with_numbers(at_best(report.largest_at_best(), "largest deflection at the best γ", Extreme::Largest))
        .with_numbers(at_best(report.smallest_at_best(), "smallest", Extreme::Smallest))
        .with_numbers(report.largest_gain().map(|widest| gain_number(report, &widest)))
}

/// Returns the answer of the first screen: smallest and largest deflection at the best γ, share within tolerance, factor at the worst γ; or that
/// no γ is possible anywhere.
fn answer_sentence(report: &Report<'_>) -> String {
    let name = &report.study.load_case.machine.name;
    let (Some(least), Some(most)) = (report.smallest_at_best(), report.largest_at_best()) else {
        return format!("No γ is possible for {name} at any grid point and direction; redundancy_map.csv says why.");
    };
    let (share_template, extent) = match report.study.axes.len() {
        1 => ("in … of the box", ""),
        _ => ("in … of the box over all directions", " over all grid points and directions"),
    };
    let within = report.share_within().text(report.study.load_case.tolerance_mm, share_template);
    let tolerance_text = within.map_or_else(String::new, |share| format!(" So rotated, the tool is {share}."));
    let gain = |at: FoundValue<'_>| format!(" At the worst γ the tool moves up to {:.1} times as far.", at.value);
    let gain_sentence = report.largest_gain().map_or_else(String::new, gain);
    format!(
        "At the best rotation γ about its axis, the tool of {name} moves by {} to {}{extent}.{tolerance_text}{gain_sentence}",
        millimetres(least.value, 3),
        millimetres(most.value, 3),
    )
}

/// Describes the position of a value and, on a map of several directions, the tool direction.
fn point_text(report: &Report<'_>, found: &FoundValue<'_>) -> String {
    let [x, y, z] = found.point.position_mm;
    let at = position(x, y, z);
    match report.study.axes.len() {
        1 => at,
        _ => format!("{at} with the tool along {}", report.axis_name(found.point.axis)),
    }
}

/// Returns the reference to the value `found` of `quantity` in `redundancy_map.csv`, where it is the `extreme` of its column.
fn in_csv(
    report: &Report<'_>,
    found: &FoundValue<'_>,
    quantity: &Quantity<GammaExtremes>,
    extreme: Extreme,
) -> InTable {
    quantity.found_in("redundancy_map.csv", &[["direction", &report.axis_name(found.point.axis)]], extreme, found.value)
}

/// Returns the key number of the deflection `found` at the best γ, with γ and branch; `what` says which it is.
fn best_gamma_number(report: &Report<'_>, found: &FoundValue<'_>, what: &str, extreme: Extreme) -> KeyNumber {
    let best = &found.gammas.best;
    let branch = best.branch.map_or_else(String::new, |branch| format!(", {}", branch.label()));
    let against = format!("γ = {:.0}°{branch}", best.gamma_deg);
    let what = format!("{what}, at {}", point_text(report, found));
    KeyNumber::new(&millimetres(found.value, 3), what, against).found(in_csv(report, found, &BEST, extreme))
}

/// Returns the key number of the largest ratio between the deflections at the worst and the best γ.
fn gain_number(report: &Report<'_>, found: &FoundValue<'_>) -> KeyNumber {
    let [worst, best] = [&found.gammas.worst, &found.gammas.best]
        .map(|at| format!("{} at {:.0}°", millimetres(at.deflection_mm, 3), at.gamma_deg));
    let what = format!("times as far at the worst γ as at the best, at {}", point_text(report, found));
    let number = KeyNumber::new(&format!("{:.2}", found.value), what, format!("{worst} against {best}"));
    number.found(in_csv(report, found, &WORST_OVER_BEST, Extreme::Largest))
}

/// Returns a table with one row for each direction of the tool.
fn directions_table(report: &Report<'_>) -> String {
    let mut table = text_table(["tool along", "solved", "least", "most", "worst γ", "values of γ"], 1);
    let places = report.study.grid.len();
    for (axis, points) in report.map.points.chunks(places).enumerate() {
        let gammas: Vec<&GammaExtremes> = points.iter().filter_map(|point| point.gammas.as_ref().ok()).collect();
        let best = |of: fn(f64, f64) -> f64| gammas.iter().map(|gammas| gammas.best.deflection_mm).reduce(of);
        let worst = gammas.iter().map(|gammas| gammas.worst.deflection_mm).reduce(f64::max);
        let possible = gammas.iter().map(|gammas| gammas.possible as f64).sum::<f64>() / gammas.len().max(1) as f64;
        let shown = |value: Option<f64>| or_dash(value, |value| millimetres_in_table(value, 3));
        table.add_row([
            report.axis_name(axis),
            format!("{} of {places}", gammas.len()),
            shown(best(f64::min)),
            shown(best(f64::max)),
            shown(worst),
            format!("{possible:.0} of {}", report.study.gamma_count()),
        ]);
    }
    format!(
        "Deflection of the tool at the best γ of each grid point (least, most), at the worst γ of any, and values of γ that are possible \
         on some branch:\n{table}\n"
    )
}
