//! What reports say of uncertain inputs and of the distributions that they make, in every question that computes them.

use std::collections::BTreeMap;

use serde_json::{Map, Value, json};

use crate::{
    answer::Quantity,
    files::words::{self, counted, join_text, listed_up_to, millimetres, or_dash, percent},
    machine::Machine,
    page::{
        Fact,
        headline::{InTable, KeyNumber, State, Verdict},
        table::format_number,
    },
    process::uncertainty::{
        Cause, Draws, ForceSpread, ModelError, P95, Role, UNMEASURED_FORCE_STD, UncertainParameter, Uncertainty,
        Z_95_INTERVAL,
    },
    simulation::{
        spread::{Audit, DeflectionSpread, IfMeasured},
        spread_along::{LargestSpread, PathSpread},
    },
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
        Quantity::in_table("spread_failed_share", |own: &E| Some(own.distribution()?.failed_share)),
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
    /// Number of points at which some draws have no equilibrium.
    failing: usize,
    /// The largest share of draws without equilibrium at one point, and why the first there has none.
    pub most_failing: (f64, String),
    /// Draws solved by the engine at all points.
    solved_draws: usize,
    /// Number of points at which a draw was solved by the engine.
    checked: usize,
    /// Draws chosen at random that the engine solved at all points.
    audit: Audit,
    /// Number of points of which each is the main cause, and the sum of its shares of the variance there, by name.
    causes: BTreeMap<String, (usize, f64)>,
}

impl SpreadCounts {
    /// Adds the distribution at a point.
    pub fn add(&mut self, spread: &DeflectionSpread) {
        self.known += 1;
        self.checked += usize::from(spread.solved_draws > 0);
        self.corrected += usize::from(spread.is_corrected);
        self.solved_draws += spread.solved_draws;
        self.unknown += usize::from(spread.p95_mm.is_none());
        self.failing += usize::from(spread.failed_share > 0.0);
        if spread.failed_share > self.most_failing.0 {
            self.most_failing = (spread.failed_share, spread.first_failure.clone().unwrap_or_default());
        }
        self.audit.add(&spread.audit);
        if let Some(cause) = &spread.main_cause {
            let (count, shares) = self.causes.entry(cause.clone()).or_default();
            *count += 1;
            *shares += spread.main_cause_share.unwrap_or_default();
        }
    }

    /// Returns the names of the causes that spread the answer most somewhere.
    pub fn causes(&self) -> impl Iterator<Item = &str> {
        self.causes.keys().map(String::as_str)
    }

    /// Returns the sentence about the main cause, the first by name of equally frequent ones, with what to do `next` if that is known.
    fn next_step(&self, point: &str, next: Option<&str>) -> String {
        let most = self.causes.iter().max_by(|a, b| a.1.0.cmp(&b.1.0).then(b.0.cmp(a.0)));
        most.map_or_else(String::new, |(name, (count, shares))| {
            let (share, known) = (percent(shares / *count as f64), counted(self.known, point));
            let first = match name == Cause::MODEL {
                true => ": measure the machine under load and identify it first.",
                false => ": know that better first.",
            };
            format!(
                "What spreads the answer most is {name}, with {share} of the variance at {count} of {known}{}\n",
                next.unwrap_or(first)
            )
        })
    }

    /// Returns the sentence about the check, at what is called `point`.
    pub fn sentences(&self, point: &str) -> String {
        let corrected = match self.corrected {
            0 => String::new(),
            corrected => format!(
                " but for {}, where it was corrected by more draws ({} solved in all)",
                counted(corrected, point),
                self.solved_draws
            ),
        };
        let audit = match self.audit {
            Audit { draws: 0, .. } => String::new(),
            Audit { draws, failed, unforeseen, compared, apart, largest } => format!(
                "Of {} that it solved there as well, chosen at random, the machine has no equilibrium in {}, {unforeseen} of them left out by the estimate; of \
                 the {compared} others at which nothing was corrected, it is off by more than 1 % of the 95 % quantile in {}, by at most {:.1} %.\n",
                counted(draws, "draw"),
                share_of(failed, draws),
                share_of(apart, compared),
                100.0 * largest,
            ),
        };
        match self.checked {
            0 => "Nothing moves the tool by more than rounding: no draw was solved by the engine.\n".into(),
            checked => format!(
                "The engine, solved at each of {} in draws next to the 95 % quantile, agrees with the estimate within 0.5 %{corrected}.\n{audit}",
                counted(checked, point)
            ),
        }
    }
}

