//! Report of an online study: its page, tables and figure.

mod quantities;
mod text;

use serde_json::{Value, json};

use super::{Band, BreakEven, OnlineResults, OnlineStudy, Residual, Trial, run};
use crate::{
    answer::{Output, Run, facts_of, layers, machine::described},
    files::{
        Manifest,
        words::{counted, millimetres},
    },
    input::error::Result,
    page::{Column, Description, Explorer, Fact, Group, Section, TableNote},
    questions::{
        Answered,
        spread_report::{self, SpreadCounts},
    },
    simulation::spread_along::is_larger,
};
use quantities::{FORCE_ERROR, HIGH, LOW, MEDIAN, WAYS};

/// Study, results and their statistics over seeds, computed once for all reports.
struct Compared<'a> {
    study: &'a OnlineStudy,
    results: &'a OnlineResults,
    offline: Vec<Option<Band>>,
    online: Vec<Option<Band>>,
    break_even: Option<BreakEven>,
}

impl<'a> Compared<'a> {
    /// Computes what reports need of `results`: the bands over seeds and the break-even force error.
    fn new(study: &'a OnlineStudy, results: &'a OnlineResults) -> Self {
        let offline = Band::of(&results.trials, |trial| trial.offline);
        let online = Band::of(&results.trials, |trial| trial.online);
        let break_even = BreakEven::of(&offline, &online);
        Self { study, results, offline, online, break_even }
    }

    /// Returns the share of the trials at the largest force error that `counts`; `None` where there is none.
    fn share_at_largest(&self, counts: impl Fn(&Trial) -> bool) -> Option<f64> {
        let at_largest = self.results.trials.chunk_by(|a, b| a.force_error == b.force_error).last()?;
        Some(at_largest.iter().filter(|trial| counts(trial)).count() as f64 / at_largest.len() as f64)
    }

    /// Returns with which probability, at the largest force error, the rms residual by measured forces is smaller by more than 0.5 %; `None` without
    /// trials.
    fn measured_is_smaller(&self) -> Option<f64> {
        let rms = |residual: &Residual| residual.rms_mm.unwrap_or(f64::INFINITY);
        self.share_at_largest(|own| is_larger(rms(&own.offline), rms(&own.online), 0.0))
    }

    /// Returns with which probability, at the largest force error, off-line and on-line correction keep the whole path within tolerance; `None` without one.
    fn within_tolerance(&self) -> Option<[f64; 2]> {
        let tolerance = self.study.path.tolerance_mm?;
        let is_within = |own: &Residual| own.solved == own.points && own.max_mm.is_some_and(|most| most <= tolerance);
        Some([
            self.share_at_largest(|own| is_within(&own.offline))?,
            self.share_at_largest(|own| is_within(&own.online))?,
        ])
    }

    /// Returns what varies and the probabilities at the largest force error, as JSON; `None` where inputs are taken as exact.
    fn uncertainty_json(&self) -> Option<Value> {
        let mut all = spread_report::json(self.study.path.uncertainty.as_deref()?, &SpreadCounts::default());
        all["draws"] = json!(self.study.seeds);
        all["measured_is_smaller"] = json!(self.measured_is_smaller());
        all["within_tolerance"] = json!(self.within_tolerance());
        Some(all)
    }

    /// Returns the median RMS residuals of off-line and on-line correction at the largest force error, mm; `None` where one of them has none.
    fn medians_at_largest(&self) -> Option<[f64; 2]> {
        Some([(*self.offline.last()?)?.median_mm, (*self.online.last()?)?.median_mm])
    }
}

/// Formats `share` in per cent to at most two decimals, without any from 10 % on.
fn percent_of(share: f64) -> String {
    let percent = (1e4 * share).round() / 100.0;
    if percent >= 10.0 { format!("{percent:.0} %") } else { format!("{percent} %") }
}

/// Returns the break-even force error to one digit: it lies on a straight line between computed ones.
fn about_percent(error: f64) -> String {
    percent_of(format!("{error:.0e}").parse().unwrap_or(error))
}

