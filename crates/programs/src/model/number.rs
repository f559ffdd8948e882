//! How coordinates are written: number of decimals, and no form that a controller could misread.

use thiserror::Error;

/// How many decimals written coordinates have, for each length unit.
///
/// Every coordinate that is written anew has exactly this many decimals, so it always has a decimal point: some
/// controllers read `X10` as ten micrometres. It never has an exponent, and zero never has a minus sign.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NumberFormat {
    mm: u8,
    inch: u8,
}

/// The error of [`NumberFormat::new`]: a number of decimals outside 1 to [`NumberFormat::MAX_DECIMALS`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("{decimals} decimals for coordinates in {unit}: expected 1 to {max}", max = NumberFormat::MAX_DECIMALS)]
pub struct FormatError {
    /// The unit of the coordinates: mm or inch.
    pub unit: &'static str,
    /// The number of decimals requested.
    pub decimals: u8,
}

impl NumberFormat {
    /// The most decimals a format may have.
    pub const MAX_DECIMALS: u8 = 9;

    /// Half a unit of the last decimal of the finest format, in the unit of the coordinate.
    pub(crate) const FINEST: f64 = 0.5e-9;

    /// Creates a format with `mm` decimals in metric programs and CSV files, `inch` in inch programs; fails for 0 or too many.
    pub fn new(mm: u8, inch: u8) -> Result<NumberFormat, FormatError> {
        for (unit, decimals) in [("mm", mm), ("inch", inch)] {
            if !(1..=NumberFormat::MAX_DECIMALS).contains(&decimals) {
                return Err(FormatError { unit, decimals });
            }
        }
        Ok(NumberFormat { mm, inch })
    }

    /// Creates a format with as many decimals as a source file uses, but at least 3 for mm and 4 for inch, so that a
    /// program in whole millimetres can hold a correction; at most [`NumberFormat::MAX_DECIMALS`].
    #[must_use]
    pub fn of_source(mm: usize, inch: usize) -> NumberFormat {
        let clamp =
            |seen: usize, least: u8| u8::try_from(seen).unwrap_or(u8::MAX).clamp(least, NumberFormat::MAX_DECIMALS);
        NumberFormat { mm: clamp(mm, 3), inch: clamp(inch, 4) }
    }

    /// Returns the format with no more than `decimals`, but at least those of [`NumberFormat::of_source`].
    pub(crate) fn at_most(self, decimals: usize) -> NumberFormat {
        NumberFormat::of_source(decimals.min(self.mm.into()), decimals.min(self.inch.into()))
    }

    /// Returns the number of decimals of a coordinate in mm.
    #[must_use]
    pub fn mm_decimals(self) -> u8 {
        self.mm
    }

    /// Returns the number of decimals of a coordinate in inches.
    #[must_use]
    pub fn inch_decimals(self) -> u8 {
        self.inch
    }
}

impl Default for NumberFormat {
    /// 4 decimals for mm, 5 for inch: 0.1 µm and 0.25 µm.
    fn default() -> NumberFormat {
        NumberFormat { mm: 4, inch: 5 }
    }
}

/// Formats `value` with exactly `decimals` decimals, without exponent and without a negative zero.
#[must_use]
pub fn format_fixed(value: f64, decimals: u8) -> String {
    let text = format!("{value:.*}", usize::from(decimals));
    match text.strip_prefix('-') {
        Some(digits) if digits.bytes().all(|b| matches!(b, b'0' | b'.')) => digits.to_owned(),
        _ => text,
    }
}

/// Formats `value` without trailing zeros, with at least `decimals` and at most [`NumberFormat::MAX_DECIMALS`] decimals.
pub(crate) fn format_shortest(value: f64, decimals: u8) -> String {
    let mut text = format_fixed(value, NumberFormat::MAX_DECIMALS);
    while text.ends_with('0') && decimals_in(&text) > usize::from(decimals) {
        text.pop();
    }
    text
}

/// Formats `value` without trailing zeros, and without a decimal point if it is whole.
pub(crate) fn format_plain(value: f64) -> String {
    format_shortest(value, 0).trim_end_matches('.').to_owned()
}

/// Returns the size of one unit of the last of `decimals` decimals: 10^-`decimals`.
pub(crate) fn last_place(decimals: u8) -> f64 {
    10f64.powi(-i32::from(decimals))
}

/// Counts the decimals of the number written as `text`, with a decimal point or a decimal comma.
#[must_use]
pub fn decimals_in(text: &str) -> usize {
    text.find(['.', ',']).map_or(0, |dot| text.len() - dot - 1)
}