/// Says behind the main cause what is worth most to measure.
pub(crate) fn worth_most(IfMeasured { cause, known, p95_mm: [now, then] }: &IfMeasured) -> String {
    format!(
        ". Worth most: {cause} {known}. Where the 95 % quantile is the largest, that of this place alone would fall from {} to {}, as solved anew there.",
        millimetres(*now, 3),
        millimetres(*then, 3)
    )
}

/// Formats a count out of independent ones with its share and the 95 % interval of that (Wilson's): "3 (0.3 %; 95 % interval 0.1 to 0.9 %)".
pub(crate) fn share_of(count: usize, all: usize) -> String {
    if all == 0 {
        return "none".into();
    }
    let [low, high] = share_interval(count, all).map(|share| 100.0 * share);
    format!("{count} ({:.1} %; 95 % interval {low:.1} to {high:.1} %)", 100.0 * count as f64 / all as f64)
}

/// Returns the 95 % interval (Wilson's) of a probability, of which `count` of `all` independent cases came true.
pub(crate) fn share_interval(count: usize, all: usize) -> [f64; 2] {
    let (share, all, square) = (count as f64 / all as f64, all as f64, Z_95_INTERVAL * Z_95_INTERVAL);
    let half = (square * (share * (1.0 - share) / all + square / (4.0 * all * all))).sqrt();
    [-half, half].map(|half| ((share + square / (2.0 * all) + half) / (1.0 + square / all)).clamp(0.0, 1.0))
}

/// Counts what varies: "6 uncertain parameters and an uncertain force".
pub(crate) fn counted_inputs(uncertainty: &Uncertainty) -> String {
    let parameters = match uncertainty.parameters.len() {
        0 => None,
        count => Some(counted(count, "uncertain parameter")),
    };
    let model = (uncertainty.model.relative_std > 0.0).then(|| "an inexact model".into());
    let ForceSpread { sharp, wear, .. } = uncertainty.force;
    let varies = sharp.is_some() || uncertainty.force.has_components();
    let force = varies.then(|| "an uncertain force".into()).into_iter().chain(wear.map(|_| "tool wear".into()));
    let words: Vec<String> = parameters.into_iter().chain(force).chain(model).collect();
    join_text(&words.iter().map(String::as_str).collect::<Vec<_>>())
}

/// Formats a probability that is a share of so many `draws`, four or more: what none of them, or each, does says that it is smaller or larger than two in all
/// would.
pub(crate) fn share_text(share: f64, draws: usize) -> String {
    let (words, unseen) = (words::probability(share, draws), 2.0 / draws as f64);
    match share {
        share if share < unseen => format!("less than {words}"),
        share if share > 1.0 - unseen => format!("more than {words}"),
        _ => words,
    }
}

/// Formats a probability that is a share of all draws.
pub(crate) fn probability(share: f64) -> String {
    words::probability(share, Draws::COUNT)
}

/// Returns the caution of `what`, such as "the map", that errors of the setup are no part of it; empty where there are none.
pub(crate) fn setups_left_out(uncertainty: Option<&Uncertainty>, what: &str) -> String {
    let setups: Vec<&str> = uncertainty.into_iter().flat_map(Uncertainty::setups).collect();
    match setups[..] {
        [] => String::new(),
        _ => format!(
            "Not in {what}, as it is no deflection: the error of {}. A path or a program has it.\n",
            join_text(&setups)
        ),
    }
}

/// Words for the first screen: how inputs were taken.
pub(crate) fn basis(uncertainty: Option<&Uncertainty>) -> String {
    uncertainty.map_or_else(|| "inputs taken as exact".into(), |_| counted(Draws::COUNT, "draw"))
}

/// Returns the condition of a verdict behind its first words where no stiffness varies, so that it says little of the machine; else empty.
pub(crate) fn condition(uncertainty: Option<&Uncertainty>) -> &'static str {
    let varies = |own: &Uncertainty| own.parameters.iter().any(|own| own.role == Role::Elasticity);
    let is_exact = uncertainty.is_some_and(|own| !varies(own) && own.exact_stiffnesses().next().is_some());
    if is_exact { ", with all stiffnesses taken as exact" } else { "" }
}

