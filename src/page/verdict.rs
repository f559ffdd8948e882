//! The first screen of a comparison: one sentence, at most three numbers, and where the tables have them.

use std::collections::HashSet;

use serde::Serialize;

use super::{
    aligned::Aligned,
    description::{Better, Quantity, Shape},
    headline::{self, State},
    picture::{Picture, bar_picture},
    sentences::{three_digits, without_extreme_word},
    winners::{Extremes, percent},
};

/// Label of the quantity by which placements are judged.
const OBJECTIVE: &str = "objective";

/// First screen of a comparison: sentence, key numbers, further sentences, and checks of the numbers.
#[derive(Debug, Default, Serialize)]
pub(super) struct Verdict {
    pub sentence: String,
    pub numbers: Vec<LargeNumber>,
    pub lines: Vec<String>,
    pub checks: Vec<Check>,
    /// Whether the difference matters, in a few words.
    pub judged: Option<headline::Verdict>,
}

/// A key number in large letters: what it is, and what it is compared with.
#[derive(Debug, Serialize)]
pub(super) struct LargeNumber {
    pub value: String,
    pub unit: String,
    pub what: String,
    pub against: String,
}

/// Writes the first screen of a comparison from one view of all results.
pub(super) struct VerdictWriter<'a> {
    pub aligned: &'a Aligned,
    /// Name of each result; empty if they have no different names.
    pub names: &'a [String],
    /// Difference from which one matters, mm.
    pub tolerance_mm: Option<f64>,
    pub folders: &'a [String],
}

