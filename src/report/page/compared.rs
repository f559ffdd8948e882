//! One view of several results: their numbers side by side, their differences, and which is better where.

use std::collections::HashSet;

use serde::Serialize;

use super::{
    common::Common,
    dataset::{Dataset, MOST_NUMBERS},
    description::{Better, Column, Explorer, Mark, Quantity, Shape},
    folder::ResultFolder,
    packed::{Packed, Precision, script_json},
    single::{ExplorerView, group_labels, note},
    table::number,
    wins::{Extremes, Wins},
};
use crate::{input::error::Result, report::words::counted};

/// A view that all results have.
#[derive(Debug, Serialize)]
pub(super) struct Compared {
    view: ExplorerView,
    /// What the statistics of the table are taken over.
    over: String,
    table: Vec<SideBySide>,
    wins: Vec<WinsRow>,
    notes: Vec<String>,
}

#[derive(Debug, Serialize)]
struct SideBySide {
    quantity: String,
    group: String,
    statistic: &'static str,
    values: Vec<String>,
    sort: Vec<String>,
    ratios: Vec<String>,
    better: String,
}

#[derive(Debug, Serialize)]
struct WinsRow {
    quantity: String,
    group: String,
    other: char,
    wins: Wins,
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

/// `explorer` of the first folder with what the others have of it; `None` if one has no such view.
pub(super) fn compared(
    explorer: &Explorer,
    folders: &[ResultFolder],
    letters: &[char],
    notes: &mut Vec<String>,
    sentences: &mut Vec<String>,
) -> Result<Option<Compared>> {
    let mut own: Vec<&Explorer> = Vec::new();
    for (folder, letter) in folders.iter().zip(letters) {
        match folder.description.explorers.iter().find(|e| e.title == explorer.title && e.shape == explorer.shape) {
            Some(same) if same.coordinates == explorer.coordinates => own.push(same),
            _ => {
                notes.push(format!("{letter} has no view \"{}\" over the same coordinates.", explorer.title));
                return Ok(None);
            }
        }
    }
    let mut remarks = Vec::new();
    let shared = shared_part(explorer, &own, letters, &mut remarks);
    let mut data = Vec::new();
    for (folder, own) in folders.iter().zip(&own) {
        let table = folder.table(&own.table)?;
        data.push(Dataset::read(&reordered(own, &shared), &table, MOST_NUMBERS / 2 / folders.len())?);
    }
    let common = Common::new(&data);
    let remark = common.remark(&data, shared.shape);
    let (extremes_of, over) = common.extremes_of(&data, shared.shape);
    let table = table(&shared, extremes_of, letters);
    let wins = wins(&shared, &common, letters);
    let sentence = sentence(&shared, extremes_of, &over, &common, letters);
    sentences.extend(sentence.or_else(|| Some(format!("{}: {}", shared.title, remark.as_ref()?))));
    remarks.extend(remark);
    let view = view(&shared, folders, letters, &data, &common);
    Ok(Some(Compared { view, over, table, wins, notes: remarks }))
}

/// The quantities and groups of `explorer` that all of `own` have in the same unit.
fn shared_part(explorer: &Explorer, own: &[&Explorer], letters: &[char], remarks: &mut Vec<String>) -> Explorer {
    let mut shared = explorer.clone();
    shared.quantities.retain(|quantity| {
        let missing = own.iter().position(|e| !e.quantities.iter().any(|q| same(q, quantity)));
        if let Some(missing) = missing {
            let with_unit = in_unit(&quantity.label, &quantity.unit);
            remarks.push(format!("{} does not have {with_unit}; it is not compared.", letters[missing]));
        }
        missing.is_none()
    });
    if let Some(group) = &mut shared.group {
        group.values.retain(|value| {
            let has = |e: &&Explorer| e.group.as_ref().is_some_and(|g| g.values.contains(value));
            let missing = own.iter().position(|e| !has(e));
            if let Some(missing) = missing {
                remarks.push(format!("{} does not have \"{}\"; it is not compared.", letters[missing], value.label));
            }
            missing.is_none()
        });
    }
    shared
}

fn same(a: &Quantity, b: &Quantity) -> bool {
    a.label == b.label && a.unit == b.unit
}

fn in_unit(label: &str, unit: &str) -> String {
    if unit.is_empty() { label.into() } else { format!("{label} [{unit}]") }
}

/// `own` with the quantities and groups of `shared`, in its order.
fn reordered(own: &Explorer, shared: &Explorer) -> Explorer {
    let quantities = shared.quantities.iter().filter_map(|q| own.quantities.iter().find(|other| same(q, other)));
    Explorer { quantities: quantities.cloned().collect(), group: shared.group.clone(), ..own.clone() }
}

/// Smallest, mean and largest value of one result at the nodes of `data`; flagged nodes, whose numbers are bounds, do not count.
fn extremes(data: &Dataset, quantity: usize, group: usize) -> Option<Extremes> {
    let bad: HashSet<usize> = data.flags[group].iter().map(|flag| flag.0).collect();
    Extremes::new(&data.values[quantity][group], |node| !bad.contains(&node))
}

fn group_name(explorer: &Explorer, group: usize) -> String {
    group_labels(explorer).get(group).map_or_else(String::new, ToString::to_string)
}

fn groups(explorer: &Explorer) -> usize {
    explorer.group.as_ref().map_or(1, |group| group.values.len())
}

fn table(explorer: &Explorer, data: &[Dataset], letters: &[char]) -> Vec<SideBySide> {
    let mut rows = Vec::new();
    for (q, quantity) in explorer.quantities.iter().enumerate().filter(|(_, q)| q.better != Better::Neither) {
        for group in 0..groups(explorer) {
            let all: Option<Vec<Extremes>> = data.iter().map(|own| extremes(own, q, group)).collect();
            let Some(all) = all else { continue };
            for (k, statistic) in ["largest", "mean", "smallest"].into_iter().enumerate() {
                let values: Vec<f64> = all.iter().map(|e| [e.largest.0, e.mean, e.smallest.0][k]).collect();
                rows.push(SideBySide {
                    quantity: in_unit(&quantity.label, &quantity.unit),
                    group: group_name(explorer, group),
                    statistic,
                    ratios: values[1..].iter().map(|v| ratio(*v, values[0])).collect(),
                    better: best(&values, quantity.better, letters),
                    sort: values.iter().map(f64::to_string).collect(),
                    values: values.into_iter().map(number).collect(),
                });
            }
        }
    }
    rows
}

fn ratio(value: f64, first: f64) -> String {
    let ratio = value / first;
    if ratio.is_finite() { format!("{ratio:.4}") } else { "–".into() }
}

/// Letter of the best value, or that they are the same.
fn best(values: &[f64], better: Better, letters: &[char]) -> String {
    let cost = |value: f64| if better == Better::Larger { -value } else { value };
    let winner = (0..values.len()).min_by(|a, b| cost(values[*a]).total_cmp(&cost(values[*b]))).unwrap_or(0);
    let close = |v: f64| (v - values[winner]).abs() <= 1e-9 * v.abs().max(values[winner].abs());
    if values.iter().all(|v| close(*v)) { "same".into() } else { letters[winner].to_string() }
}

fn wins(explorer: &Explorer, common: &Common, letters: &[char]) -> Vec<WinsRow> {
    let mut rows = Vec::new();
    for (q, quantity) in explorer.quantities.iter().enumerate() {
        for group in 0..groups(explorer) {
            for (other, letter) in letters.iter().enumerate().skip(1) {
                let [a, b] = [0, other].map(|i| common.parts[i].values[q][group].as_slice());
                let counts = common.counts(group, other);
                let found = Wins::new(explorer, &quantity.unit, quantity.better, &common.parts[0], [a, b], counts);
                rows.extend(found.map(|wins| WinsRow {
                    quantity: in_unit(&quantity.label, &quantity.unit),
                    group: group_name(explorer, group),
                    other: *letter,
                    wins,
                }));
            }
        }
    }
    rows
}

/// The first quantity and group in words.
fn sentence(explorer: &Explorer, data: &[Dataset], over: &str, common: &Common, letters: &[char]) -> Option<String> {
    let quantity = explorer.quantities.iter().position(|q| q.better != Better::Neither)?;
    let q = &explorer.quantities[quantity];
    let all: Vec<Extremes> = data.iter().map(|own| extremes(own, quantity, 0)).collect::<Option<_>>()?;
    let of = group_labels(explorer).first().map_or_else(String::new, |label| format!(" ({label})"));
    let worst = |e: &Extremes| if q.better == Better::Larger { e.smallest } else { e.largest };
    let said = all.iter().zip(data).zip(letters).map(|((e, own), letter)| {
        let (value, node) = worst(e);
        format!("{} {} in {letter}, at {}", number(value), q.unit, own.place(explorer, node))
    });
    let which = if q.better == Better::Larger { "at least" } else { "at most" };
    let mut text =
        format!("{}, {over}: {}{of} is {which} {}", explorer.title, q.label, said.collect::<Vec<_>>().join("; "));
    for (other, letter) in letters.iter().enumerate().skip(1) {
        let ratio = ratio(worst(&all[other]).0, worst(&all[0]).0);
        text += &format!("; {letter} over {} {ratio}", letters[0]);
    }
    text += ".";
    for (other, letter) in letters.iter().enumerate().skip(1) {
        let [a, b] = [0, other].map(|i| common.parts[i].values[quantity][0].as_slice());
        let found = Wins::new(explorer, &q.unit, q.better, &common.parts[0], [a, b], common.counts(0, other));
        if let Some(wins) = found {
            text += &format!(
                " Of {}, {} is better at {}, {letter} at {}; {} are the same.",
                counted(wins.nodes, "node"),
                letters[0],
                wins.first,
                wins.second,
                wins.neither
            );
        }
    }
    Some(text)
}

fn view(
    explorer: &Explorer,
    folders: &[ResultFolder],
    letters: &[char],
    data: &[Dataset],
    common: &Common,
) -> ExplorerView {
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
    if common.count() > 1 {
        for (other, letter) in letters.iter().enumerate().skip(1) {
            let part = &common.parts[0];
            let difference: Vec<Vec<Vec<f64>>> = part
                .values
                .iter()
                .zip(&common.parts[other].values)
                .map(|(a, b)| {
                    let both = a.iter().zip(b).enumerate();
                    both.map(|(group, (a, b))| {
                        let counts = common.counts(group, other);
                        let of = |(node, (a, b)): (usize, (&f64, &f64))| if counts(node) { b - a } else { f64::NAN };
                        a.iter().zip(b).enumerate().map(of).collect()
                    })
                    .collect()
                })
                .collect();
            cases.push(CaseData {
                name: format!("{letter} \u{2212} {}", letters[0]),
                is_difference: true,
                axes: &part.axes,
                names: &part.names,
                series: pack(&difference),
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
