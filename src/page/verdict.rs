//! The first screen of a comparison: one sentence, at most three numbers, and what of the tables they quote.

use std::collections::HashSet;

use serde::Serialize;

use super::{
    aligned::Aligned,
    description::{Better, Quantity, Shape},
    picture::{Picture, bars},
    sentences::{bare, three},
    winners::{Extremes, percent},
};

/// What places are judged by.
const OBJECTIVE: &str = "objective";

/// What a comparison says first.
#[derive(Debug, Default, Serialize)]
pub(super) struct Verdict {
    /// The answer.
    pub sentence: String,
    /// At most three.
    pub numbers: Vec<Large>,
    /// What follows from it.
    pub lines: Vec<String>,
    /// Which numbers of which tables these are.
    pub checks: Vec<Check>,
}

/// A number in large letters.
#[derive(Debug, Serialize)]
pub(super) struct Large {
    pub value: String,
    pub unit: String,
    /// What it is.
    pub what: String,
    /// What it is measured against.
    pub against: String,
}

/// What is compared, and by which names.
pub(super) struct Compares<'a> {
    /// The view that the verdict rests on.
    pub aligned: &'a Aligned,
    /// The name of each result, where they have names of their own.
    pub names: &'a [String],
    /// How much may be, mm.
    pub tolerance_mm: Option<f64>,
    /// Addresses of the result folders on the page.
    pub folders: &'a [String],
}