impl VerdictWriter<'_> {
    /// Returns the quantity of the first screen: the first one whose small or large values are better.
    pub fn main_quantity(&self) -> Option<usize> {
        self.aligned.shared.quantities.iter().position(|q| q.better != Better::Neither)
    }

    /// Returns the first screen; `None` if no number can be compared.
    pub fn verdict(&self) -> Option<Verdict> {
        let quantity = self.main_quantity()?;
        let extremes = self.aligned.extremes(quantity, 0)?;
        let winners = self.aligned.winners(quantity)?;
        let (is_curve, has_same_nodes) = (self.aligned.shared.shape == Shape::Curve, self.aligned.has_same_nodes());
        let by_place = winners.compared_count() > 0 && (has_same_nodes || !is_curve);
        let best = if by_place { winners.order_by_wins()[0] } else { self.best_worst_case(quantity, &extremes) };
        let sentence = match by_place {
            true if self.aligned.letters.len() == 2 => self.best_of_two_sentence(quantity, &winners),
            true => self.best_of_several_sentence(quantity, &winners),
            false => self.worst_case_sentence(quantity, best, &extremes),
        };
        let mut verdict = Verdict { sentence, ..Verdict::default() };
        self.add_extremes(quantity, best, &extremes, &mut verdict);
        match self.tolerance_mm.filter(|_| self.unit(quantity) == "mm") {
            Some(tolerance) => self.add_tolerance_share(quantity, best, tolerance, by_place, &mut verdict),
            None if by_place => self.add_difference(quantity, best, &mut verdict),
            None => {}
        }
        if self.tolerance_mm.is_none() {
            verdict.judged = Some(headline::Verdict::new(State::Open, "No tolerance given"));
        }
        Some(verdict)
    }

    /// Returns the result with the best worst value.
    fn best_worst_case(&self, quantity: usize, extremes: &[Extremes]) -> usize {
        let sign = if self.aligned.shared.quantities[quantity].better == Better::Larger { -1.0 } else { 1.0 };
        let cost = |who: &usize| sign * self.worst_and_best(quantity, &extremes[*who])[0].0;
        (0..extremes.len()).min_by(|a, b| cost(a).total_cmp(&cost(b))).unwrap_or(0)
    }

    /// Returns the worst and the best value of a result, each with its node.
    pub(super) fn worst_and_best(&self, quantity: usize, extremes: &Extremes) -> [(f64, usize); 2] {
        match self.aligned.shared.quantities[quantity].better {
            Better::Larger => [extremes.smallest, extremes.largest],
            _ => [extremes.largest, extremes.smallest],
        }
    }

    /// Adds worst and best value of the result `best`, each compared with the same of the other results.
    fn add_extremes(&self, quantity: usize, best: usize, extremes: &[Extremes], verdict: &mut Verdict) {
        let q = &self.aligned.shared.quantities[quantity];
        let (data, _) = self.aligned.extremes_basis();
        let is_larger = q.better == Better::Larger;
        let which = if is_larger { ["smallest", "largest"] } else { ["largest", "smallest"] };
        for (end, which) in which.into_iter().enumerate() {
            let extreme_of = |extremes: &Extremes| self.worst_and_best(quantity, extremes)[end];
            let (value, node) = extreme_of(&extremes[best]);
            let comparison = |who: usize| self.comparison(quantity, value, who, extreme_of(&extremes[who]).0);
            let others: Vec<String> = (0..extremes.len()).filter(|who| *who != best).map(comparison).collect();
            verdict.numbers.push(LargeNumber {
                value: three_digits(value),
                unit: q.unit.clone(),
                what: format!(
                    "{which} {} in {}, {}",
                    without_extreme_word(&q.label),
                    self.aligned.letters[best],
                    self.location(self.node_words(&data[best], node))
                ),
                against: others.join("; "),
            });
            for (who, own_extremes) in extremes.iter().enumerate() {
                let rule = if which == "largest" { Rule::Max } else { Rule::Min };
                verdict.checks.extend(Check::of(self, quantity, who, rule, extreme_of(own_extremes).0));
            }
        }
    }

    /// Adds the share of the result `best` within the tolerance, and a sentence on whether the difference matters.
    fn add_tolerance_share(&self, quantity: usize, best: usize, tolerance: f64, by_place: bool, verdict: &mut Verdict) {
        let (data, _) = self.aligned.extremes_basis();
        let share = |who: usize| {
            let values = data[who].values[quantity][0].iter().filter(|value| value.is_finite());
            values.clone().filter(|value| value.abs() <= tolerance).count() as f64 / values.count().max(1) as f64
        };
        let share_in = |who: usize| format!("in {} {}", self.aligned.letters[who], percent(share(who)));
        let others: Vec<String> = (0..data.len()).filter(|who| *who != best).map(share_in).collect();
        verdict.numbers.push(LargeNumber {
            value: percent(share(best)).trim_end_matches(" %").to_string(),
            unit: "%".into(),
            what: format!("of {} within {tolerance} mm in {}", self.extent_words(), self.aligned.letters[best]),
            against: others.join("; "),
        });
        let differences = self.differences(quantity, best);
        if differences.is_empty() || !by_place {
            return;
        }
        let matters = differences.iter().filter(|(_, by)| *by > tolerance).count();
        let (state, words) = match matters as f64 / differences.len() as f64 {
            0.0 => (State::Open, "No difference beyond the tolerance".into()),
            1.0 => (State::Good, "Difference matters everywhere".into()),
            share => (State::Partly, format!("Difference matters in {} of {}", percent(share), self.extent_words())),
        };
        verdict.judged = Some(headline::Verdict::new(state, words));
        verdict.lines.push(match matters {
            0 => format!(
                "Nowhere do the results differ by more than the tolerance of {tolerance} mm: the difference does not \
                 matter."
            ),
            count => format!(
                "The results differ by more than the tolerance of {tolerance} mm in {} of {}: there the difference matters.",
                percent(count as f64 / differences.len() as f64),
                self.extent_words()
            ),
        });
    }

    /// Adds the largest difference of the result `best` from the others, where no tolerance says whether it matters.
    fn add_difference(&self, quantity: usize, best: usize, verdict: &mut Verdict) {
        let differences = self.differences(quantity, best);
        let Some((node, by)) = differences.into_iter().max_by(|a, b| a.1.total_cmp(&b.1)) else { return };
        let is_length = self.unit(quantity) == "mm";
        let is_nothing = by <= self.floor(quantity);
        let place = || self.location(self.node_words(&self.aligned.common[0], node));
        verdict.numbers.push(LargeNumber {
            value: if is_nothing { "0".into() } else { three_digits(by) },
            unit: self.unit(quantity).into(),
            what: match is_nothing {
                true => "largest difference, but for rounding".into(),
                false => format!("largest difference, {}", place()),
            },
            against: if is_length { "no tolerance is given for the difference".into() } else { String::new() },
        });
    }

    /// Returns the largest difference of `best` from another result, at each node where all results are valid.
    fn differences(&self, quantity: usize, best: usize) -> Vec<(usize, f64)> {
        let parts = &self.aligned.common;
        let value = |who: usize, node: usize| parts[who].values[quantity][0][node];
        let flagged: HashSet<usize> = parts.iter().flat_map(|part| &part.flags[0]).map(|flag| flag.0).collect();
        (0..self.aligned.node_count())
            .filter_map(|node| {
                let gap = (0..parts.len()).map(|who| (value(who, node) - value(best, node)).abs());
                let gap = gap.fold(0.0, |most: f64, gap| if gap.is_nan() { f64::NAN } else { most.max(gap) });
                (gap.is_finite() && !flagged.contains(&node)).then_some((node, gap))
            })
            .collect()
    }
}