/// Parameters that a caution names.
const MAX_NAMED: usize = 4;

/// Returns what to know better first, or do `next` if that is known, and the cautions about what the distributions that `counts` counts rest on; empty where
/// inputs are taken as exact.
pub(crate) fn cautions(
    uncertainty: Option<&Uncertainty>,
    counts: &SpreadCounts,
    point: &str,
    next: Option<&str>,
) -> String {
    let Some(uncertainty) = uncertainty else { return String::new() };
    let SpreadCounts { unknown, audit, .. } = counts;
    let mut text = match (counts.failing, &counts.most_failing) {
        (0, _) => String::new(),
        (failing, (share, reason)) => format!(
            "At {} the machine has no equilibrium in some draws ({} of them at the worst), which count as out of any tolerance: {}.\n",
            counted(failing, point),
            percent(*share),
            reason.trim_end_matches('.')
        ),
    };
    if *unknown > 0 {
        text += &format!(
            "At {} these are more than 5 %: there is no 95 % quantile, and the tolerance is not met. The largest 95 % quantile is that of the others.\n",
            counted(*unknown, point)
        );
    }
    if audit.unforeseen > 0 {
        text += &format!(
            "Of {}, chosen at random, the machine has no equilibrium in {} that are not counted here.\n",
            counted(audit.draws, "draw"),
            share_of(audit.unforeseen, audit.draws)
        );
    }
    text += &counts.next_step(point, next);
    for (grade, std, [low, high], names) in uncertainty.graded() {
        text += &format!(
            "The spread rests on a default: {} graded as {} in the machine file without an interval, and vary with a standard deviation of {:.0} %, 95 % of the values between {low:.2} and {high:.2} times it.\n",
            listed_up_to(MAX_NAMED, names.into_iter().map(String::from)) + " are",
            grade.label().replace('_', " "),
            100.0 * std
        );
    }
    if uncertainty.force.is_exact() {
        text += &format!(
            "The cutting force is taken as exact; one that nobody measured has a standard deviation of about {:.0} % (force_relative_std in [uncertainty.process]).\n",
            100.0 * UNMEASURED_FORCE_STD
        );
    }
    if uncertainty.model.is_assumed() {
        text += &format!(
            "The model itself is assumed to be wrong by {} of what the force does, as it was of one measured robot (FANUC R-2000iC). An identification of this \
             machine, or [uncertainty.model], says it.\n",
            percent(uncertainty.model.relative_std)
        );
    }
    if uncertainty.finds_no_provenance {
        text += "machine = \"provenance\" adds nothing: the machine file has no interval and no graded stiffness that is not named otherwise.\n";
    }
    let exact = listed_up_to(MAX_NAMED, uncertainty.exact_stiffnesses());
    if !exact.is_empty() {
        text += &match uncertainty.is_exact_by_choice {
            true => format!("Taken as exact, as machine = \"exact\" says: {exact}.\n"),
            false => format!(
                "Taken as exact, as nobody says how well they are known: {exact}. Entries [[uncertainty.parameter]] let them vary.\n"
            ),
        };
    }
    if !uncertainty.dropped_correlations.is_empty() {
        text += &format!(
            "Not taken from the identification, but varied by themselves or not at all: {}.\n",
            listed_up_to(MAX_NAMED, uncertainty.dropped_correlations.iter().cloned())
        );
    }
    text
}

/// How sentences about the distribution along a path name it.
pub(crate) struct Along<'a> {
    /// The machine.
    pub machine: &'a Machine,
    /// The path, such as "this path".
    pub path: String,
    /// Words for the compensated commands, behind "the tool of …": "compensated".
    pub commands: &'a str,
    /// Why the distribution with compensation may not be of all points, behind "the others".
    pub missing: &'a str,
    /// Number of points that the largest distance should be of.
    pub points: usize,
    /// What is uncertain.
    pub uncertainty: Option<&'a Uncertainty>,
    /// Largest distance that is within tolerance, mm.
    pub tolerance_mm: Option<f64>,
    /// Why there is no verdict, such as "Nothing is cut"; `None` where there is.
    pub unjudged: Option<&'static str>,
    /// Largest distance with these commands where the force is absent, mm, and where; `None` where none is known.
    pub without_force: Option<(f64, String)>,
}

