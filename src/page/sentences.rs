//! Sentences of the first screen of a comparison.

use super::{
    dataset::Dataset,
    description::{Better, Shape},
    table::format_number,
    verdict::VerdictWriter,
    winners::{Extremes, Winners, difference_text, format_floor, percent},
};
use crate::files::words::{position, typographic, with_unit};

impl VerdictWriter<'_> {
    /// Returns the unit of a quantity.
    pub(super) fn unit(&self, quantity: usize) -> &str {
        &self.aligned.shared.quantities[quantity].unit
    }

    /// Returns the size below which a quantity counts as rounding.
    pub(super) fn floor(&self, quantity: usize) -> f64 {
        self.aligned.floors[quantity]
    }

    /// Returns letter and name of a result, such as "B (delta_3puu)".
    pub(super) fn full_name(&self, who: usize) -> String {
        match self.names.get(who) {
            Some(name) if !name.is_empty() => format!("{} ({name})", self.aligned.letters[who]),
            _ => self.aligned.letters[who].to_string(),
        }
    }

    /// Returns the name of what is compared as a whole: "the workspace", "the path", "the methods".
    pub(super) fn extent_text(&self) -> String {
        match self.aligned.shared.shape {
            Shape::Grid if self.aligned.node_noun() == "grid point" => "the workspace".into(),
            Shape::Curve => "the path".into(),
            Shape::Grid | Shape::Names => format!("the {}s", self.aligned.node_noun()),
        }
    }

    /// Returns whether a quantity is a motion of the tool: then a smaller value means that the tool moves less.
    fn is_motion(&self, quantity: usize) -> bool {
        let label = &self.aligned.shared.quantities[quantity].label;
        label.contains("deflection") || label.contains("displacement")
    }

    /// Returns "the tool of B moves less" or "B has the smaller superposition error", in the superlative unless `of_two`.
    fn better_clause(&self, quantity: usize, who: usize, of_two: bool) -> String {
        let q = &self.aligned.shared.quantities[quantity];
        let name = self.full_name(who);
        let (less, smaller, larger) =
            if of_two { ("less", "smaller", "larger") } else { ("least", "smallest", "largest") };
        match q.better {
            _ if self.is_motion(quantity) => format!("The tool of {name} moves {less}"),
            Better::Larger => format!("{name} has the {larger} {}", q.label),
            _ => format!("{name} has the {smaller} {}", q.label),
        }
    }

    /// Returns the words for another result: "that of B" for a motion, else its name.
    fn other_in_text(&self, quantity: usize, who: usize) -> String {
        if self.is_motion(quantity) { format!("that of {}", self.full_name(who)) } else { self.full_name(who) }
    }

    /// Returns a sentence on which of two results is better, in how much of the workspace or path, and one on by how much.
    pub(super) fn best_of_two(&self, quantity: usize, winners: &Winners) -> [String; 2] {
        let order = winners.order_by_wins();
        let (first, second, extent) = (order[0], order[1], self.extent_text());
        let Some(typical_lead) = winners.typical_lead(first) else {
            let (floor, unit) = (self.floor(quantity), self.unit(quantity));
            let label = &self.aligned.shared.quantities[quantity].label;
            let most = with_unit(&format_floor(floor), unit);
            return [
                format!("{} and {} are the same but for rounding.", self.full_name(0), self.full_name(1)),
                format!("Their {label} differs nowhere by more than {most}."),
            ];
        };
        let better = self.better_clause(quantity, first, true);
        let (by, name) = (format!("typically by {}", percent(typical_lead)), self.aligned.letters[first]);
        if let Some(node) = winners.largest_lead_node(second) {
            let only = if winners.win_share(second) < 0.2 { "only in" } else { "in" };
            let place = self.location(self.node_text(&self.aligned.common[0], node));
            let other = self.full_name(second);
            return [
                format!("{better} in {} of {extent}.", percent(winners.win_share(first))),
                format!(
                    "Where {name} leads, it does {by}; {other} leads {only} {}, most of all {place}.",
                    percent(winners.win_share(second))
                ),
            ];
        }
        match winners.same_share() {
            0.0 if extent == "the methods" => [format!("{better} with every method, {by}."), String::new()],
            0.0 => [format!("{better} everywhere, {by}."), String::new()],
            share => [
                format!("{better} in {} of {extent}.", percent(winners.win_share(first))),
                format!("Where {name} leads, it does {by}; in the other {} they are equal.", percent(share)),
            ],
        }
    }

    /// Returns a sentence on which of several results is best, in how much of the workspace or path, and one on by how much.
    pub(super) fn best_of_several(&self, quantity: usize, winners: &Winners) -> [String; 2] {
        let order = winners.order_by_wins();
        let Some(typical_lead) = winners.typical_lead(order[0]) else {
            let none =
                format!("Nowhere in {} is one of the {} better than all others.", self.extent_text(), order.len());
            return [none, String::new()];
        };
        let others = order[1..].iter().map(|who| {
            let other = self.other_in_text(quantity, *who);
            match winners.win_share(*who) {
                0.0 => format!("{other} nowhere"),
                share => format!("{other} in {}", percent(share)),
            }
        });
        let share = match winners.win_share(order[0]) {
            1.0 => "everywhere".into(),
            share => format!("in {} of {}", percent(share), self.extent_text()),
        };
        let better = self.better_clause(quantity, order[0], false);
        let less = if self.aligned.shared.quantities[quantity].better == Better::Larger { "more" } else { "less" };
        let by = format!("Typically {} {less} than the next best", percent(typical_lead));
        [format!("{better} {share}."), format!("{by}; {}.", others.collect::<Vec<_>>().join(", "))]
    }

    /// Returns a sentence on the worst value of the result `best`, and one on by how much it is better than those of the others.
    pub(super) fn worst_case(&self, quantity: usize, best: usize, extremes: &[Extremes]) -> [String; 2] {
        let q = &self.aligned.shared.quantities[quantity];
        let worst_of = |who: usize| extremes[who].worst_and_best(q.better)[0].0;
        let others: Vec<String> = (0..extremes.len())
            .filter(|who| *who != best)
            .map(|who| self.comparison(quantity, worst_of(best), who, worst_of(who)))
            .collect();
        let which = if q.better == Better::Larger { "smallest" } else { "largest" };
        let (label, name) = (without_extreme_word(&q.label), self.full_name(best));
        let value = with_unit(&three_digits(worst_of(best)), &q.unit);
        [format!("The {which} {label} of {name} is {value}."), format!("That is {}.", others.join(", "))]
    }

    /// Returns `value` compared with the value `reference` of another result: "24 % less than in A (1.71 mm)".
    pub(super) fn comparison(&self, quantity: usize, value: f64, other: usize, reference: f64) -> String {
        let letter = self.aligned.letters[other];
        let shown = with_unit(&three_digits(reference), self.unit(quantity));
        match difference_text(value, reference, self.floor(quantity)) {
            text if text == "the same" => format!("the same as in {letter}"),
            text if text.ends_with("less") || text.ends_with("more") => {
                format!("{text} than in {letter} ({shown})")
            }
            text if text.ends_with("as much") => format!("{text} as in {letter} ({shown})"),
            text if text.ends_with("of it") => {
                format!("{}of the {shown} in {letter}", text.trim_end_matches("of it"))
            }
            _ => format!("in {letter} {shown}"),
        }
    }

    /// Returns a node with its preposition: "at (1, 2, 3) mm", "53.2 mm along the path", "with newton".
    pub(super) fn location(&self, place: String) -> String {
        match self.aligned.shared.shape {
            Shape::Grid => format!("at {place}"),
            Shape::Curve => place,
            Shape::Names => format!("with {place}"),
        }
    }

    /// Returns a node of `data` in words: its position, its length along the path, or its name.
    pub(super) fn node_text(&self, data: &Dataset, node: usize) -> String {
        let coordinates = &self.aligned.shared.coordinates;
        let is_position = coordinates.len() == 3 && coordinates.iter().all(|c| c.unit == "mm");
        match data.position(node) {
            Some(at) if is_position && at.len() == 3 => position(at[0], at[1], at[2]),
            Some(at) if at.len() == 1 => {
                let column = &coordinates[0];
                let along = column.label.replace("length along", "along");
                format!("{} {along}", with_unit(&three_digits(at[0]), &column.unit))
            }
            _ => data.node_label(&self.aligned.shared, node),
        }
    }
}

/// Returns a label without a leading "worst", "largest" or "smallest".
pub(super) fn without_extreme_word(label: &str) -> &str {
    ["worst ", "largest ", "smallest "].iter().find_map(|word| label.strip_prefix(word)).unwrap_or(label)
}

/// Returns a number as text with three significant digits, as large numbers are read.
pub(super) fn three_digits(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return format_number(value);
    }
    let digits = (2.0 - libm::log10(value.abs()).floor()).max(0.0);
    if digits > 7.0 {
        return format_number(value);
    }
    typographic(&format!("{value:.*}", digits as usize))
}
