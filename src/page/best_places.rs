//! The first screen of compared placements: what the place found best costs in each.

use super::{
    check::{Check, Checked},
    description::{Better, Shape},
    floors::percent,
    picture::{Picture, bars},
    sentences::three,
    verdict::{Compares, Large, Verdict},
};

/// What places are judged by.
const OBJECTIVE: &str = "objective";

impl Compares<'_> {
    /// The verdict on the best places of several placements; `None` if the view is not one of judged places.
    pub fn on_best_places(&self) -> Option<Verdict> {
        let shared = &self.aligned.shared;
        let objective = shared.quantities.iter().position(|q| q.label == OBJECTIVE)?;
        let is_cost = |(_, q): &(usize, &super::description::Quantity)| q.unit == "mm" && q.better == Better::Smaller;
        let costs: Vec<usize> = shared.quantities.iter().enumerate().filter(is_cost).map(|(index, _)| index).collect();
        let main = *costs.first().filter(|_| shared.shape == Shape::Names)?;
        let chosen: Vec<usize> =
            (0..self.letters.len()).map(|who| self.best_row(who, objective)).collect::<Option<_>>()?;
        let value = |who: usize, quantity: usize| self.aligned.data[who].values[quantity][0][chosen[who]];
        let mut order: Vec<usize> = (0..self.letters.len()).collect();
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
                    shared.quantities[quantity].label, self.letters[best]
                ),
                against: against(quantity),
            });
        }
        let within = shared.quantities.iter().position(|q| q.label == "share of the path within tolerance");
        if let Some(within) = within.filter(|within| value(best, *within).is_finite()) {
            let others =
                order[1..].iter().map(|who| format!("in {} {}", self.letters[*who], percent(value(*who, within))));
            verdict.numbers.push(Large {
                value: percent(value(best, within)).trim_end_matches(" %").to_string(),
                unit: "%".into(),
                what: format!("of the path within the tolerance of its study in {}", self.letters[best]),
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
        let values: Vec<f64> = (0..self.letters.len()).map(value).collect::<Option<_>>()?;
        let q = &shared.quantities[main];
        bars(format!("{} at the best place of each", q.label), &q.unit, &values, self.letters)
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
