//! Two results of one quantity: which is better, where and by how much.

use serde::Serialize;

use super::{
    dataset::Dataset,
    description::{Better, Explorer, Quantity},
    floors::{percent, same},
    table::number,
};
use crate::files::words::with_unit;

/// Smallest, mean and largest value of one result.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Extremes {
    pub smallest: (f64, usize),
    pub mean: f64,
    pub largest: (f64, usize),
}

impl Extremes {
    /// Over the nodes that `counts`; `None` if there is no number.
    pub fn new(values: &[f64], counts: impl Fn(usize) -> bool) -> Option<Self> {
        let mut known = values.iter().copied().enumerate().filter(|(node, v)| v.is_finite() && counts(*node));
        let (node, value) = known.next()?;
        let mut all = Self { smallest: (value, node), mean: 0.0, largest: (value, node) };
        let (mut sum, mut number) = (value, 1.0);
        for (node, value) in known {
            sum += value;
            number += 1.0;
            if value < all.smallest.0 {
                all.smallest = (value, node);
            }
            if value > all.largest.0 {
                all.largest = (value, node);
            }
        }
        all.mean = sum / number;
        Some(all)
    }
}

/// Who is better where, of two results over the same nodes.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Wins {
    /// Nodes at which both have a number.
    pub nodes: usize,
    /// Share of them at which the first is better, the second, and neither, percent.
    pub first: String,
    pub second: String,
    pub neither: String,
    /// The same as numbers, percent.
    pub shares: [f64; 3],
    /// Where the first is ahead most, and by how much; a dash if nowhere.
    pub first_most: String,
    pub second_most: String,
}

impl Wins {
    /// `None` if nothing can be compared, or neither is better by its nature. Differences up to `floor` are rounding.
    pub fn new(
        explorer: &Explorer,
        quantity: &Quantity,
        floor: f64,
        dataset: &Dataset,
        [first, second]: [&[f64]; 2],
        counts: impl Fn(usize) -> bool,
    ) -> Option<Self> {
        let sign = match quantity.better {
            Better::Smaller => 1.0,
            Better::Larger => -1.0,
            Better::Neither => return None,
        };
        let (mut nodes, mut wins, mut most) = (0usize, [0usize; 2], [(0.0f64, 0usize); 2]);
        for (node, (a, b)) in first.iter().zip(second).enumerate() {
            if !(a.is_finite() && b.is_finite() && counts(node)) {
                continue;
            }
            nodes += 1;
            let ahead = sign * (b - a);
            if same(*a, *b, floor) {
                continue;
            }
            let winner = usize::from(ahead < 0.0);
            wins[winner] += 1;
            if ahead.abs() > most[winner].0 {
                most[winner] = (ahead.abs(), node);
            }
        }
        if nodes == 0 {
            return None;
        }
        let unit = &quantity.unit;
        let share = |count: usize| percent(count as f64 / nodes as f64);
        let place = |(by, node): (f64, usize)| match by {
            0.0 => "–".to_string(),
            by => format!("{} at {}", with_unit(&number(by), unit), dataset.place(explorer, node)),
        };
        Some(Self {
            nodes,
            first: share(wins[0]),
            second: share(wins[1]),
            neither: share(nodes - wins[0] - wins[1]),
            shares: [wins[0], wins[1], nodes - wins[0] - wins[1]].map(|count| 100.0 * count as f64 / nodes as f64),
            first_most: place(most[0]),
            second_most: place(most[1]),
        })
    }
}