impl Compares<'_> {
    /// The quantity that the first screen is about: the first of which one value is the better one.
    pub fn quantity(&self) -> Option<usize> {
        self.aligned.shared.quantities.iter().position(|q| q.better != Better::Neither)
    }

    /// The verdict; `None` if there is no number to be compared.
    pub fn verdict(&self) -> Option<Verdict> {
        let quantity = self.quantity()?;
        let extremes = self.aligned.extremes(quantity, 0)?;
        let winners = self.aligned.winners(quantity)?;
        let (is_curve, is_whole) = (self.aligned.shared.shape == Shape::Curve, self.aligned.is_whole());
        let by_place = winners.counted() > 0 && (is_whole || !is_curve);
        let best = if by_place { winners.order()[0] } else { self.least_bad(quantity, &extremes) };
        let sentence = match by_place {
            true if self.aligned.letters.len() == 2 => self.who_of_two(quantity, &winners),
            true => self.who_of_several(quantity, &winners),
            false => self.by_worst(quantity, best, &extremes),
        };
        let mut verdict = Verdict { sentence, ..Verdict::default() };
        self.add_extremes(quantity, best, &extremes, &mut verdict);
        match self.tolerance_mm.filter(|_| self.unit(quantity) == "mm") {
            Some(tolerance) => self.add_within(quantity, best, tolerance, by_place, &mut verdict),
            None if by_place => self.add_difference(quantity, best, &mut verdict),
            None => {}
        }
        Some(verdict)
    }

    /// The result whose worst number is the best.
    fn least_bad(&self, quantity: usize, extremes: &[Extremes]) -> usize {
        let sign = if self.aligned.shared.quantities[quantity].better == Better::Larger { -1.0 } else { 1.0 };
        let cost = |who: &usize| sign * self.worst(quantity, &extremes[*who]).0;
        (0..extremes.len()).min_by(|a, b| cost(a).total_cmp(&cost(b))).unwrap_or(0)
    }

    pub(super) fn worst(&self, quantity: usize, extremes: &Extremes) -> (f64, usize) {
        match self.aligned.shared.quantities[quantity].better {
            Better::Larger => extremes.smallest,
            _ => extremes.largest,
        }
    }

    fn best(&self, quantity: usize, extremes: &Extremes) -> (f64, usize) {
        match self.aligned.shared.quantities[quantity].better {
            Better::Larger => extremes.largest,
            _ => extremes.smallest,
        }
    }

    /// The worst and the best number of the winner, each against the same of the others.
    fn add_extremes(&self, quantity: usize, best: usize, extremes: &[Extremes], verdict: &mut Verdict) {
        let q = &self.aligned.shared.quantities[quantity];
        let (data, _) = self.aligned.extremes_of();
        let is_larger = q.better == Better::Larger;
        let which = if is_larger { ["smallest", "largest"] } else { ["largest", "smallest"] };
        type Of<'b> = &'b dyn Fn(&Extremes) -> (f64, usize);
        let of: [Of<'_>; 2] = [&|e| self.worst(quantity, e), &|e| self.best(quantity, e)];
        for (which, of) in which.into_iter().zip(of) {
            let (value, node) = of(&extremes[best]);
            let others = (0..extremes.len()).filter(|who| *who != best);
            verdict.numbers.push(Large {
                value: three(value),
                unit: q.unit.clone(),
                what: format!(
                    "{which} {} in {}, {}",
                    bare(&q.label),
                    self.aligned.letters[best],
                    self.at(self.place(&data[best], node))
                ),
                against: others
                    .map(|who| self.than(quantity, value, who, of(&extremes[who]).0))
                    .collect::<Vec<_>>()
                    .join("; "),
            });
            for (who, own) in extremes.iter().enumerate() {
                let rule = if which == "largest" { Checked::Max } else { Checked::Min };
                verdict.checks.extend(Check::of(self, quantity, who, rule, of(own).0));
            }
        }
    }

    /// How much of the winner is within the tolerance, and whether the difference matters.
    fn add_within(&self, quantity: usize, best: usize, tolerance: f64, by_place: bool, verdict: &mut Verdict) {
        let (data, _) = self.aligned.extremes_of();
        let share = |who: usize| {
            let values = data[who].values[quantity][0].iter().filter(|value| value.is_finite());
            values.clone().filter(|value| value.abs() <= tolerance).count() as f64 / values.count().max(1) as f64
        };
        let others = (0..data.len()).filter(|who| *who != best);
        verdict.numbers.push(Large {
            value: percent(share(best)).trim_end_matches(" %").to_string(),
            unit: "%".into(),
            what: format!("of {} within {tolerance} mm in {}", self.extent(), self.aligned.letters[best]),
            against: others
                .map(|who| format!("in {} {}", self.aligned.letters[who], percent(share(who))))
                .collect::<Vec<_>>()
                .join("; "),
        });
        let differences = self.differences(quantity, best);
        if differences.is_empty() || !by_place {
            return;
        }
        let matters = differences.iter().filter(|(_, by)| *by > tolerance).count();
        verdict.lines.push(match matters {
            0 => format!(
                "Nowhere do they differ by more than the tolerance of {tolerance} mm: for it, the difference does not \
                 matter."
            ),
            count => format!(
                "They differ by more than the tolerance of {tolerance} mm in {} of {}: there the difference matters.",
                percent(count as f64 / differences.len() as f64),
                self.extent()
            ),
        });
    }

    /// By how much the winner differs from the others at most, where no tolerance says whether it matters.
    fn add_difference(&self, quantity: usize, best: usize, verdict: &mut Verdict) {
        let differences = self.differences(quantity, best);
        let Some((node, by)) = differences.into_iter().max_by(|a, b| a.1.total_cmp(&b.1)) else { return };
        let is_length = self.unit(quantity) == "mm";
        let is_nothing = by <= self.floor(quantity);
        verdict.numbers.push(Large {
            value: if is_nothing { "0".into() } else { three(by) },
            unit: self.unit(quantity).into(),
            what: match is_nothing {
                true => "largest difference, but for rounding".into(),
                false => {
                    format!("largest difference, {}", self.at(self.place(&self.aligned.parts[0], node)))
                }
            },
            against: match is_length {
                true => "no tolerance is given to hold it against".into(),
                false => String::new(),
            },
        });
    }

    /// The largest difference of `best` from another result at each node at which all have an answer.
    fn differences(&self, quantity: usize, best: usize) -> Vec<(usize, f64)> {
        let parts = &self.aligned.parts;
        let value = |who: usize, node: usize| parts[who].values[quantity][0][node];
        let flagged: HashSet<usize> = parts.iter().flat_map(|part| &part.flags[0]).map(|flag| flag.0).collect();
        (0..self.aligned.count())
            .filter_map(|node| {
                let by = (0..parts.len()).map(|who| (value(who, node) - value(best, node)).abs());
                let by = by.fold(0.0, |most: f64, by| if by.is_nan() { f64::NAN } else { most.max(by) });
                (by.is_finite() && !flagged.contains(&node)).then_some((node, by))
            })
            .collect()
    }
}

