//! The first screen of a comparison, and where the tables have its numbers.

use std::collections::HashSet;

use serde::Serialize;

use super::{
    aligned::Aligned,
    dataset::Dataset,
    description::{Better, Quantity, Shape},
    drawn::P95_APART,
    headline::{Headline, KeyNumber, State, Verdict},
    picture::{LEADS, Picture, bar_picture},
    sentences::{three_digits, without_extreme_word},
    winners::{Extremes, percent},
};
use crate::{files::words::with_unit, simulation::spread_along::ALIKE};

/// Label of the quantity by which placements are judged.
const OBJECTIVE: &str = "objective";

/// Mark of a comparison for which no tolerance says from where on a difference matters.
const NO_TOLERANCE: &str = "no tolerance given";
/// What to do next there.
const COMPARE_AGAIN: &str = "compare again with --tolerance MM, which says where the difference matters.";

/// First screen of a comparison with checks of its numbers.
#[derive(Debug, Default)]
pub(super) struct FirstScreen {
    pub headline: Headline,
    pub checks: Vec<Check>,
}

/// Shares that differ by less are the same.
const SHARE_APART: f64 = 0.005;

/// Whether a quantity is a 95 % quantile of a length, by which results with uncertain inputs are judged.
fn is_quantile(quantity: &Quantity) -> bool {
    quantity.label.starts_with("95 % quantile") && quantity.unit == "mm"
}

