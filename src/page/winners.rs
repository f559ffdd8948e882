//! Which of several results is best at each node, and by how much; differences as small as rounding give no winner.

use std::cmp::Ordering;

use super::{
    aligned::Aligned,
    dataset::Dataset,
    description::{Better, Explorer},
    table::format_number,
};
use crate::files::words::{typographic, with_unit};

/// Share of the largest number in a unit below which a number of that unit counts as rounding.
const RESOLVED: f64 = 1e-7;

/// The largest absolute value of all compared numbers, by unit: it decides what counts as rounding.
#[derive(Debug, Default)]
pub(super) struct Floors(Vec<(String, f64)>);

impl Floors {
    /// Finds the largest numbers in all `views`, and sets in each view the sizes below which numbers are rounding.
    pub fn of(views: &mut [Aligned]) -> Self {
        let mut floors = Self::default();
        views.iter().for_each(|view| floors.add_sizes(&view.shared, &view.data));
        for view in views {
            view.floors = view.shared.quantities.iter().map(|quantity| floors.floor(&quantity.unit)).collect();
        }
        floors
    }

    /// Raises the largest numbers by those of all results in one view.
    fn add_sizes(&mut self, explorer: &Explorer, data: &[Dataset]) {
        for (q, quantity) in explorer.quantities.iter().enumerate() {
            let sizes = data.iter().flat_map(|dataset| dataset.values[q].iter().flatten()).map(|value| value.abs());
            let most = sizes.filter(|size| size.is_finite()).fold(0.0, f64::max);
            match self.0.iter_mut().find(|(unit, _)| *unit == quantity.unit) {
                Some((_, known)) => *known = known.max(most),
                None => self.0.push((quantity.unit.clone(), most)),
            }
        }
    }

    /// Returns the size below which a number in `unit` counts as rounding.
    fn floor(&self, unit: &str) -> f64 {
        self.0.iter().find(|(known, _)| known == unit).map_or(0.0, |(_, most)| RESOLVED * most)
    }

    /// Returns a sentence that explains the rule to readers.
    pub fn rule_sentence(&self) -> String {
        let named = self.0.iter().filter(|(unit, most)| !unit.is_empty() && *most > 0.0);
        let floors: Vec<String> = named.map(|(unit, most)| with_unit(&format_floor(RESOLVED * most), unit)).collect();
        let rule = "A difference below a ten-millionth of the largest number compared in the same unit counts as \
                    rounding: the difference has no winner and sets no axis";
        if floors.is_empty() { format!("{rule}.") } else { format!("{rule} (here {}).", floors.join(", ")) }
    }
}

/// Returns whether two numbers are equal but for rounding, which `floor` bounds in their unit.
pub(super) fn is_same(a: f64, b: f64, floor: f64) -> bool {
    (a - b).abs() <= floor.max(1e-9 * a.abs().max(b.abs()))
}

/// Returns `value` compared with `reference` in words: "24 % less", "3.2 times as much" or "the same".
pub fn difference_text(value: f64, reference: f64, floor: f64) -> String {
    let (size, other) = (value.abs(), reference.abs());
    match size / other {
        _ if is_same(value, reference, floor) => "the same".into(),
        _ if other <= floor || value * reference < 0.0 => "–".into(),
        _ if size <= floor => "nothing left".into(),
        ratio if ratio < 0.1 => format!("1/{} of it", format_ratio(1.0 / ratio)),
        ratio if ratio < 1.0 => format!("{} less", percent(1.0 - ratio)),
        ratio if ratio < 2.0 => format!("{} more", percent(ratio - 1.0)),
        ratio => format!("{} times as much", format_ratio(ratio)),
    }
}

/// Returns the size below which numbers are rounding, as text.
pub(super) fn format_floor(floor: f64) -> String {
    typographic(&format!("{floor:.0e}"))
}

/// Formats a ratio above 1 with few digits.
fn format_ratio(ratio: f64) -> String {
    if ratio < 10.0 {
        format!("{ratio:.1}")
    } else if ratio < 1e4 {
        format!("{ratio:.0}")
    } else {
        format_number(ratio.round())
    }
}

/// Returns a share in percent: "24 %", "0.3 %", never "100 %" for less than all.
pub fn percent(share: f64) -> String {
    let percent = 100.0 * share;
    match percent {
        p if p == 0.0 || p == 100.0 => format!("{p:.0} %"),
        p if p < 0.1 => "less than 0.1 %".into(),
        p if p < 1.0 => format!("{p:.1} %"),
        p if (99.5..100.0).contains(&p) => format!("{:.1} %", p.min(99.9)),
        p => format!("{p:.0} %"),
    }
}

/// Smallest and largest value of one result with their nodes, and its mean value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Extremes {
    pub smallest: (f64, usize),
    pub mean: f64,
    pub largest: (f64, usize),
}

impl Extremes {
    /// Returns the extremes over the nodes for which `counts` is true; `None` if there is no number.
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

    /// Returns the worst and the best value, each with its node.
    pub fn worst_and_best(&self, better: Better) -> [(f64, usize); 2] {
        match better {
            Better::Larger => [self.smallest, self.largest],
            _ => [self.largest, self.smallest],
        }
    }
}

