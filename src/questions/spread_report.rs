//! What reports say of uncertain inputs and of the distributions that they make, in every question that computes them.

use std::collections::BTreeMap;

use serde_json::{Value, json};

use crate::{
    answer::Quantity,
    files::words::{counted, listed_up_to, percent},
    page::{Fact, table::format_number},
    process::uncertainty::{ASSUMED_RELATIVE_STD, Draws, UncertainParameter, Uncertainty},
    simulation::spread::DeflectionSpread,
};

/// A result at a place that may have a distribution, of which tables say how well it is known.
pub(crate) trait WithSpread: 'static {
    /// Returns the distribution; `None` where there is none.
    fn distribution(&self) -> Option<&DeflectionSpread>;
}

/// Lists the columns of a distribution that only tables have: why it is as it is, and how well it is known; the first three with these names.
pub(crate) fn columns<E: WithSpread>([error, cause, share]: [&'static str; 3]) -> [Quantity<E>; 7] {
    [
        Quantity::text("spread_reason", |found| found.ok().and_then(|own| own.distribution()?.reason()).into()),
        Quantity::in_table(error, |own: &E| own.distribution()?.p95_standard_error_mm),
        Quantity::text(cause, |found| found.ok().and_then(|own| own.distribution()?.main_cause.as_deref()).into()),
        Quantity::in_table(share, |own: &E| own.distribution()?.main_cause_share),
        Quantity::in_table("spread_check_difference", |own: &E| own.distribution()?.check_difference),
        Quantity::count("spread_solved_draws", |own: &E| Some(own.distribution()?.solved_draws)),
        Quantity::count("spread_failed_draws", |own: &E| Some(own.distribution()?.failed_draws)),
    ]
}

/// What is counted of the distributions at many points.
#[derive(Debug, Default)]
pub(crate) struct SpreadCounts {
    /// Number of points with a distribution.
    pub known: usize,
    /// Number of those without a 95 % quantile, as too many draws have no equilibrium.
    pub unknown: usize,
    /// Number of points at which the engine differed from the surrogate, so that more draws were solved.
    corrected: usize,
    /// Draws solved by the engine at all points that have no equilibrium.
    failed_draws: usize,
    /// Draws solved by the engine at all points.
    solved_draws: usize,
    /// Number of points of which each is the main cause, by name.
    causes: BTreeMap<String, usize>,
}

impl SpreadCounts {
    /// Adds the distribution at a point.
    pub fn add(&mut self, spread: &DeflectionSpread) {
        self.known += 1;
        self.corrected += usize::from(spread.solved_draws > 1);
        self.solved_draws += spread.solved_draws;
        self.unknown += usize::from(spread.p95_mm.is_none());
        self.failed_draws += spread.failed_draws;
        if let Some(cause) = &spread.main_cause {
            *self.causes.entry(cause.clone()).or_default() += 1;
        }
    }

    /// Returns the sentences about the main cause, the first by name of equally frequent ones, and about the check.
    pub fn sentences(&self) -> String {
        let most = self.causes.iter().max_by(|a, b| a.1.cmp(b.1).then(b.0.cmp(a.0)));
        let cause = most.map_or_else(String::new, |(name, count)| {
            let share = percent(*count as f64 / self.known as f64);
            format!("what spreads it most is {name}, at {share} of the points: know that better first.\n")
        });
        let corrected = match self.corrected {
            0 => String::new(),
            corrected => format!(
                " but for {}, where it was corrected by more draws ({} solved in all)",
                counted(corrected, "point"),
                self.solved_draws
            ),
        };
        cause
            + &format!(
                "The engine, solved at each of {} in the draw at the 95 % quantile, agrees with the estimate within 0.5 %{corrected}.\n",
                counted(self.known, "point")
            )
    }
}

/// Counts what varies: "6 uncertain parameters and an uncertain force".
pub(crate) fn counted_inputs(uncertainty: &Uncertainty) -> String {
    let parameters = match uncertainty.parameters.len() {
        0 => None,
        count => Some(counted(count, "uncertain parameter")),
    };
    let words: Vec<String> =
        parameters.into_iter().chain(uncertainty.force.map(|_| "an uncertain force".into())).collect();
    words.join(" and ")
}

/// Formats a probability: that no draw, or each, does something does not make it impossible or certain.
pub(crate) fn probability(share: f64) -> String {
    let unseen = 2.0 / Draws::COUNT as f64;
    percent(share.clamp(unseen, 1.0 - unseen))
}

/// Words for the first screen: how inputs were taken.
pub(crate) fn basis(uncertainty: Option<&Uncertainty>) -> String {
    uncertainty.map_or_else(|| "inputs taken as exact".into(), |_| counted(Draws::COUNT, "draw"))
}

/// Parameters that a caution names.
const MOST_NAMED: usize = 4;

/// Returns the cautions about what the distributions that `counts` counts rest on; empty where inputs are taken as exact.
pub(crate) fn cautions(uncertainty: Option<&Uncertainty>, counts: &SpreadCounts) -> String {
    let Some(uncertainty) = uncertainty else { return String::new() };
    let mut text = String::new();
    let assumed = listed_up_to(MOST_NAMED, uncertainty.assumed().map(String::from));
    if !assumed.is_empty() {
        text += &format!(
            "The spread rests on assumptions: {assumed} are graded as assumed in the machine file and vary by {:.0} %, a default.\n",
            100.0 * ASSUMED_RELATIVE_STD
        );
    }
    let exact = listed_up_to(MOST_NAMED, uncertainty.exact_stiffnesses());
    if !exact.is_empty() {
        text += &format!("Taken as exact, as nobody says how well they are known: {exact}.\n");
    }
    if !uncertainty.cut.is_empty() {
        text += &format!(
            "Not taken from the identification, but varied by themselves or not at all: {}.\n",
            listed_up_to(MOST_NAMED, uncertainty.cut.iter().cloned())
        );
    }
    let SpreadCounts { unknown, failed_draws, solved_draws, .. } = counts;
    if *failed_draws > 0 {
        text += &format!(
            "In {failed_draws} of {} that the engine solved the machine has no equilibrium.\n",
            counted(*solved_draws, "draw")
        );
    }
    if *unknown > 0 {
        text += &format!(
            "At {} more than 5 % of the draws have no equilibrium: there is no 95 % quantile, and the tool is not within tolerance.\n",
            counted(*unknown, "point")
        );
    }
    text
}

/// Uncertain parameters that the page lists; summary.json has all.
const MOST_SHOWN: usize = 12;

/// Returns the fact of the page about what varies in which 95 % interval.
pub(crate) fn fact(uncertainty: Option<&Uncertainty>) -> Fact {
    let words = |uncertainty: &Uncertainty| {
        let interval = |ends: [f64; 2]| ends.map(format_number).join(" to ");
        let parameter = |own: &UncertainParameter| {
            let (words, source) = (own.spread.words(), own.source.label());
            format!("{} {} {} ({words}, {source})", own.name(), interval(own.interval_95()), own.unit)
        };
        let parameters = listed_up_to(MOST_SHOWN, uncertainty.parameters.iter().map(parameter));
        let force = uncertainty.force_factor_95().map(|own| format!("cutting force × {}", interval(own)));
        let words: Vec<String> = Some(parameters).filter(|words| !words.is_empty()).into_iter().chain(force).collect();
        format!("95 % intervals: {}; {} draws", words.join(", "), Draws::COUNT)
    };
    Fact::new("uncertain inputs", uncertainty.map_or_else(|| "none: all are taken as exact".into(), words))
}

/// Returns what varies, and what `counts` counts, as JSON.
pub(crate) fn json(uncertainty: &Uncertainty, counts: &SpreadCounts) -> Value {
    let parameter = |own: &UncertainParameter| {
        let names: Vec<&str> = own.values.iter().map(|(name, _)| name.as_str()).collect();
        let (unit, [low, high]) = (own.unit.in_files(), own.interval_95());
        let (distribution, source) = (own.spread.words(), own.source.label());
        json!({ "names": names, "unit": unit, "low_95": low, "high_95": high, "distribution": distribution, "source": source })
    };
    json!({
        "parameters": uncertainty.parameters.iter().map(parameter).collect::<Vec<Value>>(),
        "force_factor_95": uncertainty.force_factor_95(),
        "draws": Draws::COUNT,
        "points_corrected": counts.corrected,
        "points_without_p95": counts.unknown,
        "failed_draws": counts.failed_draws,
        "main_causes": counts.causes,
    })
}