/// What a comparison is judged by.
struct Judged<'a> {
    quantity: usize,
    /// The result that is named.
    best: usize,
    tolerance: f64,
    /// Whether the results are compared node by node.
    by_place: bool,
    /// Share of each result within the tolerance.
    shares: Vec<f64>,
    extremes: &'a [Extremes],
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
    /// Returns the quantity of the first screen: on maps a 95 % quantile that all results have, as each is judged by it; else the first one whose
    /// small or large values are better; `None` without any.
    pub fn main_quantity(&self) -> Option<usize> {
        let quantities = &self.aligned.shared.quantities;
        let is_judged = |q: &Quantity| self.aligned.shared.shape == Shape::Grid && is_quantile(q);
        let first = || quantities.iter().position(|q| q.better != Better::Neither);
        quantities.iter().position(is_judged).or_else(first)
    }

    /// Returns the first screen; `None` if no number can be compared.
    pub fn first_screen(&self) -> Option<FirstScreen> {
        let quantity = self.main_quantity()?;
        let extremes = self.aligned.extremes(quantity, 0)?;
        let winners = self.aligned.winners(quantity)?;
        let (is_curve, has_same_nodes) = (self.aligned.shared.shape == Shape::Curve, self.aligned.has_same_nodes());
        let by_place = winners.compared_count() > 0 && (has_same_nodes || !is_curve);
        let worst_best = self.best_worst_case(quantity, &extremes);
        let mut best = if by_place { winners.order_by_wins()[0] } else { worst_best };
        let [sentence, by_how_much] = match by_place {
            true if self.aligned.letters.len() == 2 => self.best_of_two(quantity, &winners),
            true => self.best_of_several(quantity, &winners),
            false => self.worst_case(quantity, best, &extremes),
        };
        let shares =
            self.tolerance_mm.filter(|_| self.unit(quantity) == "mm").map(|own| self.shares_within(quantity, own));
        let unsolved = shares.as_ref().map_or_else(String::new, |_| self.unsolved_text(quantity));
        let headline = match shares.as_ref().and_then(|shares| self.surest(shares, [best, worst_best])) {
            // What each result is judged by comes first.
            Some(surest) => {
                best = surest;
                let share = |who: usize| {
                    format!("in {} {}", self.full_name(who), percent(shares.as_ref().map_or(0.0, |own| own[who])))
                };
                let others = (0..extremes.len()).filter(|who| *who != best).map(share).collect::<Vec<_>>().join(", ");
                let first = format!("More of {} is within tolerance {}; {others}.", self.extent_text(), share(best));
                Headline::new(first, self.extent_text()).with_cautions(&format!("{unsolved}{sentence}\n{by_how_much}"))
            }
            None => Headline::new(sentence, self.extent_text()).with_cautions(&(unsolved + &by_how_much)),
        };
        let mut screen = FirstScreen { headline, ..FirstScreen::default() };
        self.add_extremes(quantity, best, &extremes, &mut screen);
        match self.tolerance_mm.zip(shares) {
            Some((tolerance, shares)) => {
                let judged = Judged { quantity, best, tolerance, by_place, shares, extremes: &extremes };
                self.add_tolerance_share(&judged, &mut screen.headline);
            }
            None if by_place => self.add_difference(quantity, best, &mut screen.headline),
            None => {}
        }
        if self.tolerance_mm.is_none() {
            let letter = self.aligned.letters[best];
            let by = |share: f64| format!("typically by {}", percent(share));
            let [typical, most, largest] = self.gaps(quantity, best);
            let (text, next) = match (winners.win_share(best), winners.typical_lead(best).unwrap_or_default()) {
                _ if !by_place => (format!("{letter} better at its worst"), COMPARE_AGAIN),
                _ if largest == 0.0 => (
                    "No difference but for rounding".into(),
                    "take either: nothing that was computed tells them apart.",
                ),
                _ if most < LEADS[0] => (format!("Hardly apart: typically {}", percent(typical)), COMPARE_AGAIN),
                (0.0, _) => ("The best of them are equal".into(), COMPARE_AGAIN),
                (1.0, lead) => (format!("{letter} better everywhere, {}", by(lead)), COMPARE_AGAIN),
                (share, lead) => (format!("{letter} better in {}, {}", percent(share), by(lead)), COMPARE_AGAIN),
            };
            let verdict = Verdict::new(State::Open, text);
            screen.headline = screen.headline.judged(verdict, false).next(next).marked(NO_TOLERANCE);
        }
        Some(screen)
    }

    /// Returns the result with the best worst value.
    fn best_worst_case(&self, quantity: usize, extremes: &[Extremes]) -> usize {
        let better = self.aligned.shared.quantities[quantity].better;
        let cost = |who: &usize| better.sign() * extremes[*who].worst_and_best(better)[0].0;
        (0..extremes.len()).min_by(|a, b| cost(a).total_cmp(&cost(b))).unwrap_or(0)
    }

    /// Adds worst and best value of the result `best`, each compared with the same of the other results.
    fn add_extremes(&self, quantity: usize, best: usize, extremes: &[Extremes], screen: &mut FirstScreen) {
        let q = &self.aligned.shared.quantities[quantity];
        let (data, _) = self.aligned.extremes_basis();
        let is_larger = q.better == Better::Larger;
        let which = if is_larger { ["smallest", "largest"] } else { ["largest", "smallest"] };
        for (end, which) in which.into_iter().enumerate() {
            let extreme_of = |extremes: &Extremes| extremes.worst_and_best(q.better)[end];
            let (value, node) = extreme_of(&extremes[best]);
            let comparison = |who: usize| self.comparison(quantity, value, who, extreme_of(&extremes[who]).0);
            let others: Vec<String> = (0..extremes.len()).filter(|who| *who != best).map(comparison).collect();
            let (label, letter) = (without_extreme_word(&q.label), self.aligned.letters[best]);
            let what = format!("{which} {label} in {letter}, {}", self.location(self.node_text(&data[best], node)));
            let shown = with_unit(&three_digits(value), &q.unit);
            screen.headline.numbers.push(KeyNumber::new(&shown, what, others.join("; ")));
            for (who, own_extremes) in extremes.iter().enumerate() {
                let rule = if which == "largest" { Rule::Max } else { Rule::Min };
                screen.checks.extend(Check::of(self, quantity, who, rule, extreme_of(own_extremes).0));
            }
        }
    }

    /// Returns for each result the share within the tolerance, weighted as [`Aligned::weights`] says: on a map of all of it, as where nothing could be solved the
    /// tool is not within; else of the nodes where all are known, where these are the same.
    fn shares_within(&self, quantity: usize, tolerance: f64) -> Vec<f64> {
        let (data, _) = self.aligned.extremes_basis();
        let is_map = self.aligned.is_map();
        let share = |(data, valid): (&Dataset, Vec<bool>)| {
            let (mut within, mut all) = (0.0, 0.0);
            for ((value, weight), valid) in data.values[quantity][0].iter().zip(self.aligned.weights(data)).zip(valid) {
                all += if valid || is_map { weight } else { 0.0 };
                within += if valid && value.abs() <= tolerance { weight } else { 0.0 };
            }
            within / all.max(f64::MIN_POSITIVE)
        };
        let valid = if is_map { self.aligned.known_nodes(quantity, 0) } else { self.aligned.valid_nodes(quantity, 0) };
        data.iter().zip(valid).map(share).collect()
    }

    /// Returns how many points of each map have no number, and that they count as out of tolerance; empty where all have one.
    fn unsolved_text(&self, quantity: usize) -> String {
        let unknown = |known: &Vec<bool>| known.iter().filter(|known| !**known).count();
        let unknown: Vec<usize> = match self.aligned.is_map() {
            true => self.aligned.known_nodes(quantity, 0).iter().map(unknown).collect(),
            false => Vec::new(),
        };
        if unknown.iter().all(|own| *own == 0) {
            return String::new();
        }
        let each = unknown
            .iter()
            .zip(&self.aligned.letters)
            .map(|(own, letter)| format!("{letter} at {own}"))
            .collect::<Vec<_>>();
        format!("Without a number, and counted as out of tolerance: {}.\n", each.join(", "))
    }

    /// Returns the result with the largest of `shares`, of equal ones the first of `preferred` among them; `None` where all are equal.
    fn surest(&self, shares: &[f64], preferred: [usize; 2]) -> Option<usize> {
        let largest = shares.iter().copied().fold(0.0, f64::max);
        let is_first = |who: &usize| largest - shares[*who] <= SHARE_APART;
        let others = 0..shares.len();
        preferred
            .into_iter()
            .chain(others.clone())
            .find(is_first)
            .filter(|_| !others.into_iter().all(|who| is_first(&who)))
    }

    /// Returns which result has the best worst value, and by which share of the next one's; `None` where that is less than what is known.
    fn best_at_worst(&self, quantity: usize, extremes: &[Extremes]) -> Option<(usize, f64)> {
        let q = &self.aligned.shared.quantities[quantity];
        let size = |who: usize| extremes[who].worst_and_best(q.better)[0].0;
        let best = self.best_worst_case(quantity, extremes);
        let others = (0..extremes.len()).filter(|who| *who != best).map(size);
        let next = others.min_by(|a, b| (q.better.sign() * a).total_cmp(&(q.better.sign() * b)))?;
        let lead = (next - size(best)).abs() / next.abs().max(size(best).abs()).max(self.floor(quantity));
        (lead > if is_quantile(q) { P95_APART - 1.0 } else { ALIKE }).then_some((best, lead))
    }

    /// Adds the share of the best result within the tolerance, the verdict, and a sentence on whether the difference matters point by point.
    fn add_tolerance_share(&self, judged: &Judged<'_>, headline: &mut Headline) {
        let Judged { quantity, best, tolerance, by_place, shares, .. } = judged;
        let (quantity, best, tolerance) = (*quantity, *best, *tolerance);
        let share_in = |who: usize| format!("in {} {}", self.aligned.letters[who], percent(shares[who]));
        let others: Vec<String> = (0..shares.len()).filter(|who| *who != best).map(share_in).collect();
        let letter = self.aligned.letters[best];
        let sure = if is_quantile(&self.aligned.shared.quantities[quantity]) { " with 95 % probability" } else { "" };
        let what = format!("of {} within {tolerance} mm{sure} in {letter}", self.extent_text());
        headline.numbers.push(KeyNumber::new(&percent(shares[best]), what, others.join("; ")));
        let differences = if *by_place { self.differences(quantity, best) } else { Vec::new() };
        let weights = self.aligned.common.first().map_or_else(Vec::new, |part| self.aligned.weights(part));
        let leads = self.leads(quantity, best, &differences);
        // Shares of what is compared: of the differences, and of the leads beyond the tolerance either way.
        let total: f64 = differences.iter().map(|(node, _)| weights[*node]).sum();
        let share_of = |counts: &dyn Fn(usize) -> bool| -> f64 {
            let counted = (0..differences.len()).filter(|k| counts(*k));
            let count = counted.clone().count();
            let sum: f64 = counted.map(|k| weights[differences[k].0]).sum();
            if count == differences.len() && count > 0 { 1.0 } else { sum / total.max(f64::MIN_POSITIVE) }
        };
        let matters = share_of(&|k| differences[k].1 > tolerance);
        let [ahead, behind] = [1.0, -1.0].map(|sign| share_of(&|k| sign * leads[k] > tolerance));
        let (verdict, next) = self.verdict_by_tolerance(judged, matters, [ahead, behind]);
        (headline.verdict, headline.next) = (Some(verdict), Some(next));
        if differences.is_empty() {
            return;
        }
        headline.cautions.push(match matters {
            0.0 => format!("Nowhere do the results differ by more than the tolerance of {tolerance} mm."),
            share => format!(
                "The results differ by more than the tolerance of {tolerance} mm in {} of {}: there the difference matters.",
                percent(share),
                self.extent_text()
            ),
        });
    }

    /// Returns the verdict by shares within the tolerance, and what to do next. By more than the tolerance the results differ in the share `matters`, `best` is
    /// better in the share `ahead` and worse in `behind`.
    fn verdict_by_tolerance(&self, judged: &Judged<'_>, matters: f64, [ahead, behind]: [f64; 2]) -> (Verdict, String) {
        let Judged { quantity, best, tolerance, shares, extremes, .. } = judged;
        let (best, letter) = (*best, self.aligned.letters[*best]);
        let best_share = shares.iter().copied().fold(0.0, f64::max);
        let others: Vec<String> =
            (0..shares.len()).filter(|who| *who != best).map(|who| self.aligned.letters[who].to_string()).collect();
        let any = if shares.len() > 2 { "any" } else { "either" };
        let take = format!("take {letter}, once its inputs are measured rather than assumed.");
        let has_more = self.surest(shares, [best, best]).is_some();
        let at_worst = self.best_at_worst(*quantity, extremes);
        let (state, text, next) = match (ahead, behind, at_worst) {
            _ if best_share == 0.0 => (
                State::Bad,
                "All out of tolerance everywhere".into(),
                "compensate: none is within tolerance as it is.".into(),
            ),
            (1.0, _, _) => (State::Good, format!("{letter} better by more than the tolerance"), take),
            (_, _, Some((other, _))) if has_more && other != best => {
                let other = self.aligned.letters[other];
                let next = format!("take {letter}, or {other} where the largest deviation counts.");
                (State::Partly, format!("{letter} within tolerance in more, {other} at worst"), next)
            }
            _ if has_more => {
                let next_share =
                    (0..shares.len()).filter(|who| *who != best).map(|who| shares[who]).fold(0.0, f64::max);
                let by = if shares.len() > 2 {
                    String::new()
                } else {
                    format!(", {} in {}", others[0], percent(next_share))
                };
                let state = if shares[best] == 1.0 { State::Good } else { State::Partly };
                (state, format!("{letter} within {tolerance} mm in {}{by}", percent(shares[best])), take)
            }
            (_, _, Some((who, lead))) if matters == 0.0 => {
                let who = self.aligned.letters[who];
                let next = format!("take {who}, or what is less trouble: they differ by less than the tolerance.");
                (State::Partly, format!("{who} better at its worst, by {}", percent(lead)), next)
            }
            _ if matters == 0.0 => (
                State::Open,
                "No difference that matters".into(),
                format!("take {any}: as much is within tolerance, and the worst is the same."),
            ),
            (0.0, 0.0, _) => (
                State::Partly,
                "The best differ by less than the tolerance".into(),
                format!("take {letter}, or what is as good in the picture."),
            ),
            (_, 0.0, _) => {
                (State::Partly, format!("Difference matters in {} of {}", percent(ahead), self.extent_text()), take)
            }
            _ => (
                State::Partly,
                format!(
                    "Which is better depends on {}",
                    if self.aligned.shared.shape == Shape::Names { "the method" } else { "the place" }
                ),
                format!("take {letter}, or {} where the picture has its colour.", others.join(" or ")),
            ),
        };
        (Verdict::new(state, text), next)
    }

    /// Adds the largest difference of the result `best` from the others, where no tolerance says whether it matters.
    fn add_difference(&self, quantity: usize, best: usize, headline: &mut Headline) {
        let differences = self.differences(quantity, best);
        let Some((node, by)) = differences.into_iter().max_by(|a, b| a.1.total_cmp(&b.1)) else { return };
        let is_length = self.unit(quantity) == "mm";
        let is_nothing = by <= self.floor(quantity);
        let place = || self.location(self.node_text(&self.aligned.common[0], node));
        let shown = with_unit(&if is_nothing { "0".into() } else { three_digits(by) }, self.unit(quantity));
        let what = match is_nothing {
            true => "largest difference, but for rounding".into(),
            false => format!("largest difference, {}", place()),
        };
        let against = if is_length { "no tolerance is given for the difference" } else { "" };
        headline.numbers.push(KeyNumber::new(&shown, what, against));
    }

    /// Returns the median, the 95 % quantile and the largest of how far another result is from `best`, as shares of the larger; 0 for rounding.
    fn gaps(&self, quantity: usize, best: usize) -> [f64; 3] {
        let size = |node: usize| {
            let values = self.aligned.common.iter().map(|part| part.values[quantity][0][node].abs());
            values.fold(self.floor(quantity), f64::max)
        };
        let share = |(node, gap): (usize, f64)| if gap <= self.floor(quantity) { 0.0 } else { gap / size(node) };
        let mut gaps: Vec<f64> = self.differences(quantity, best).into_iter().map(share).collect();
        gaps.sort_by(f64::total_cmp);
        let last = gaps.len().saturating_sub(1);
        [last / 2, last * 19 / 20, last].map(|index| gaps.get(index).copied().unwrap_or_default())
    }

    /// Returns by how much `best` is better than the best of the others, at each node of `differences`; negative where it is worse.
    fn leads(&self, quantity: usize, best: usize, differences: &[(usize, f64)]) -> Vec<f64> {
        let sign = self.aligned.shared.quantities[quantity].better.sign();
        let cost = |who: usize, node: usize| sign * self.aligned.common[who].values[quantity][0][node];
        let lead = |&(node, _): &(usize, f64)| {
            let others = (0..self.aligned.common.len()).filter(|who| *who != best).map(|who| cost(who, node));
            others.fold(f64::INFINITY, f64::min) - cost(best, node)
        };
        differences.iter().map(lead).collect()
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

/// The best place of each of several placements, and what they are compared by.
struct ComparedPlaces {
    objective: usize,
    /// Quantities that are lengths of which less is better.
    costs: Vec<usize>,
    /// Row of the best place of each.
    chosen: Vec<usize>,
    /// The one of `costs` by which places are judged.
    main: usize,
    /// Placements, the best first.
    order: Vec<usize>,
}

/// The first screen of compared placements: what the place found best costs in each.
impl VerdictWriter<'_> {
    /// Returns the best place of each placement; `None` if the view is not one of placements.
    fn compared_places(&self) -> Option<ComparedPlaces> {
        let shared = &self.aligned.shared;
        let objective = shared.quantities.iter().position(|q| q.label == OBJECTIVE)?;
        let is_cost = |(_, q): &(usize, &Quantity)| q.unit == "mm" && q.better == Better::Smaller;
        let costs: Vec<usize> = shared.quantities.iter().enumerate().filter(is_cost).map(|(index, _)| index).collect();
        let first = *costs.first().filter(|_| shared.shape == Shape::Names)?;
        let chosen: Vec<usize> =
            (0..self.aligned.letters.len()).map(|who| self.best_row(who, objective)).collect::<Option<_>>()?;
        let value = |who: usize, quantity: usize| self.aligned.data[who].values[quantity][0][chosen[who]];
        // With uncertain inputs places are judged by what is not exceeded, compensated if that is known.
        let is_known = |q: &&usize| (0..chosen.len()).all(|who| value(who, **q).is_finite());
        let quantiles = costs.iter().filter(|q| is_quantile(&shared.quantities[**q])).filter(is_known);
        let main =
            quantiles.max_by_key(|q| shared.quantities[**q].label.contains("compensation")).copied().unwrap_or(first);
        let mut order: Vec<usize> = (0..self.aligned.letters.len()).collect();
        order.sort_by(|a, b| value(*a, main).total_cmp(&value(*b, main)));
        Some(ComparedPlaces { objective, costs, chosen, main, order })
    }

    /// Returns the first screen for several placements, from their best places; `None` if the view is not one of placements. `is_given`
    /// says that the tolerance is not that of the studies.
    pub fn best_places(&self, is_given: bool) -> Option<FirstScreen> {
        let ComparedPlaces { objective, costs, chosen, main, order } = self.compared_places()?;
        let shared = &self.aligned.shared;
        let value = |who: usize, quantity: usize| self.aligned.data[who].values[quantity][0][chosen[who]];
        let best = order[0];
        let against = |quantity: usize| {
            let others = order[1..].iter().filter(|who| value(**who, quantity).is_finite());
            let text = others.map(|who| self.comparison(quantity, value(best, quantity), *who, value(*who, quantity)));
            text.collect::<Vec<_>>().join("; ")
        };
        let q = &shared.quantities[main];
        let shown =
            |quantity: usize| with_unit(&three_digits(value(best, quantity)), &shared.quantities[quantity].unit);
        let sentence = format!("At its best place {} has a {} of {}.", self.full_name(best), q.label, shown(main));
        let letter = self.aligned.letters[best];
        // Those without a number are last in the order, and not equal.
        let [apart, farthest] = [1, order.len() - 1].map(|place| value(order[place], main) - value(best, main));
        let labels =
            ["probability that all is within tolerance with compensation", "share of the path within tolerance"];
        let labels = &labels[usize::from(!is_quantile(&shared.quantities[main]))..];
        let within = labels.iter().find_map(|label| shared.quantities.iter().position(|q| q.label == *label));
        let is_probability = within.is_some_and(|own| shared.quantities[own].label == labels[0] && labels.len() == 2);
        // A tolerance that is given is not that of the shares.
        let by_share = within.filter(|_| !is_given);
        let share = |who: &usize| by_share.map_or(f64::NAN, |within| value(*who, within));
        let surest =
            order.iter().copied().reduce(|a, b| if share(&b) > share(&a) + 0.005 { b } else { a }).unwrap_or(best);
        let is_surer = order.iter().any(|who| share(&surest) > share(who) + 0.005);
        let surest_letter = self.aligned.letters[surest];
        let take = format!("put the workpiece where {surest_letter} is best.");
        let (state, text, next) = match self.tolerance_mm {
            _ if is_surer => {
                let state = if surest == best { State::Good } else { State::Partly };
                let text =
                    if is_probability { "surer to be within its tolerance" } else { "has more within its tolerance" };
                (state, format!("{surest_letter} {text}"), take)
            }
            _ if farthest <= self.floor(main) => {
                let next = "take either: nothing that was computed tells them apart.";
                (State::Open, "No difference but for rounding".into(), next.into())
            }
            _ if apart <= self.floor(main) => (State::Open, "The best of them are equal".into(), take),
            Some(tolerance) if apart <= tolerance => {
                let next = format!("take {letter}, or what is less trouble: the difference is below the tolerance.");
                let lead = apart / value(order[1], main).abs().max(self.floor(main));
                match lead > if is_quantile(&shared.quantities[main]) { P95_APART - 1.0 } else { ALIKE } {
                    true => (State::Partly, format!("{letter} better, by {}", percent(lead)), next),
                    false => (State::Open, "No difference that matters".into(), next),
                }
            }
            Some(_) => (State::Good, format!("{letter} better by more than the tolerance"), take),
            None => (State::Open, format!("{letter} better"), take),
        };
        let mut headline = Headline::new(sentence, "the best place of each")
            .judged(Verdict::new(state, text), false)
            .next(next)
            .with_cautions(&format!("That is {}.", against(main)));
        if self.tolerance_mm.is_none() && !is_surer {
            headline = headline.marked(NO_TOLERANCE);
        }
        let mut screen = FirstScreen { headline, ..FirstScreen::default() };
        let correction = costs.iter().copied().find(|index| shared.quantities[*index].label.contains("correction"));
        for quantity in [Some(main), correction] {
            let Some(quantity) = quantity.filter(|q| value(best, *q).is_finite()) else { continue };
            let at = self.node_text(&self.aligned.data[best], chosen[best]);
            let label = &shared.quantities[quantity].label;
            let what = format!("{label} at the best place of {} ({at})", self.aligned.letters[best]);
            screen.headline.numbers.push(KeyNumber::new(&shown(quantity), what, against(quantity)));
        }
        if let Some(within) = within.filter(|within| value(best, *within).is_finite()) {
            let share_in = |who: &usize| format!("in {} {}", self.aligned.letters[*who], percent(value(*who, within)));
            let others: Vec<String> = order[1..].iter().map(share_in).collect();
            let of = if is_probability { "probability that all is" } else { "of the path" };
            let what = format!("{of} within the tolerance of its study in {}", self.aligned.letters[best]);
            screen.headline.numbers.push(KeyNumber::new(&percent(value(best, within)), what, others.join("; ")));
        }
        for who in order {
            let objective_value = value(who, objective);
            screen.checks.extend(Check::of(self, objective, who, Rule::Min, objective_value).map(Check::own_rows));
        }
        Some(screen)
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

    /// Returns the valid row of a result with the smallest objective; `None` if no valid row has one.
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