/// The first screen of compared placements: what the place found best costs in each.
impl Compares<'_> {
    /// The verdict on the best places of several placements; `None` if the view is not one of judged places.
    pub fn on_best_places(&self) -> Option<Verdict> {
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
            let words = others.map(|who| self.than(quantity, value(best, quantity), *who, value(*who, quantity)));
            words.collect::<Vec<_>>().join("; ")
        };
        let q = &shared.quantities[main];
        let mut verdict = Verdict {
            sentence: format!(
                "At its best place {} has a {} of {} {}, {}.",
                self.named(best),
                q.label,
                three(value(best, main)),
                q.unit,
                against(main)
            ),
            ..Verdict::default()
        };
        for quantity in
            [Some(main), costs.iter().copied().find(|index| shared.quantities[*index].label.contains("correction"))]
        {
            let Some(quantity) = quantity.filter(|q| value(best, *q).is_finite()) else { continue };
            let at = self.place(&self.aligned.data[best], chosen[best]);
            verdict.numbers.push(Large {
                value: three(value(best, quantity)),
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
            let others = order[1..]
                .iter()
                .map(|who| format!("in {} {}", self.aligned.letters[*who], percent(value(*who, within))));
            verdict.numbers.push(Large {
                value: percent(value(best, within)).trim_end_matches(" %").to_string(),
                unit: "%".into(),
                what: format!("of the path within the tolerance of its study in {}", self.aligned.letters[best]),
                against: others.collect::<Vec<_>>().join("; "),
            });
        }
        for who in order {
            let objective_value = value(who, objective);
            verdict.checks.extend(Check::of(self, objective, who, Checked::Min, objective_value).map(Check::alone));
        }
        Some(verdict)
    }

    /// What the best places cost, as a picture; `None` as for [`Compares::on_best_places`].
    pub fn best_places_drawn(&self) -> Option<Picture> {
        let shared = &self.aligned.shared;
        let objective = shared.quantities.iter().position(|q| q.label == OBJECTIVE)?;
        let main = shared.quantities.iter().position(|q| q.unit == "mm" && q.better == Better::Smaller)?;
        let value = |who: usize| Some(self.aligned.data[who].values[main][0][self.best_row(who, objective)?]);
        let values: Vec<f64> = (0..self.aligned.letters.len()).map(value).collect::<Option<_>>()?;
        let q = &shared.quantities[main];
        bars(format!("{} at the best place of each", q.label), &q.unit, &values, &self.aligned.letters)
    }

    /// The row with the smallest objective that is an answer.
    fn best_row(&self, who: usize, objective: usize) -> Option<usize> {
        let data = &self.aligned.data[who];
        let is_answer = |node: &usize| !data.flags[0].iter().any(|flag| flag.0 == *node);
        let values = &data.values[objective][0];
        let known = (0..values.len()).filter(|node| values[*node].is_finite()).filter(is_answer);
        known.min_by(|a, b| values[*a].total_cmp(&values[*b]))
    }
}

/// A number on the first screen, and how it follows from a table.
#[derive(Debug, Serialize)]
pub(super) struct Check {
    /// Address of the table on the page.
    file: String,
    /// Columns; of several, the largest size counts.
    columns: Vec<String>,
    /// Cells that a row must have, by column.
    r#where: Vec<(String, String)>,
    /// Columns that say where a row belongs.
    coordinates: Vec<String>,
    /// Tables that must have the same place.
    common: Vec<String>,
    /// What is taken of the rows.
    rule: Checked,
    /// The number.
    value: f64,
}

/// What is taken of a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Checked {
    /// The largest number.
    Max,
    /// The smallest.
    Min,
}

impl Check {
    /// That `value` is the extreme of a quantity of the result `who`, in the first group; `None` if the page leaves nodes out.
    pub fn of(compares: &Compares<'_>, quantity: usize, who: usize, rule: Checked, value: f64) -> Option<Self> {
        let aligned = compares.aligned;
        if aligned.data.iter().any(|data| data.thinned_from.is_some()) {
            return None;
        }
        let shared = &aligned.shared;
        let table = |folder: &String| format!("{folder}/{}", shared.table);
        let group = shared.group.as_ref().and_then(|group| Some((&group.columns, &group.values.first()?.cells)));
        let (_, over) = aligned.extremes_of();
        let is_own = over.contains("own");
        let others = compares.folders.iter().enumerate().filter(|(other, _)| *other != who && !is_own);
        Some(Self {
            file: table(&compares.folders[who]),
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

    /// The same over all rows of its own table.
    #[must_use]
    pub fn alone(self) -> Self {
        Self { common: Vec::new(), ..self }
    }
}
