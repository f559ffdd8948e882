//! One view of several results: their numbers side by side, their differences, and which is better where.

use serde::Serialize;

use super::{
    aligned::{Aligned, in_unit},
    dataset::Dataset,
    description::{Better, Column, Mark, Quantity, Shape},
    folder::ResultFolder,
    packed::{Packed, Precision, script_json},
    single::{ExplorerView, group_labels, note},
    table::number,
    winners::{Extremes, Winners, against, percent, same},
};
use crate::files::words::with_unit;

/// A view that all results have.
#[derive(Debug, Serialize)]
pub(super) struct Compared {
    view: ExplorerView,
    /// What the statistics of the table are taken over.
    over: String,
    /// What one place of it is called, in the plural.
    nouns: String,
    table: Vec<SideBySide>,
    wins: Vec<WinsRow>,
    notes: Vec<String>,
}

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
    /// What is rounding, by quantity.
    floors: &'a [f64],
    colours: &'static str,
    cases: Vec<CaseData<'a>>,
    marks: &'a [Mark],
}

/// One result, or the difference of two.
#[derive(Debug, Serialize)]
struct CaseData<'a> {
    name: String,
    is_difference: bool,
    axes: &'a [Vec<f64>],
    names: &'a [String],
    /// By quantity and group.
    series: Vec<Vec<Option<Packed>>>,
    notes: &'a [String],
    flags: &'a [Vec<(usize, usize)>],
}

/// What a page shows of `aligned`.
pub(super) fn compared(aligned: &Aligned, folders: &[ResultFolder], colours: &'static str) -> Compared {
    let mut notes = aligned.remarks.clone();
    notes.extend(aligned.remark());
    Compared {
        view: view(aligned, folders, colours),
        over: aligned.extremes_of().1,
        nouns: format!("{}s", aligned.noun()),
        table: side_by_side(aligned),
        wins: wins(aligned),
        notes,
    }
}