impl Answered for OnlineStudy {
    /// Runs the study, and makes tables, figures, page and summary.
    fn answer(&self, (): &(), asked: &Run<'_>) -> Result<Output> {
        let results = run(self, asked.work)?;
        let compared = Compared::new(self, &results);
        let mut summary = json!({
            "schema": 1,
            "without_correction": results.plain,
            "break_even": compared.break_even,
            "loop_gain": results.loop_gain,
        });
        if let Some(uncertainty) = compared.uncertainty_json() {
            summary["uncertainty"] = uncertainty;
        }
        let figure = || quantities::residual_figure(&compared).map(|figure| ("answer".to_string(), figure));
        Ok(Output {
            is_answered: Some(compared.break_even.is_some()),
            tables: vec![
                ("trials".into(), quantities::trials_table(&results.trials)),
                ("bands".into(), quantities::bands_table(&compared)),
            ],
            figures: asked.draw_figures(|| figure().into_iter().collect()),
            details: text::details(&compared),
            ..Output::of(
                json!({ "points": self.path.stations.len(), "trials": results.trials.len() }),
                Manifest::count(results.trials.iter().map(quantities::status)),
                summary,
                Description { headline: text::headline(&compared), ..page(&compared) },
            )
        })
    }
}

/// Returns sections, setting, views and tables of the page; first screen, figures and question are added by the run.
fn page(compared: &Compared<'_>) -> Description {
    let study = compared.study;
    let of_cut = "change of cutting force per mm of depth of cut, N/mm; a control loop whose gain is below 1 converges";
    Description {
        setting: setting(study),
        terms: vec![
            Fact::new(
                "force error",
                "standard deviation of the force in the cut about the predicted one, as a share of it",
            ),
            Fact::new("cutting stiffness", of_cut),
        ],
        explorers: vec![bands_view()],
        tables: vec![
            TableNote::new("bands.csv", "One row per force error and way to correct: rms distances over seeds."),
            TableNote::new("trials.csv", "One row per force error and seed: residual errors of both ways to correct."),
        ],
        sections: vec![
            Section::new("What is the residual error of each correction?", "against the error of the predicted force")
                .text(&text::details(compared))
                .explorers([OVER_ERROR])
                .tables(["bands.csv", "trials.csv"]),
        ],
        ..Description::new("online", described(&study.path.machine))
    }
}

const OVER_ERROR: &str = "Residual error against the force error";

/// Returns the facts about the study that the page lists.
fn setting(study: &OnlineStudy) -> Vec<Fact> {
    let (path, sensor) = (&study.path, &study.sensor);
    // Without the rounding of its unit.
    let ms = |time_s: f64| (1000.0 * time_s * 1e9).round() / 1e9;
    let filter = sensor.low_pass_Hz.map_or_else(|| "no low-pass".into(), |corner| format!("low-pass at {corner} Hz"));
    let (length, feed) = (path.length_mm(), study.feed_mm_per_min);
    let sensor_words = format!(
        "{} ms late, {filter}, noise of {} N, bias of {} N (standard deviations)",
        ms(sensor.delay_s),
        sensor.noise_N,
        sensor.bias_N
    );
    let model = format!(
        "bends {} too {}, knows {} of the chain errors",
        percent_of(study.softness.abs()),
        if study.softness < 0.0 { "little" } else { "much" },
        percent_of(study.known_share)
    );
    let mut facts = vec![
        Fact::new("path", format!("{length:.1} mm at {feed} mm/min, {}", counted(path.stations.len(), "point"))),
        Fact::new("controller", format!("a command every {} ms", ms(sensor.cycle_s))),
        Fact::new("sensor", sensor_words),
        Fact::new("model", model),
    ];
    let limit = |label: &str, limit: Option<f64>| limit.map(|limit| Fact::new(label, millimetres(limit, 4)));
    facts.extend(limit("largest correction", study.limits.correction_mm));
    facts.extend(limit("largest change of the correction", study.limits.correction_change_mm));
    facts.extend(path.uncertainty.as_deref().map(|own| spread_report::fact_of_draws(Some(own), study.seeds)));
    facts.extend(path.facts.iter().map(|(label, text)| Fact::new(*label, text.clone())));
    facts_of(&path.machine, &path.errors, facts)
}

/// Returns the interactive view of the bands over the force error.
fn bands_view() -> Explorer {
    let ways = WAYS.map(|way| (way, format!("by the {way} force")));
    let group = Group::by_column("correction", "correction", ways);
    let over = vec![Column::new(FORCE_ERROR, "force error", "%")];
    Explorer::curve(OVER_ERROR, "bands.csv", over, Some(group), layers(&[MEDIAN, LOW, HIGH]))
}
