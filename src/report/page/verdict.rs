//! The first screen of a comparison: one sentence, at most three numbers, and what of the tables they quote.

use std::collections::HashSet;

use serde::Serialize;

use super::{
    aligned::Aligned,
    check::{Check, Checked},
    dataset::Dataset,
    description::{Better, Shape},
    floors::{Floors, against, percent, rounding},
    table::number,
    winners::Winners,
    wins::Extremes,
};
use crate::report::words::position;

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

    fn unit(&self, quantity: usize) -> &str {
        &self.aligned.shared.quantities[quantity].unit
    }

    fn floor(&self, quantity: usize) -> f64 {
        self.floors.of(self.unit(quantity))
    }

    /// "B (delta_3puu)".
    pub fn named(&self, who: usize) -> String {
        match self.names.get(who) {
            Some(name) if !name.is_empty() => format!("{} ({name})", self.letters[who]),
            _ => self.letters[who].to_string(),
        }
    }

    fn extent(&self) -> String {
        match self.aligned.shared.shape {
            Shape::Grid if self.aligned.noun() == "grid point" => "the workspace".into(),
            Shape::Curve => "the path".into(),
            Shape::Grid | Shape::Names => format!("the {}s", self.aligned.noun()),
        }
    }

    /// Whether a small number is a tool that moves less.
    fn is_motion(&self, quantity: usize) -> bool {
        let label = &self.aligned.shared.quantities[quantity].label;
        label.contains("deflection") || label.contains("displacement")
    }

    /// "the tool of B moves less", "B has the smaller departure".
    fn is_better(&self, quantity: usize, who: usize, of_two: bool) -> String {
        let q = &self.aligned.shared.quantities[quantity];
        let name = self.named(who);
        let (less, smaller, larger) =
            if of_two { ("less", "smaller", "larger") } else { ("least", "smallest", "largest") };
        match q.better {
            _ if self.is_motion(quantity) => format!("The tool of {name} moves {less}"),
            Better::Larger => format!("{name} has the {larger} {}", q.label),
            _ => format!("{name} has the {smaller} {}", q.label),
        }
    }

    fn of_other(&self, quantity: usize, who: usize) -> String {
        if self.is_motion(quantity) { format!("that of {}", self.named(who)) } else { self.named(who) }
    }

    fn who_of_two(&self, quantity: usize, winners: &Winners) -> String {
        let order = winners.order();
        let (first, second, extent) = (order[0], order[1], self.extent());
        let Some(typical) = winners.typical(first) else {
            let (floor, unit) = (self.floor(quantity), self.unit(quantity));
            return format!(
                "{} and {} are the same: their {} differs nowhere by more than {} {unit}.",
                self.named(0),
                self.named(1),
                self.aligned.shared.quantities[quantity].label,
                rounding(floor)
            );
        };
        let better = self.is_better(quantity, first, true);
        let by = format!("typically by {}", percent(typical));
        if let Some(node) = winners.most(second) {
            let only = if winners.share(second) < 0.2 { "only in" } else { "in" };
            return format!(
                "{better} in {} of {extent}, {by}; {} {only} {}, most of all {}.",
                percent(winners.share(first)),
                self.of_other(quantity, second),
                percent(winners.share(second)),
                self.at(self.place(&self.aligned.common.parts[0], node))
            );
        }
        match winners.share_same() {
            0.0 => format!("{better} everywhere in {extent}, {by}."),
            share => format!(
                "{better} in {} of {extent}, {by}; in the other {} they are the same.",
                percent(winners.share(first)),
                percent(share)
            ),
        }
        .replace("everywhere in the path", "everywhere along the path")
        .replace("everywhere in the methods", "with every method")
    }

    fn who_of_several(&self, quantity: usize, winners: &Winners) -> String {
        let order = winners.order();
        let Some(typical) = winners.typical(order[0]) else {
            return format!("Nowhere in {} is one of the {} better than all others.", self.extent(), order.len());
        };
        let others = order[1..].iter().map(|who| {
            let other = self.of_other(quantity, *who);
            match winners.share(*who) {
                0.0 => format!("{other} nowhere"),
                share => format!("{other} in {}", percent(share)),
            }
        });
        let share = match winners.share(order[0]) {
            1.0 => format!("everywhere in {}", self.extent()),
            share => format!("in {} of {}", percent(share), self.extent()),
        };
        let better = self.is_better(quantity, order[0], false);
        let less = if self.aligned.shared.quantities[quantity].better == Better::Larger { "more" } else { "less" };
        let by = format!("typically {} {less} than the next best", percent(typical));
        format!("{better} {share}, {by}; {}.", others.collect::<Vec<_>>().join(", "))
    }

    /// The result whose worst number is the best.
    fn least_bad(&self, quantity: usize, extremes: &[Extremes]) -> usize {
        let sign = if self.aligned.shared.quantities[quantity].better == Better::Larger { -1.0 } else { 1.0 };
        let cost = |who: &usize| sign * self.worst(quantity, &extremes[*who]).0;
        (0..extremes.len()).min_by(|a, b| cost(a).total_cmp(&cost(b))).unwrap_or(0)
    }

    fn worst(&self, quantity: usize, extremes: &Extremes) -> (f64, usize) {
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

    fn by_worst(&self, quantity: usize, best: usize, extremes: &[Extremes]) -> String {
        let q = &self.aligned.shared.quantities[quantity];
        let of = |who: usize| self.worst(quantity, &extremes[who]).0;
        let others: Vec<String> = (0..extremes.len())
            .filter(|who| *who != best)
            .map(|who| self.than(quantity, of(best), who, of(who)))
            .collect();
        let which = if q.better == Better::Larger { "smallest" } else { "largest" };
        format!(
            "The {which} {} of {} is {} {}: {}.",
            bare(&q.label),
            self.named(best),
            three(of(best)),
            q.unit,
            others.join(", ")
        )
    }

    /// "24 % less than in A (1.71 mm)".
    pub fn than(&self, quantity: usize, value: f64, other: usize, reference: f64) -> String {
        let letter = self.letters[other];
        let shown = format!("{} {}", three(reference), self.unit(quantity)).trim_end().to_string();
        match against(value, reference, self.floor(quantity)) {
            words if words == "the same" => format!("the same as in {letter}"),
            words if words.ends_with("less") || words.ends_with("more") => {
                format!("{words} than in {letter} ({shown})")
            }
            words if words.ends_with("as much") => format!("{words} as in {letter} ({shown})"),
            words if words.ends_with("of it") => {
                format!("{}of the {shown} in {letter}", words.trim_end_matches("of it"))
            }
            _ => format!("in {letter} {shown}"),
        }
    }

    /// "at (1, 2, 3) mm", "53.2 mm along the path", "with newton".
    fn at(&self, place: String) -> String {
        match self.aligned.shared.shape {
            Shape::Grid => format!("at {place}"),
            Shape::Curve => place,
            Shape::Names => format!("with {place}"),
        }
    }

    pub fn place(&self, data: &Dataset, node: usize) -> String {
        let coordinates = &self.aligned.shared.coordinates;
        let is_position = coordinates.len() == 3 && coordinates.iter().all(|c| c.unit == "mm");
        match data.position(node) {
            Some(at) if is_position && at.len() == 3 => position(at[0], at[1], at[2]),
            Some(at) if at.len() == 1 => {
                let column = &coordinates[0];
                format!("{} {} {}", three(at[0]), column.unit, column.label.replace("length along", "along"))
            }
            _ => data.place(&self.aligned.shared, node),
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

/// A quantity without the "worst" or "largest" that it is itself over something else.
fn bare(label: &str) -> &str {
    ["worst ", "largest ", "smallest "].iter().find_map(|word| label.strip_prefix(word)).unwrap_or(label)
}

/// Three significant digits, as large numbers are read.
pub(super) fn three(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return number(value);
    }
    let digits = (2.0 - value.abs().log10().floor()).max(0.0);
    if digits > 7.0 {
        return number(value);
    }
    crate::report::words::typographic(&format!("{value:.*}", digits as usize))
}
