//! Data of a page about one view of several results: numbers side by side, differences, and which result is better where.

use serde::Serialize;

use super::{
    aligned::{Aligned, label_with_unit},
    dataset::Dataset,
    description::{Better, Column, Mark, Quantity, Shape},
    folder::ResultFolder,
    packed::{Packed, Precision, script_json},
    single::{ExplorerView, group_labels, precision_note},
    table::format_number,
    winners::{Extremes, Winners, difference_text, is_same, percent},
};
use crate::files::words::with_unit;

/// A view of several results, as the comparison page shows it; its statistics are taken `over` the named nodes.
#[derive(Debug, Serialize)]
pub(super) struct Compared {
    view: ExplorerView,
    over: String,
    nouns: String,
    table: Vec<StatisticRow>,
    wins: Vec<WinsRow>,
    notes: Vec<String>,
}

/// Numbers of a view of several results, for the page's script.
#[derive(Debug, Serialize)]
struct ComparedData<'a> {
    shape: Shape,
    title: &'a str,
    coordinates: &'a [Column],
    group_label: &'a str,
    groups: Vec<&'a str>,
    labels: Vec<String>,
    units: Vec<&'a str>,
    better: Vec<Better>,
    floors: &'a [f64],
    colours: &'static str,
    cases: Vec<CaseData<'a>>,
    marks: &'a [Mark],
}

/// Numbers of one result, or the difference of two.
#[derive(Debug, Serialize)]
struct CaseData<'a> {
    name: String,
    is_difference: bool,
    axes: &'a [Vec<f64>],
    names: &'a [String],
    series: Vec<Vec<Option<Packed>>>,
    notes: &'a [String],
    flags: &'a [Vec<(usize, usize)>],
}

/// Returns what a page shows of a view of several results: the view itself, statistics, and how often each result is better.
pub(super) fn compare_view(aligned: &Aligned, folders: &[ResultFolder], colours: &'static str) -> Compared {
    let mut notes = aligned.remarks.clone();
    notes.extend(aligned.node_remark());
    Compared {
        view: explorer_view(aligned, folders, colours),
        over: aligned.extremes_basis().1,
        nouns: format!("{}s", aligned.node_noun()),
        table: statistic_rows(aligned),
        wins: wins_rows(aligned),
        notes,
    }
}

/// Returns the interactive view of all results and of the difference of each other result from the first.
fn explorer_view(aligned: &Aligned, folders: &[ResultFolder], colours: &'static str) -> ExplorerView {
    let Aligned { shared: explorer, letters, data, common, .. } = aligned;
    let precision = Precision::for_numbers(2 * data.iter().map(Dataset::number_count).sum::<usize>());
    let pack = |values: &[Vec<Vec<f64>>]| -> Vec<Vec<Option<Packed>>> {
        values.iter().map(|groups| groups.iter().map(|v| Packed::new(v, precision)).collect()).collect()
    };
    let mut cases: Vec<CaseData<'_>> = Vec::new();
    for ((dataset, letter), folder) in data.iter().zip(letters).zip(folders) {
        cases.push(CaseData {
            name: format!("{letter}: {}", folder.description.name),
            is_difference: false,
            axes: &dataset.axes,
            names: &dataset.names,
            series: pack(&dataset.values),
            notes: &dataset.notes,
            flags: &dataset.flags,
        });
    }
    if aligned.node_count() > 1 {
        for (other, letter) in letters.iter().enumerate().skip(1) {
            let part = &common[0];
            cases.push(CaseData {
                name: format!("{letter} \u{2212} {}", letters[0]),
                is_difference: true,
                axes: &part.axes,
                names: &part.names,
                series: pack(&differences(aligned, other)),
                notes: &[],
                flags: &[],
            });
        }
    }
    let json = script_json(&ComparedData {
        shape: explorer.shape,
        title: &explorer.title,
        coordinates: &explorer.coordinates,
        group_label: explorer.group.as_ref().map_or("", |group| &group.label),
        groups: group_labels(explorer),
        labels: explorer.quantities.iter().map(|q| q.label.clone()).collect(),
        units: explorer.quantities.iter().map(|q| q.unit.as_str()).collect(),
        better: explorer.quantities.iter().map(|q| q.better).collect(),
        floors: &aligned.floors,
        colours,
        cases,
        marks: &explorer.marks,
    });
    ExplorerView {
        id: String::new(),
        title: explorer.title.clone(),
        shape: explorer.shape,
        note: precision_note(explorer, &data[0], precision),
        json,
    }
}

/// Returns the values of the result `other` minus those of the first, by quantity, group and common node; NaN at flagged nodes.
fn differences(aligned: &Aligned, other: usize) -> Vec<Vec<Vec<f64>>> {
    let of_quantity = |quantity: usize| {
        let of_group = |group: usize| {
            let [a, b] = [0, other].map(|i| aligned.common[i].values[quantity][group].as_slice());
            let is_valid = aligned.is_valid_in_both(group, other);
            let difference = |(node, (a, b)): (usize, (&f64, &f64))| if is_valid(node) { b - a } else { f64::NAN };
            a.iter().zip(b).enumerate().map(difference).collect()
        };
        (0..aligned.group_count()).map(of_group).collect()
    };
    (0..aligned.shared.quantities.len()).map(of_quantity).collect()
}

/// One row of the table: a statistic of a quantity in each result.
#[derive(Debug, Serialize)]
struct StatisticRow {
    quantity: String,
    group: String,
    statistic: &'static str,
    values: Vec<String>,
    sort: Vec<String>,
    /// Each other result compared with the first, in words and as a ratio.
    against: Vec<String>,
    ratios: Vec<String>,
    better: String,
}

