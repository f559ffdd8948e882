//! What is said of the feeds that were chosen for a program.

use serde_json::{Value, json};

use super::Report;
use crate::{
    figures::Figure,
    files::words::{counted, join_text},
    page::{Section, SmallTable},
    process::feed::FeedQuantity,
    products::program::{FoundFeeds, Placed, ProgramJob},
    questions::path::report::Curve,
};

/// Name of the figure.
const FIGURE: &str = "feed";
/// What stops a feed besides keys of the process.
const END: &str = "a force that is not known, as of the end of the tool,";

/// Returns a value with its unit.
fn shown(quantity: FeedQuantity, value: f64) -> String {
    let decimals = (2.0 - libm::log10(value.max(1e-9)).floor()).clamp(0.0, 6.0) as usize;
    format!("{value:.decimals$} {}", quantity.unit())
}

/// Returns what limits are not kept, as a sentence; empty where all are.
pub(super) fn verdict(job: &ProgramJob) -> String {
    let exceeded = job.feed.iter().flat_map(|feed| &feed.exceeded);
    let share = |own: &&(String, FeedQuantity, f64, f64)| own.2 / own.3;
    let Some((place, quantity, value, limit)) = exceeded.clone().max_by(|a, b| share(a).total_cmp(&share(b))) else {
        return String::new();
    };
    let mut lines: Vec<&String> = exceeded.map(|own| &own.0).collect();
    lines.dedup();
    format!(
        "Limits of [feed] are not kept in {}, though the feed is as slow as it may be there, or stays as that of a tap: {} is {} and its limit {} ({place}). ",
        counted(lines.len(), "place"),
        quantity.name(),
        shown(*quantity, *value),
        shown(*quantity, *limit)
    )
}

/// Returns that the feed is changed, as a sentence; empty where it is not.
pub(super) fn caution(job: &ProgramJob) -> String {
    let Some(feed) = job.feed.as_ref().filter(|feed| feed.words > 0) else { return String::new() };
    let [before, after] = feed.minutes;
    format!(
        "The feed is changed by {}: moves at feed rate take {after:.3} min, {before:.3} as programmed.\n",
        counted(feed.words, "F word")
    )
}

/// Returns how the feed changes and what stops it, in sentences; empty where it is as programmed.
pub(super) fn feed_text(report: &Report<'_>) -> String {
    let Some(feed) = &report.job.feed else { return String::new() };
    let FoundFeeds { minutes: [before, after], lines: [faster, slower, same, in_air], words, .. } = feed;
    let mut text = format!(
        "Moves at feed rate take {before:.3} min as programmed and {after:.3} min as written, without acceleration and rapid moves.\n\
         Lines fed faster: {faster}; slower: {slower}; as programmed: {same}; that cut nothing and stay: {in_air}. F words changed or new: {words}.\n"
    );
    let keys = FeedQuantity::ALL.map(FeedQuantity::key).into_iter().chain(["change", END]);
    let stopped = keys.zip(feed.stopped_by).filter(|own| own.1 > 0);
    let stopped: Vec<String> = stopped.map(|(key, count)| format!("{key} in {}", counted(count, "line"))).collect();
    if !stopped.is_empty() {
        let words: Vec<&str> = stopped.iter().map(String::as_str).collect();
        text += &format!("What stops the feed where the tool cuts: {}.\n", join_text(&words));
    }
    if report.job.uncertainty.is_some() {
        text += "The limits of [feed] are for nominal numbers: what is uncertain is not in them.\n";
    }
    text
}

/// Returns the section of the page about feeds that were chosen, what limits them and which limits are not kept; `None` if none were chosen.
pub(super) fn section(report: &Report<'_>) -> Option<Section> {
    let feed = report.job.feed.as_ref()?;
    let rows = feed.largest.iter().map(|(quantity, limit, values)| {
        let at = |(value, place): &Placed| format!("{} ({place})", shown(*quantity, *value));
        vec![quantity.name().to_string(), shown(*quantity, *limit), at(&values[0]), at(&values[1])]
    });
    let limits = SmallTable {
        caption: "Largest values where the tool cuts".into(),
        header: ["", "limit", "as programmed", "as written"].map(String::from).into(),
        rows: rows.collect(),
    };
    let rows = feed.exceeded.iter().map(|(place, quantity, value, limit)| {
        vec![place.clone(), quantity.name().into(), shown(*quantity, *value), shown(*quantity, *limit)]
    });
    let exceeded = SmallTable {
        caption: "Limits that are not kept".into(),
        header: ["place", "", "value", "limit"].map(String::from).into(),
        rows: rows.collect(),
    };
    let exceeded = (!feed.exceeded.is_empty()).then_some(exceeded);
    let section = Section::new("How fast is it fed?", "F words that were chosen, and what limits them");
    Some(section.text(&feed_text(report)).small_tables([limits].into_iter().chain(exceeded)).figures(&[FIGURE]))
}

/// Returns the feed along the path as a share of the programmed one.
pub(super) fn figure(job: &ProgramJob, draw: impl Fn(&[(String, &Curve)]) -> Figure) -> Option<(String, Figure)> {
    let feed = job.feed.as_ref()?;
    let mut curve = Curve::new(job.path.len());
    for (k, point) in job.path.points().iter().enumerate().filter(|own| own.1.feed_mm_per_min.is_some()) {
        curve.add(k, point.arc_length_mm, feed.ratios[point.source.segment]);
    }
    Some((FIGURE.into(), draw(&[("as written".into(), &curve)])))
}

/// Returns the same as JSON.
pub(super) fn json(feed: &FoundFeeds) -> Value {
    let keys = FeedQuantity::ALL.map(FeedQuantity::key).into_iter().chain(["change", "end_of_tool"]);
    let stopped: serde_json::Map<_, _> =
        keys.zip(feed.stopped_by).map(|(key, count)| (key.to_string(), json!(count))).collect();
    let [faster, slower, as_programmed, in_air] = feed.lines;
    let largest = feed.largest.iter().map(|(quantity, limit, [before, after])| {
        json!({
            "limit": quantity.key(), "limit_value": limit,
            "programmed": before.0, "programmed_at": before.1, "written": after.0, "written_at": after.1,
        })
    });
    let exceeded = feed.exceeded.iter().map(
        |(place, quantity, value, limit)| json!({ "at": place, "limit": quantity.key(), "value": value, "limit_value": limit }),
    );
    json!({
        "minutes_programmed": feed.minutes[0],
        "minutes_written": feed.minutes[1],
        "change": feed.limits.change,
        "lines": { "faster": faster, "slower": slower, "as_programmed": as_programmed, "in_air": in_air },
        "f_words": feed.words,
        "stopped_by": stopped,
        "largest": largest.collect::<Vec<_>>(),
        "not_kept": exceeded.collect::<Vec<_>>(),
    })
}
