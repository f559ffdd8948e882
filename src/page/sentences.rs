//! The sentences of a comparison's first screen.

use super::{
    dataset::Dataset,
    description::{Better, Shape},
    table::number,
    verdict::Compares,
    winners::{Extremes, Winners, against, percent, rounding},
};
use crate::files::words::{position, typographic, with_unit};

impl Compares<'_> {
    pub(super) fn unit(&self, quantity: usize) -> &str {
        &self.aligned.shared.quantities[quantity].unit
    }

    pub(super) fn floor(&self, quantity: usize) -> f64 {
        self.aligned.floors[quantity]
    }

    /// "B (delta_3puu)".
    pub(super) fn named(&self, who: usize) -> String {
        match self.names.get(who) {
            Some(name) if !name.is_empty() => format!("{} ({name})", self.aligned.letters[who]),
            _ => self.aligned.letters[who].to_string(),
        }
    }

    pub(super) fn extent(&self) -> String {
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

    /// "the tool of B moves less", "B has the smaller superposition error".
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

    pub(super) fn who_of_two(&self, quantity: usize, winners: &Winners) -> String {
        let order = winners.order();
        let (first, second, extent) = (order[0], order[1], self.extent());
        let Some(typical) = winners.typical(first) else {
            let (floor, unit) = (self.floor(quantity), self.unit(quantity));
            return format!(
                "{} and {} are the same: their {} differs nowhere by more than {}.",
                self.named(0),
                self.named(1),
                self.aligned.shared.quantities[quantity].label,
                with_unit(&rounding(floor), unit)
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
                self.at(self.place(&self.aligned.parts[0], node))
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

    pub(super) fn who_of_several(&self, quantity: usize, winners: &Winners) -> String {
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

    pub(super) fn by_worst(&self, quantity: usize, best: usize, extremes: &[Extremes]) -> String {
        let q = &self.aligned.shared.quantities[quantity];
        let of = |who: usize| self.worst(quantity, &extremes[who]).0;
        let others: Vec<String> = (0..extremes.len())
            .filter(|who| *who != best)
            .map(|who| self.than(quantity, of(best), who, of(who)))
            .collect();
        let which = if q.better == Better::Larger { "smallest" } else { "largest" };
        format!(
            "The {which} {} of {} is {}: {}.",
            bare(&q.label),
            self.named(best),
            with_unit(&three(of(best)), &q.unit),
            others.join(", ")
        )
    }

    /// "24 % less than in A (1.71 mm)".
    pub(super) fn than(&self, quantity: usize, value: f64, other: usize, reference: f64) -> String {
        let letter = self.aligned.letters[other];
        let shown = with_unit(&three(reference), self.unit(quantity));
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
    pub(super) fn at(&self, place: String) -> String {
        match self.aligned.shared.shape {
            Shape::Grid => format!("at {place}"),
            Shape::Curve => place,
            Shape::Names => format!("with {place}"),
        }
    }

    pub(super) fn place(&self, data: &Dataset, node: usize) -> String {
        let coordinates = &self.aligned.shared.coordinates;
        let is_position = coordinates.len() == 3 && coordinates.iter().all(|c| c.unit == "mm");
        match data.position(node) {
            Some(at) if is_position && at.len() == 3 => position(at[0], at[1], at[2]),
            Some(at) if at.len() == 1 => {
                let column = &coordinates[0];
                let along = column.label.replace("length along", "along");
                format!("{} {along}", with_unit(&three(at[0]), &column.unit))
            }
            _ => data.place(&self.aligned.shared, node),
        }
    }
}

/// A quantity without the "worst" or "largest" that it is itself over something else.
pub(super) fn bare(label: &str) -> &str {
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
    typographic(&format!("{value:.*}", digits as usize))
}
