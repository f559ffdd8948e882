//! The numbers of several results in a table: largest, mean and smallest of each quantity, and which is better where.

use serde::Serialize;

use super::{
    aligned::{Aligned, in_unit},
    description::Better,
    floors::{Floors, against, same},
    table::number,
    wins::{Extremes, Wins},
};

/// One statistic of a quantity.
#[derive(Debug, Serialize)]
pub(super) struct SideBySide {
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
pub(super) struct WinsRow {
    quantity: String,
    group: String,
    other: char,
    wins: Wins,
}

/// Every quantity of which one value is the better one.
pub(super) fn side_by_side(aligned: &Aligned, floors: &Floors, letters: &[char]) -> Vec<SideBySide> {
    let mut rows = Vec::new();
    let quantities = aligned.shared.quantities.iter().enumerate();
    for (q, quantity) in quantities.filter(|(_, q)| q.better != Better::Neither) {
        let floor = floors.of(&quantity.unit);
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
                    better: best(&values, quantity.better, floor, letters),
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
pub(super) fn wins(aligned: &Aligned, floors: &Floors, letters: &[char]) -> Vec<WinsRow> {
    let common = &aligned.common;
    let mut rows = Vec::new();
    for (q, quantity) in aligned.shared.quantities.iter().enumerate() {
        for group in 0..aligned.groups() {
            for (other, letter) in letters.iter().enumerate().skip(1) {
                let [a, b] = [0, other].map(|i| common.parts[i].values[q][group].as_slice());
                let counts = common.counts(group, other);
                let floor = floors.of(&quantity.unit);
                let found = Wins::new(&aligned.shared, quantity, floor, &common.parts[0], [a, b], counts);
                rows.extend(found.map(|wins| WinsRow {
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