/// Why a path without cutting force has no verdict.
pub(crate) const NO_FORCE: &str = "No cutting force is given";
/// Why a path on which nothing is cut has none.
pub(crate) const NOTHING_CUT: &str = "Nothing is cut";
/// How a program that is written without compensation is called.
pub(crate) const AS_PROGRAMMED: &str = "as programmed";
/// Why a path that the machine cannot run has none.
pub(crate) const OUTSIDE: &str = "Outside the workspace box";

impl Along<'_> {
    /// The tolerance by which it is judged, mm; `None` without one, or where there is no verdict.
    fn judged_by(&self) -> Option<f64> {
        self.tolerance_mm.filter(|_| self.unjudged.is_none())
    }

    /// How far the commands lead the tool off the path if the force is absent, mm, and where, if that is out of tolerance; else `None`, as for
    /// commands as programmed.
    fn out_without_force(&self) -> Option<&(f64, String)> {
        let tolerance = self.judged_by()?;
        self.without_force.as_ref().filter(|(off, _)| *off > tolerance && self.commands != AS_PROGRAMMED)
    }

    /// Returns the largest distance where the force is absent as a key number, which stands in a table as `found` says.
    pub fn without_force_number(&self, found: impl FnOnce(f64) -> InTable) -> Option<KeyNumber> {
        let (off, place) = self.without_force.as_ref()?;
        let what = format!(
            "largest distance, {}, where the force is absent: in air, a spring pass, a broken tool",
            self.commands
        );
        let out = if self.out_without_force().is_some() { "out of tolerance; " } else { "" };
        Some(
            KeyNumber::new(&millimetres(*off, 3), what, format!("{out}{place}"))
                .held_to(self.judged_by(), *off)
                .found(found(*off)),
        )
    }
}

/// Formats a quantile of the largest distance, or says that there is none.
pub(crate) fn quantile_text(quantile: Option<f64>) -> String {
    let unknown = || "an unknown distance (too many draws have no equilibrium)".into();
    quantile.map_or_else(unknown, |own| millimetres(own, 3))
}

/// Returns the cautions about the largest distance from a path, where inputs are uncertain: what it is not of, and whether it is
/// confirmed.
pub(crate) fn along_cautions(along: &Along<'_>, whole: Option<&PathSpread>) -> String {
    let (Some(whole), points) = (whole, along.points) else { return String::new() };
    let of = |name: &str, others: &str, own: &LargestSpread| {
        let mut text = String::new();
        if own.points < points {
            text += &format!(
                "The distribution of the largest distance {name} is of {} of {}: the others {others}.\n",
                own.points,
                counted(points, "point")
            );
        }
        if own.spread.failed_share > 0.0 {
            text += &format!(
                "The machine has no equilibrium somewhere along the path, {name}, in {} of the draws: they count as out of any tolerance.\n",
                percent(own.spread.failed_share)
            );
        }
        if !own.is_confirmed {
            text += &match own.spread.solved_draws {
                0 => format!(
                    "There is no 95 % quantile of the largest distance {name}: too many draws have no equilibrium.\n"
                ),
                solved => format!(
                    "The distribution of the largest distance {name} is an estimate: {} the engine solved along the whole path, {} of them without \
                     equilibrium, and they do not confirm it.\n",
                    counted(solved, "draw"),
                    own.spread.failed_draws
                ),
            };
        }
        text
    };
    let compensated = whole.compensated.as_ref();
    let compensated = compensated.map(|own| of(along.commands, along.missing, own)).unwrap_or_default();
    let harmful = by_drive(along, whole).into_iter().filter(|(_, worse)| *worse > 0.5);
    let harmful = harmful.map(|(drive, worse)| {
        let worse = probability(worse);
        format!("The correction of drive {drive} probably does harm: without it the largest distance is smaller with {worse} probability.\n")
    });
    of("without compensation", "have no equilibrium", &whole.plain) + &compensated + &harmful.collect::<String>()
}