/// The first screen of compared placements: what the place found best costs in each.
impl VerdictWriter<'_> {
    /// Returns the first screen for several placements, from their best places; `None` if the view is not one of placements.
    pub fn best_place_verdict(&self) -> Option<Verdict> {
        let shared = &self.aligned.shared;
        let objective = shared.quantities.iter().position(|q| q.label == OBJECTIVE)?;
        let is_cost = |(_, q): &(usize, &Quantity)| q.unit == "mm" && q.better == Better::Smaller;
        let costs: Vec<usize> = shared.quantities.iter().enumerate().filter(is_cost).map(|(index, _)| index).collect();
        let main = *costs.first().filter(|_| shared.shape == Shape::Names)?;
        let chosen: Vec<usize> =
            (0..self.aligned.letters.len()).map(|who| self.best_row(who, objective)).collect::<Option<_>>()?;
        let value = |who: usize, quantity: usize| self.aligned.data[who].values[quantity][0][chosen[who]];
        let mut order: Vec<usize> = (0..self.aligned.letters.len()).collect();
        order.sort_by(|a, b| value(*a, main).total_cmp(&value(*b, main)));
        let best = order[0];
        let against = |quantity: usize| {
            let others = order[1..].iter().filter(|who| value(**who, quantity).is_finite());
            let words = others.map(|who| self.comparison(quantity, value(best, quantity), *who, value(*who, quantity)));
            words.collect::<Vec<_>>().join("; ")
        };
        let q = &shared.quantities[main];
        let mut verdict = Verdict {
            sentence: format!(
                "At its best place {} has a {} of {} {}, {}.",
                self.full_name(best),
                q.label,
                three_digits(value(best, main)),
                q.unit,
                against(main)
            ),
            ..Verdict::default()
        };
        let correction = costs.iter().copied().find(|index| shared.quantities[*index].label.contains("correction"));
        for quantity in [Some(main), correction] {
            let Some(quantity) = quantity.filter(|q| value(best, *q).is_finite()) else { continue };
            let at = self.node_words(&self.aligned.data[best], chosen[best]);
            verdict.numbers.push(LargeNumber {
                value: three_digits(value(best, quantity)),
                unit: shared.quantities[quantity].unit.clone(),
                what: format!(
                    "{} at the best place of {} ({at})",
                    shared.quantities[quantity].label, self.aligned.letters[best]
                ),
                against: against(quantity),
            });
        }
        let within = shared.quantities.iter().position(|q| q.label == "share of the path within tolerance");
        if let Some(within) = within.filter(|within| value(best, *within).is_finite()) {
            let share_in = |who: &usize| format!("in {} {}", self.aligned.letters[*who], percent(value(*who, within)));
            let others: Vec<String> = order[1..].iter().map(share_in).collect();
            verdict.numbers.push(LargeNumber {
                value: percent(value(best, within)).trim_end_matches(" %").to_string(),
                unit: "%".into(),
                what: format!("of the path within the tolerance of its study in {}", self.aligned.letters[best]),
                against: others.join("; "),
            });
        }
        for who in order {
            let objective_value = value(who, objective);
            verdict.checks.extend(Check::of(self, objective, who, Rule::Min, objective_value).map(Check::own_rows));
        }
        Some(verdict)
    }

    /// Draws the main error at the best place of each placement; `None` if the view is not one of placements.
    pub fn best_place_picture(&self) -> Option<Picture> {
        let shared = &self.aligned.shared;
        let objective = shared.quantities.iter().position(|q| q.label == OBJECTIVE)?;
        let main = shared.quantities.iter().position(|q| q.unit == "mm" && q.better == Better::Smaller)?;
        let value = |who: usize| Some(self.aligned.data[who].values[main][0][self.best_row(who, objective)?]);
        let values: Vec<f64> = (0..self.aligned.letters.len()).map(value).collect::<Option<_>>()?;
        let q = &shared.quantities[main];
        bar_picture(format!("{} at the best place of each", q.label), &q.unit, &values, &self.aligned.letters)
    }

    /// Returns the valid row with the smallest objective.
    fn best_row(&self, who: usize, objective: usize) -> Option<usize> {
        let data = &self.aligned.data[who];
        let is_valid = |node: &usize| !data.flags[0].iter().any(|flag| flag.0 == *node);
        let values = &data.values[objective][0];
        let known = (0..values.len()).filter(|node| values[*node].is_finite()).filter(is_valid);
        known.min_by(|a, b| values[*a].total_cmp(&values[*b]))
    }
}