fn view(aligned: &Aligned, folders: &[ResultFolder], colours: &'static str) -> ExplorerView {
    let Aligned { shared: explorer, letters, data, parts, .. } = aligned;
    let precision = Precision::for_numbers(2 * data.iter().map(Dataset::number_count).sum::<usize>());
    let pack = |values: &[Vec<Vec<f64>>]| -> Vec<Vec<Option<Packed>>> {
        values.iter().map(|groups| groups.iter().map(|v| Packed::new(v, precision)).collect()).collect()
    };
    let mut cases: Vec<CaseData<'_>> = Vec::new();
    for ((own, letter), folder) in data.iter().zip(letters).zip(folders) {
        cases.push(CaseData {
            name: format!("{letter}: {}", folder.description.name),
            is_difference: false,
            axes: &own.axes,
            names: &own.names,
            series: pack(&own.values),
            notes: &own.notes,
            flags: &own.flags,
        });
    }
    if aligned.count() > 1 {
        for (other, letter) in letters.iter().enumerate().skip(1) {
            let part = &parts[0];
            cases.push(CaseData {
                name: format!("{letter} \u{2212} {}", letters[0]),
                is_difference: true,
                axes: &part.axes,
                names: &part.names,
                series: pack(&difference(aligned, other)),
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
        note: note(explorer, &data[0], precision),
        json,
    }
}

/// The values of the result `other` minus those of the first, by quantity, group and node in common.
fn difference(aligned: &Aligned, other: usize) -> Vec<Vec<Vec<f64>>> {
    let of_quantity = |quantity: usize| {
        let of_group = |group: usize| {
            let [a, b] = [0, other].map(|i| aligned.parts[i].values[quantity][group].as_slice());
            let counts = aligned.counts(group, other);
            let of = |(node, (a, b)): (usize, (&f64, &f64))| if counts(node) { b - a } else { f64::NAN };
            a.iter().zip(b).enumerate().map(of).collect()
        };
        (0..aligned.groups()).map(of_group).collect()
    };
    (0..aligned.shared.quantities.len()).map(of_quantity).collect()
}

/// One statistic of a quantity.
#[derive(Debug, Serialize)]
struct SideBySide {
    quantity: String,
    group: String,
    statistic: &'static str,
    values: Vec<String>,
    sort: Vec<String>,
    /// Each of the others against the first, in words and as a ratio.
    against: Vec<String>,
    ratios: Vec<String>,
    better: String,
}

/// Who is better where, of the first and another.
#[derive(Debug, Serialize)]
struct WinsRow {
    quantity: String,
    group: String,
    other: char,
    wins: Wins,
}

/// Who is better where, of two results over the same nodes.
#[derive(Debug, Serialize)]
struct Wins {
    /// Nodes at which both have a number.
    nodes: usize,
    /// Share of them at which the first is better, the second, and neither, percent.
    first: String,
    second: String,
    neither: String,
    /// The same as numbers, percent.
    shares: [f64; 3],
    /// Where the first is ahead most, and by how much; a dash if nowhere.
    first_most: String,
    second_most: String,
}

/// Every quantity of which one value is the better one.
fn side_by_side(aligned: &Aligned) -> Vec<SideBySide> {
    let mut rows = Vec::new();
    let quantities = aligned.shared.quantities.iter().enumerate();
    for (q, quantity) in quantities.filter(|(_, q)| q.better != Better::Neither) {
        let floor = aligned.floors[q];
        for group in 0..aligned.groups() {
            let Some(all) = aligned.extremes(q, group) else { continue };
            type Statistic = (&'static str, fn(&Extremes) -> f64);
            let statistics: [Statistic; 3] =
                [("largest", |e| e.largest.0), ("mean", |e| e.mean), ("smallest", |e| e.smallest.0)];
            for (statistic, of) in statistics {
                let values: Vec<f64> = all.iter().map(of).collect();
                rows.push(SideBySide {
                    quantity: in_unit(&quantity.label, &quantity.unit),
                    group: aligned.group_name(group).to_string(),
                    statistic,
                    against: values[1..].iter().map(|v| against(*v, values[0], floor)).collect(),
                    ratios: values[1..].iter().map(|v| ratio(*v, values[0], floor)).collect(),
                    better: best(&values, quantity.better, floor, &aligned.letters),
                    sort: values.iter().map(f64::to_string).collect(),
                    values: values.iter().map(|v| number(*v)).collect(),
                });
            }
        }
    }
    rows
}

fn ratio(value: f64, first: f64, floor: f64) -> String {
    let ratio = if same(value, first, floor) { 1.0 } else { value / first };
    if ratio.is_finite() { format!("{ratio:.4}") } else { "–".into() }
}

/// Letter of the best value, or that they are the same.
fn best(values: &[f64], better: Better, floor: f64, letters: &[char]) -> String {
    let cost = |value: f64| if better == Better::Larger { -value } else { value };
    let winner = (0..values.len()).min_by(|a, b| cost(values[*a]).total_cmp(&cost(values[*b]))).unwrap_or(0);
    let same_as_best = |who: &usize| same(values[*who], values[winner], floor);
    let first: Vec<usize> = (0..values.len()).filter(same_as_best).collect();
    match first.len() {
        all if all == values.len() => "same".into(),
        _ => first.iter().map(|who| letters[*who].to_string()).collect::<Vec<_>>().join(", "),
    }
}

/// The first result against each of the others, place by place.
fn wins(aligned: &Aligned) -> Vec<WinsRow> {
    let mut rows = Vec::new();
    for (q, quantity) in aligned.shared.quantities.iter().enumerate() {
        for group in 0..aligned.groups() {
            for (other, letter) in aligned.letters.iter().enumerate().skip(1) {
                rows.extend(Wins::new(aligned, (q, group), other).map(|wins| WinsRow {
                    quantity: in_unit(&quantity.label, &quantity.unit),
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
    /// `None` if nothing can be compared, or neither is better by its nature.
    fn new(aligned: &Aligned, (q, group): (usize, usize), other: usize) -> Option<Self> {
        let pair = [&aligned.parts[0], &aligned.parts[other]];
        let Quantity { unit, better, .. } = &aligned.shared.quantities[q];
        let winners = Winners::new(&pair, q, group, *better, aligned.floors[q])?;
        let nodes = Some(winners.counted()).filter(|nodes| *nodes > 0)?;
        let [first, second] = [0, 1].map(|who| winners.leads(who).count());
        let counts = [first, second, nodes - first - second];
        let share = |count: usize| percent(count as f64 / nodes as f64);
        let most = |who: usize| {
            let by = |node: usize| (pair[1].values[q][group][node] - pair[0].values[q][group][node]).abs();
            let ahead = winners.leads(who).map(|(node, _)| (by(node), node));
            match ahead.fold((0.0, 0), |most, next| if next.0 > most.0 { next } else { most }) {
                (0.0, _) => "–".to_string(),
                (by, node) => format!("{} at {}", with_unit(&number(by), unit), pair[0].place(&aligned.shared, node)),
            }
        };
        Some(Self {
            nodes,
            first: share(first),
            second: share(second),
            neither: share(counts[2]),
            shares: counts.map(|count| 100.0 * count as f64 / nodes as f64),
            first_most: most(0),
            second_most: most(1),
        })
    }
}