/// Returns the sentences about the distribution of the largest distance.
pub(crate) fn along_sentences(along: &Along<'_>, whole: &PathSpread) -> String {
    let within = |own: &LargestSpread| {
        let share = own.spread.within_tolerance.zip(along.judged_by());
        share.map_or_else(String::new, |(share, tolerance)| {
            format!(" (within {tolerance} mm all along it with {} probability)", probability(share))
        })
    };
    let mut text = format!(
        "With {} (one machine and one force for the whole path), the tool without compensation stays within {} of its path with 95 % probability{}.\n",
        along.uncertainty.map(counted_inputs).unwrap_or_default(),
        quantile_text(whole.plain.spread.p95_mm),
        within(&whole.plain)
    );
    let compensated = whole.compensated.as_ref().filter(|_| along.commands != AS_PROGRAMMED);
    if let Some(own) = compensated {
        text += &format!(
            "The tool, {} (computed with nominal numbers), stays within {} with 95 % probability{}; the median is {}.\n",
            along.commands,
            quantile_text(own.spread.p95_mm),
            within(own),
            quantile_text(own.spread.median_mm)
        );
    }
    let worse = whole.worse.filter(|_| compensated.is_some()).map(probability);
    text += &worse.map_or_else(String::new, |worse| {
        format!("Compensation makes the largest distance larger by more than 0.5 % with {worse} probability.\n")
    });
    let by_drive = by_drive(along, whole);
    if !by_drive.is_empty() {
        let words: Vec<String> =
            by_drive.iter().map(|(drive, worse)| format!("{drive} {}", probability(*worse))).collect();
        text += &format!(
            "Probability that the correction of a single drive, all others being corrected, makes it larger by more than 0.5 % (estimates): {}.\n",
            words.join(", ")
        );
    }
    text
}

/// Returns each drive with the probability that its correction makes the largest distance larger; none where that is not known, or there is one drive.
fn by_drive(along: &Along<'_>, whole: &PathSpread) -> Vec<(String, f64)> {
    let labels = along.machine.drive_labels().into_iter();
    let all: Vec<(String, f64)> = labels.zip(whole.worse_by_drive.iter().copied()).collect();
    if all.len() > 1 { all } else { Vec::new() }
}

/// Returns the first words of a verdict, where all is within tolerance with the probability `share`.
pub(crate) fn verdict_word(share: f64) -> &'static str {
    match share {
        share if share >= P95 => "Within tolerance",
        share if share < 1.0 - P95 => "Out of tolerance",
        share if share < 0.5 => "Probably out of tolerance",
        _ => "Probably within tolerance",
    }
}

/// Verdict on commands that lead the tool out of tolerance in air, in a spring pass and with a broken tool.
pub(crate) const ONLY_UNDER_FORCE: &str = "Within tolerance, but not without the force";

/// Returns the verdict on what is within tolerance with the probability `share`.
pub(crate) fn probable_state(share: f64) -> Verdict {
    let sure = probability(share);
    match share {
        share if share >= P95 => Verdict::new(State::Good, format!("Within tolerance with {sure} probability")),
        share if share >= 0.5 => Verdict::new(State::Partly, format!("Within tolerance with only {sure} probability")),
        share => Verdict::new(State::Bad, format!("Out of tolerance with {} probability", probability(1.0 - share))),
    }
}

/// Returns the verdict by the distribution of the largest distance after compensation, in a few words.
pub(crate) fn along_state(along: &Along<'_>, whole: &PathSpread) -> Verdict {
    let judged = whole.compensated.as_ref().unwrap_or(&whole.plain);
    let missing = along.points - judged.points;
    let share = judged.spread.within_tolerance.filter(|_| along.judged_by().is_some());
    if missing > 0 {
        return Verdict::new(State::Bad, format!("{missing} of {} points not solved", along.points));
    }
    if whole.worse.is_some() && whole.is_probably_worse() {
        return Verdict::new(State::Bad, "Probably worse than without compensation");
    }
    match (share, along.tolerance_mm) {
        (Some(share), _) if share >= P95 && along.out_without_force().is_some() => {
            Verdict::new(State::Partly, ONLY_UNDER_FORCE)
        }
        (Some(share), _) => probable_state(share),
        (None, None) => Verdict::new(State::Open, "No tolerance given"),
        (None, Some(_)) => Verdict::new(State::Open, "Nothing to judge"),
    }
}

