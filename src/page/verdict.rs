//! The first screen of a comparison: one sentence, at most three numbers, and what of the tables they quote.

use std::collections::HashSet;

use serde::Serialize;

use super::{
    aligned::Aligned,
    check::{Check, Checked},
    description::{Better, Shape},
    floors::{Floors, percent},
    sentences::{bare, three},
    winners::Winners,
    wins::Extremes,
};

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
    /// What is rounding in it.
    pub floors: &'a Floors,
    /// A letter for each result.
    pub letters: &'a [char],
    /// Its name, where the results have names of their own.
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
        let better = self.aligned.shared.quantities[quantity].better;
        let extremes = self.aligned.extremes(quantity, 0)?;
        let winners = Winners::new(&self.aligned.common, quantity, 0, better, self.floor(quantity))?;
        let (is_curve, is_whole) =
            (self.aligned.shared.shape == Shape::Curve, self.aligned.common.is_whole(&self.aligned.data));
        let by_place = winners.counted() > 0 && (is_whole || !is_curve);
        let best = if by_place { winners.order()[0] } else { self.least_bad(quantity, &extremes) };
        let sentence = match by_place {
            true if self.letters.len() == 2 => self.who_of_two(quantity, &winners),
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
                    self.letters[best],
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
            what: format!("of {} within {tolerance} mm in {}", self.extent(), self.letters[best]),
            against: others
                .map(|who| format!("in {} {}", self.letters[who], percent(share(who))))
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
                    format!("largest difference, {}", self.at(self.place(&self.aligned.common.parts[0], node)))
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
        let parts = &self.aligned.common.parts;
        let value = |who: usize, node: usize| parts[who].values[quantity][0][node];
        let flagged: HashSet<usize> = parts.iter().flat_map(|part| &part.flags[0]).map(|flag| flag.0).collect();
        (0..self.aligned.common.count())
            .filter_map(|node| {
                let by = (0..parts.len()).map(|who| (value(who, node) - value(best, node)).abs());
                let by = by.fold(0.0, |most: f64, by| if by.is_nan() { f64::NAN } else { most.max(by) });
                (by.is_finite() && !flagged.contains(&node)).then_some((node, by))
            })
            .collect()
    }
}