/// Which result is best at one node.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum NodeWinner {
    /// Not all results have a valid number there.
    Nothing,
    /// The best and the next best are equal but for rounding.
    Same,
    /// One result is better than all others.
    Best {
        /// Which.
        who: usize,
        /// By which share of the next best.
        lead: f64,
    },
}

/// The best result at each node.
#[derive(Debug, Clone, PartialEq)]
pub struct Winners {
    /// The winner at each common node.
    pub at: Vec<NodeWinner>,
    results: usize,
    /// What each node stands for in shares.
    weights: Vec<f64>,
}

impl Winners {
    /// Finds the best of `parts`, which have the same nodes, for a quantity and group; `None` if neither value is better by nature.
    pub fn new(parts: &[&Dataset], quantity: usize, group: usize, better: Better, floor: f64) -> Option<Self> {
        if better == Better::Neither {
            return None;
        }
        let sign = better.sign();
        // A name that is there twice in one result is so in others at most.
        let count = parts.iter().map(|part| part.node_count()).min()?;
        let mut is_valid = vec![true; count];
        for (node, _) in parts.iter().flat_map(|part| &part.flags[group]) {
            if let Some(is_valid) = is_valid.get_mut(*node) {
                *is_valid = false;
            }
        }
        let at = |node: usize| {
            let value = |who: usize| parts[who].values[quantity][group][node];
            if !is_valid[node] || (0..parts.len()).any(|who| !value(who).is_finite()) {
                return NodeWinner::Nothing;
            }
            let best_of = |all: &mut dyn Iterator<Item = usize>| {
                all.min_by(|a, b| (sign * value(*a)).partial_cmp(&(sign * value(*b))).unwrap_or(Ordering::Equal))
            };
            let who = best_of(&mut (0..parts.len()));
            match who.zip(best_of(&mut (0..parts.len()).filter(|other| Some(*other) != who))) {
                None => NodeWinner::Nothing,
                Some((who, next)) if is_same(value(who), value(next), floor) => NodeWinner::Same,
                Some((who, next)) => {
                    NodeWinner::Best { who, lead: (value(next) - value(who)).abs() / value(next).abs().max(floor) }
                }
            }
        };
        Some(Self { at: (0..count).map(at).collect(), results: parts.len(), weights: vec![1.0; count] })
    }

    /// Sets what each node stands for in shares, such as the volume of its cell.
    #[must_use]
    pub fn weighted(self, weights: Vec<f64>) -> Self {
        Self { weights, ..self }
    }

    /// Returns the share of the compared nodes, each as its weight says, whose winner `counts`.
    fn share(&self, counts: impl Fn(&NodeWinner) -> bool) -> f64 {
        let sum = |counts: &dyn Fn(&NodeWinner) -> bool| -> f64 {
            self.at.iter().zip(&self.weights).filter(|(at, _)| counts(at)).map(|(_, weight)| weight).sum()
        };
        let compared = |at: &NodeWinner| *at != NodeWinner::Nothing;
        // Sums in the same order: all of them are exactly the whole.
        let (own, all) = (sum(&counts), sum(&compared));
        if own == all && all > 0.0 { 1.0 } else { own / all.max(f64::MIN_POSITIVE) }
    }

    /// Returns the number of nodes at which all results are valid.
    pub fn compared_count(&self) -> usize {
        self.at.iter().filter(|at| **at != NodeWinner::Nothing).count()
    }

    /// Returns the share of the compared nodes at which the result `who` is best.
    pub fn win_share(&self, who: usize) -> f64 {
        self.share(|at| matches!(at, NodeWinner::Best { who: own, .. } if *own == who))
    }

    /// Returns the share of the compared nodes at which the best two results are equal.
    pub fn same_share(&self) -> f64 {
        self.share(|at| *at == NodeWinner::Same)
    }

    /// Returns the indices of the results, the one that is best in the largest share first; ties in their order.
    pub fn order_by_wins(&self) -> Vec<usize> {
        let mut order: Vec<usize> = (0..self.results).collect();
        order.sort_by(|a, b| self.win_share(*b).total_cmp(&self.win_share(*a)));
        order
    }

    /// Returns the median lead of the result `who` over the nodes where it is best; `None` if it is nowhere.
    pub fn typical_lead(&self, who: usize) -> Option<f64> {
        let mut leads: Vec<f64> = self.leads(who).map(|(_, lead)| lead).collect();
        leads.sort_by(f64::total_cmp);
        leads.get(leads.len() / 2).copied()
    }

    /// Returns the node at which the result `who` has its largest lead; `None` if it is nowhere best.
    pub fn largest_lead_node(&self, who: usize) -> Option<usize> {
        self.leads(who).max_by(|a, b| a.1.total_cmp(&b.1)).map(|(node, _)| node)
    }

    /// Yields the nodes at which the result `who` is best, with its lead as a share of the next best value.
    pub fn leads(&self, who: usize) -> impl Iterator<Item = (usize, f64)> {
        self.at.iter().enumerate().filter_map(move |(node, at)| match at {
            NodeWinner::Best { who: own, lead } if *own == who => Some((node, *lead)),
            _ => None,
        })
    }
}