/// Returns the verdict by the distribution of the largest distance after compensation.
pub(crate) fn along_verdict(along: &Along<'_>, whole: &PathSpread) -> String {
    let (Along { path, points, .. }, name) = (along, &along.machine.name);
    let (judged, how) = match &whole.compensated {
        Some(own) => (own, along.commands),
        None => (&whole.plain, "without compensation, as none was found"),
    };
    let without = match &whole.compensated {
        Some(own) if own.points == whole.plain.points => {
            format!(" ({} without compensation)", quantile_text(whole.plain.spread.p95_mm))
        }
        _ => String::new(),
    };
    let missing = points - judged.points;
    let (unknown, all_along) = match missing {
        0 => (String::new(), format!("all along {path}")),
        missing => {
            let why = if whole.compensated.is_some() { along.missing } else { "have no equilibrium" };
            let text = format!("Not known along all of {path}: {missing} of {} {why}. ", counted(*points, "point"));
            (text, "at the others".into())
        }
    };
    let stays = match judged.spread.p95_mm {
        Some(p95) => format!("within {} with 95 %{without}", millimetres(p95, 3)),
        None => "within an unknown distance with 95 %, as too many draws have no equilibrium,".into(),
    };
    let sure = match judged.spread.within_tolerance.zip(along.judged_by()) {
        None => format!("The tool of {name}, {how}, stays {stays} {all_along}."),
        Some((share, tolerance)) => {
            let word = if missing > 0 { "At the others" } else { verdict_word(share) };
            let all_along = if missing == 0 { format!(" {all_along}") } else { String::new() };
            let condition = condition(along.uncertainty);
            let probability = probability(share);
            let (cutting, absent) = match along.out_without_force().filter(|_| share >= 0.5) {
                None => ("", String::new()),
                Some((off, place)) => (
                    " under the cutting force",
                    format!(
                        " Not without it: in air, in a spring pass or with a broken tool the same commands lead it off by up to {}, {place}.",
                        millimetres(*off, 3)
                    ),
                ),
            };
            format!(
                "{word}{cutting}{condition}: the tool of {name}, {how}, stays within {tolerance} mm{all_along} with {probability} probability, \
                 {stays}.{absent}"
            )
        }
    };
    let unjudged = along.unjudged.map_or_else(String::new, |why| format!("{why}: there is no verdict. "));
    // What does more harm than good is no success, whatever the tolerance.
    let worse = whole.worse.filter(|_| whole.is_probably_worse()).map_or_else(String::new, |worse| {
        format!("Probably worse than without compensation, with {} probability. ", probability(worse))
    });
    unknown + &unjudged + &worse + &sure
}

/// Returns the first sentence: within what the tool stays with 95 % probability, compensated and without.
pub(crate) fn along_sentence(along: &Along<'_>, whole: &PathSpread) -> String {
    let within = |own: &LargestSpread| {
        own.spread.p95_mm.map_or_else(|| "unknown".into(), |own| format!("within {}", millimetres(own, 3)))
    };
    let how = if along.commands == AS_PROGRAMMED { AS_PROGRAMMED } else { "compensated" };
    match &whole.compensated {
        Some(own) => format!("Off with 95 %: {} {how}, {} without.", within(own), within(&whole.plain)),
        None => format!("Off with 95 %: {} without compensation; none was found.", within(&whole.plain)),
    }
}

/// Returns what to do next along a path, behind the main cause; `None` if only the cause says it.
pub(crate) fn next_along(whole: Option<&PathSpread>) -> Option<String> {
    whole?.compensated.as_ref()?.if_measured.as_ref().map(worth_most)
}

/// Returns the 95 % quantiles of the largest distance as key numbers, compensated first.
pub(crate) fn along_numbers(along: &Along<'_>, whole: &PathSpread) -> Vec<KeyNumber> {
    let against = |own: &LargestSpread| {
        let share = own.spread.within_tolerance.filter(|_| along.judged_by().is_some());
        share.map(|share| format!("within tolerance with {} probability", probability(share)))
    };
    let worse = |share| format!("worse than without compensation with {} probability", probability(share));
    let number = |own: &LargestSpread, how: &str, worse: Option<String>| {
        let size = or_dash(own.spread.p95_mm, |own| millimetres(own, 3));
        let what = format!("largest distance from the path not exceeded with 95 % probability, {how}");
        let number = KeyNumber::new(&size, what, against(own).into_iter().chain(worse).collect::<Vec<_>>().join("; "));
        number.held_to(along.judged_by(), own.spread.p95_mm.unwrap_or(f64::INFINITY))
    };
    let compensated = whole.compensated.iter().map(|own| number(own, along.commands, whole.worse.map(worse)));
    compensated.chain([number(&whole.plain, "without compensation", None)]).collect()
}

