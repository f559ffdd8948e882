//! Below which size a number is rounding: such numbers have no winner and set no axis.

use super::{dataset::Dataset, description::Explorer, table::number};
use crate::files::words::{typographic, with_unit};

/// Share of the largest size in a unit below which a number of that unit counts as nothing.
const RESOLVED: f64 = 1e-7;

/// The largest size of all compared numbers, by unit.
#[derive(Debug, Default)]
pub(super) struct Floors(Vec<(String, f64)>);

impl Floors {
    /// Takes the numbers of a view of all results into account.
    pub fn see(&mut self, explorer: &Explorer, data: &[Dataset]) {
        for (q, quantity) in explorer.quantities.iter().enumerate() {
            let sizes = data.iter().flat_map(|own| own.values[q].iter().flatten()).map(|value| value.abs());
            let most = sizes.filter(|size| size.is_finite()).fold(0.0, f64::max);
            match self.0.iter_mut().find(|(unit, _)| *unit == quantity.unit) {
                Some((_, known)) => *known = known.max(most),
                None => self.0.push((quantity.unit.clone(), most)),
            }
        }
    }

    /// What is nothing in `unit`.
    pub fn of(&self, unit: &str) -> f64 {
        self.0.iter().find(|(own, _)| own == unit).map_or(0.0, |(_, most)| RESOLVED * most)
    }

    /// The rule, for readers.
    pub fn words(&self) -> String {
        let named = self.0.iter().filter(|(unit, most)| !unit.is_empty() && *most > 0.0);
        let floors: Vec<String> = named.map(|(unit, most)| with_unit(&rounding(RESOLVED * most), unit)).collect();
        let rule = "What is smaller than a ten-millionth of the largest number compared in the same unit counts as \
                    rounding: it has no winner and sets no axis";
        if floors.is_empty() { format!("{rule}.") } else { format!("{rule} (here {}).", floors.join(", ")) }
    }
}

/// Whether two numbers are the same, but for rounding.
pub(super) fn same(a: f64, b: f64, floor: f64) -> bool {
    (a - b).abs() <= floor.max(1e-9 * a.abs().max(b.abs()))
}

/// "24 % less", "3.2 times as much" or "the same": `value` against `reference`.
pub(super) fn against(value: f64, reference: f64, floor: f64) -> String {
    let (size, other) = (value.abs(), reference.abs());
    match size / other {
        _ if same(value, reference, floor) => "the same".into(),
        _ if other <= floor || value * reference < 0.0 => "–".into(),
        _ if size <= floor => "nothing left".into(),
        ratio if ratio < 0.1 => format!("1/{} of it", short(1.0 / ratio)),
        ratio if ratio < 1.0 => format!("{} less", percent(1.0 - ratio)),
        ratio if ratio < 2.0 => format!("{} more", percent(ratio - 1.0)),
        ratio => format!("{} times as much", short(ratio)),
    }
}

/// A size below which all is rounding, as readers see it.
pub(super) fn rounding(floor: f64) -> String {
    typographic(&format!("{floor:.0e}"))
}

fn short(ratio: f64) -> String {
    if ratio < 10.0 {
        format!("{ratio:.1}")
    } else if ratio < 1e4 {
        format!("{ratio:.0}")
    } else {
        number(ratio.round())
    }
}

/// A share as readers say it: "24 %", "0.3 %", never "100 %" of what is not all.
pub(super) fn percent(share: f64) -> String {
    let percent = 100.0 * share;
    match percent {
        p if p == 0.0 || p == 100.0 => format!("{p:.0} %"),
        p if p < 0.1 => "less than 0.1 %".into(),
        p if p < 1.0 => format!("{p:.1} %"),
        p if (99.5..100.0).contains(&p) => format!("{:.1} %", p.min(99.9)),
        p => format!("{p:.0} %"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounding_is_the_same_and_differences_are_said_in_percent() {
        let floor = 1.7e-7;
        for (value, reference, expected) in [
            (2.8e-17, 5.7e-14, "the same"),
            (0.76, 1.0, "24 % less"),
            (1.03, 1.0, "3 % more"),
            (3.2, 1.0, "3.2 times as much"),
            (0.0, 1.0, "nothing left"),
            (0.001, 1.0, "1/1000 of it"),
            (1.0, 0.0, "–"),
            (1.0, -2.0, "–"),
            (0.997, 1.0, "0.3 % less"),
        ] {
            assert_eq!(against(value, reference, floor), expected);
        }
        let shown = [0.0, 0.0004, 0.93, 0.9999, 1.0].map(percent);
        assert_eq!(shown, ["0 %", "less than 0.1 %", "93 %", "99.9 %", "100 %"]);
    }
}