/// Where a table has a number of the first screen, so that the page can check it.
#[derive(Debug, Serialize)]
pub(super) struct Check {
    file: String,
    /// Columns; of several, the largest absolute value counts.
    columns: Vec<String>,
    /// Cells that a row must have, by column.
    r#where: Vec<(String, String)>,
    /// Columns that identify a row.
    coordinates: Vec<String>,
    /// Tables that must have the same node.
    common: Vec<String>,
    rule: Rule,
    value: f64,
}

/// Which value of the columns is meant.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Rule {
    Max,
    Min,
}

impl Check {
    /// Returns a check that `value` is the extreme of a quantity of the result `who`, first group; `None` if the page leaves nodes out.
    pub fn of(writer: &VerdictWriter<'_>, quantity: usize, who: usize, rule: Rule, value: f64) -> Option<Self> {
        let aligned = writer.aligned;
        if aligned.data.iter().any(|data| data.thinned_from.is_some()) {
            return None;
        }
        let shared = &aligned.shared;
        let table = |folder: &String| format!("{folder}/{}", shared.table);
        let group = shared.group.as_ref().and_then(|group| Some((&group.columns, &group.values.first()?.cells)));
        let is_own = aligned.has_own_extremes();
        let others = writer.folders.iter().enumerate().filter(|(other, _)| *other != who && !is_own);
        Some(Self {
            file: table(&writer.folders[who]),
            columns: shared.quantities[quantity].columns.clone(),
            r#where: group
                .map(|(columns, cells)| columns.iter().cloned().zip(cells.iter().cloned()).collect())
                .unwrap_or_default(),
            coordinates: shared.keys().iter().map(|column| column.column.clone()).collect(),
            common: others.map(|(_, folder)| table(folder)).collect(),
            rule,
            value,
        })
    }

    /// Returns the check over all rows of its own table.
    #[must_use]
    pub fn own_rows(self) -> Self {
        Self { common: Vec::new(), ..self }
    }
}