/// One row of the table of wins: how often the first result or another is better.
#[derive(Debug, Serialize)]
struct WinsRow {
    quantity: String,
    group: String,
    other: char,
    wins: Wins,
}

/// Shares of the `nodes`, on maps by the volume of their cells, at which the first or the second of two results is better, among those where both
/// have a valid number.
#[derive(Debug, Serialize)]
struct Wins {
    nodes: usize,
    /// Share of these nodes at which the first result is better, the second, and neither, as text in percent.
    first: String,
    second: String,
    neither: String,
    shares: [f64; 3],
    /// Where the first result has its largest advantage, and how large; a dash if it is nowhere better.
    first_most: String,
    second_most: String,
}

/// Returns largest, mean and smallest value of every quantity whose small or large values are better.
fn statistic_rows(aligned: &Aligned) -> Vec<StatisticRow> {
    let mut rows = Vec::new();
    let quantities = aligned.shared.quantities.iter().enumerate();
    for (q, quantity) in quantities.filter(|(_, q)| q.better != Better::Neither) {
        let floor = aligned.floors[q];
        for group in 0..aligned.group_count() {
            let Some(all) = aligned.extremes(q, group) else { continue };
            type Statistic = (&'static str, fn(&Extremes) -> f64);
            let statistics: [Statistic; 3] =
                [("largest", |e| e.largest.0), ("mean", |e| e.mean), ("smallest", |e| e.smallest.0)];
            for (statistic, value_of) in statistics {
                let values: Vec<f64> = all.iter().map(value_of).collect();
                rows.push(StatisticRow {
                    quantity: label_with_unit(&quantity.label, &quantity.unit),
                    group: aligned.group_name(group).to_string(),
                    statistic,
                    against: values[1..].iter().map(|v| difference_text(*v, values[0], floor)).collect(),
                    ratios: values[1..].iter().map(|v| format_ratio(*v, values[0], floor)).collect(),
                    better: best_letters(&values, quantity.better, floor, &aligned.letters),
                    sort: values.iter().map(f64::to_string).collect(),
                    values: values.iter().map(|v| format_number(*v)).collect(),
                });
            }
        }
    }
    rows
}

/// Formats `value / first`, as 1 for values equal but for rounding; a dash if it is not finite.
fn format_ratio(value: f64, first: f64, floor: f64) -> String {
    let ratio = if is_same(value, first, floor) { 1.0 } else { value / first };
    if ratio.is_finite() { format!("{ratio:.4}") } else { "–".into() }
}

/// Returns the letters of the results whose value is the best one, but for rounding up to `floor` in its unit; "same" if all are, a dash if
/// none is a number.
fn best_letters(values: &[f64], better: Better, floor: f64, letters: &[char]) -> String {
    let cost = |value: f64| better.sign() * value;
    let numbers = values.iter().copied().filter(|value| !value.is_nan());
    let Some(best) = numbers.min_by(|a, b| cost(*a).total_cmp(&cost(*b))) else { return "–".into() };
    let is_tied = |index: &usize| values[*index] == best || is_same(values[*index], best, floor);
    let tied: Vec<String> = (0..values.len()).filter(is_tied).map(|index| letters[index].to_string()).collect();
    if tied.len() == values.len() { "same".into() } else { tied.join(", ") }
}

/// Returns the comparison of the first result with each other one, node by node, for every quantity and group.
fn wins_rows(aligned: &Aligned) -> Vec<WinsRow> {
    let mut rows = Vec::new();
    for (q, quantity) in aligned.shared.quantities.iter().enumerate() {
        for group in 0..aligned.group_count() {
            for (other, letter) in aligned.letters.iter().enumerate().skip(1) {
                rows.extend(Wins::new(aligned, q, group, other).map(|wins| WinsRow {
                    quantity: label_with_unit(&quantity.label, &quantity.unit),
                    group: aligned.group_name(group).to_string(),
                    other: *letter,
                    wins,
                }));
            }
        }
    }
    rows
}

impl Wins {
    /// Compares the first result with `other`; `None` if no node can be compared or neither small nor large values are better.
    fn new(aligned: &Aligned, q: usize, group: usize, other: usize) -> Option<Self> {
        let pair = [&aligned.common[0], &aligned.common[other]];
        let Quantity { unit, better, .. } = &aligned.shared.quantities[q];
        let winners = Winners::new(&pair, q, group, *better, aligned.floors[q])?.weighted(aligned.weights(pair[0]));
        let nodes = Some(winners.compared_count()).filter(|nodes| *nodes > 0)?;
        let shares = [winners.win_share(0), winners.win_share(1), winners.same_share()];
        let most = |who: usize| {
            let gap = |node: usize| (pair[1].values[q][group][node] - pair[0].values[q][group][node]).abs();
            let ahead = winners.leads(who).map(|(node, _)| (gap(node), node));
            match ahead.fold((0.0, 0), |most, next| if next.0 > most.0 { next } else { most }) {
                (0.0, _) => "–".to_string(),
                (gap, node) => {
                    format!("{} at {}", with_unit(&format_number(gap), unit), pair[0].node_label(&aligned.shared, node))
                }
            }
        };
        Some(Self {
            nodes,
            first: percent(shares[0]),
            second: percent(shares[1]),
            neither: percent(shares[2]),
            shares: shares.map(|share| 100.0 * share),
            first_most: most(0),
            second_most: most(1),
        })
    }
}