/// Uncertain parameters that the page lists; summary.json has all.
const MAX_SHOWN: usize = 12;

/// Returns the fact of the page about what varies in which 95 % interval.
pub(crate) fn fact(uncertainty: Option<&Uncertainty>) -> Fact {
    fact_of_draws(uncertainty, Draws::COUNT)
}

/// Returns the fact of [`fact`] where the first `draws` are used.
pub(crate) fn fact_of_draws(uncertainty: Option<&Uncertainty>, draws: usize) -> Fact {
    let words = |uncertainty: &Uncertainty| {
        let interval = |ends: [f64; 2]| ends.map(format_number).join(" to ");
        let parameter = |own: &UncertainParameter| {
            let (words, source) = (own.spread.text(), own.source.label());
            format!("{} {} {} ({words}, {source})", own.name(), interval(own.interval_95()), own.unit)
        };
        let parameters = listed_up_to(MAX_SHOWN, uncertainty.parameters.iter().map(parameter));
        let wear = |most| format!(", of which tool wear × 1 to {}", format_number(1.0 + most));
        let wear = uncertainty.wear_force_increase().map_or_else(String::new, wear);
        let each = match uncertainty.tools.len() {
            0 | 1 => String::new(),
            tools => format!(" (each of {tools} tools by itself)"),
        };
        let force = uncertainty.force_factor_95().map(|own| format!("cutting force × {}{wear}{each}", interval(own)));
        let components =
            uncertainty.component_factors_95().map(|(name, own)| format!("{name} × {}{each}", interval(own)));
        let words = Some(parameters).filter(|words| !words.is_empty()).into_iter().chain(force).chain(components);
        let words: Vec<String> = words.collect();
        let ModelError { relative_std, source } = uncertainty.model;
        let model =
            || format!("the model leaves out {} of what the force does ({}); ", percent(relative_std), source.label());
        let model = if relative_std > 0.0 { model() } else { String::new() };
        let intervals =
            if words.is_empty() { String::new() } else { format!("95 % intervals: {}; ", words.join(", ")) };
        format!("{intervals}{model}{draws} draws")
    };
    Fact::new("uncertain inputs", uncertainty.map_or_else(|| "none: all are taken as exact".into(), words))
}

/// Returns what varies, and what `counts` counts, as JSON.
pub(crate) fn json(uncertainty: &Uncertainty, counts: &SpreadCounts) -> Value {
    let parameter = |own: &UncertainParameter| {
        let names: Vec<&str> = own.values.iter().map(|(name, _)| name.as_str()).collect();
        let names = if names.is_empty() { vec![own.name()] } else { names };
        let (unit, [low, high]) = (own.unit.in_files(), own.interval_95());
        let (distribution, source) = (own.spread.text(), own.source.label());
        json!({ "names": names, "unit": unit, "low_95": low, "high_95": high, "distribution": distribution, "source": source })
    };
    json!({
        "parameters": uncertainty.parameters.iter().map(parameter).collect::<Vec<Value>>(),
        "force_factor_95": uncertainty.force_factor_95(),
        "force_component_factors_95": uncertainty.component_factors_95().collect::<BTreeMap<_, _>>(),
        "wear_force_increase": uncertainty.wear_force_increase(),
        "force_of_tools": Some(&uncertainty.tools).filter(|own| !own.is_empty()),
        "model_relative_std": uncertainty.model.relative_std,
        "model_source": uncertainty.model.source.label(),
        "seed": uncertainty.draws.seed,
        "draws": Draws::COUNT,
        "points_corrected": counts.corrected,
        "points_without_p95": counts.unknown,
        "largest_failed_share": counts.most_failing.0,
        "audit": counts.audit,
        "main_causes": counts.causes.iter().map(|(name, (count, _))| (name.clone(), json!(count))).collect::<Map<_, _>>(),
    })
}
