//! How coordinates are written: how many decimals, and nothing a controller could misread.

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

/// A [`NumberFormat`] asked for with decimals no controller has.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("{decimals} decimals for coordinates in {unit}: expected 1 to {max}", max = NumberFormat::MAX_DECIMALS)]
pub struct FormatError {
    /// The unit it was asked for.
    pub unit: &'static str,
    /// The number asked for.
    pub decimals: u8,
}

impl NumberFormat {
    /// The most decimals a format may have.
    pub const MAX_DECIMALS: u8 = 9;

    /// Half of the last place that any format has.
    pub(crate) const FINEST: f64 = 0.5e-9;

    /// `mm` decimals in metric programs and CSV files, `inch` decimals in inch programs.
    ///
    /// # Errors
    /// When either is 0 or above [`NumberFormat::MAX_DECIMALS`].
    pub fn new(mm: u8, inch: u8) -> Result<NumberFormat, FormatError> {
        for (unit, decimals) in [("mm", mm), ("inch", inch)] {
            if !(1..=NumberFormat::MAX_DECIMALS).contains(&decimals) {
                return Err(FormatError { unit, decimals });
            }
        }
        Ok(NumberFormat { mm, inch })
    }

    /// The most decimals seen in a file, but never fewer than 3 for mm and 4 for inch: a program in whole
    /// millimetres could otherwise not hold a correction.
    #[must_use]
    pub fn seen(mm: usize, inch: usize) -> NumberFormat {
        let clamp =
            |seen: usize, least: u8| u8::try_from(seen).unwrap_or(u8::MAX).clamp(least, NumberFormat::MAX_DECIMALS);
        NumberFormat { mm: clamp(mm, 3), inch: clamp(inch, 4) }
    }

    /// Decimals of a coordinate in mm.
    #[must_use]
    pub fn mm_decimals(self) -> u8 {
        self.mm
    }

    /// Decimals of a coordinate in inches.
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

/// `value` with exactly `decimals` decimals, without exponent and without a negative zero.
#[must_use]
pub fn fixed(value: f64, decimals: u8) -> String {
    let text = format!("{value:.*}", usize::from(decimals));
    match text.strip_prefix('-') {
        Some(digits) if digits.bytes().all(|b| matches!(b, b'0' | b'.')) => digits.to_owned(),
        _ => text,
    }
}

/// `value` with as many decimals as it takes, `decimals` at least.
pub(crate) fn shortest(value: f64, decimals: u8) -> String {
    let mut text = fixed(value, NumberFormat::MAX_DECIMALS);
    while text.ends_with('0') && decimals_in(&text) > usize::from(decimals) {
        text.pop();
    }
    text
}

/// `value` with as many decimals as it takes, and no point without any.
pub(crate) fn plain(value: f64) -> String {
    shortest(value, 0).trim_end_matches('.').to_owned()
}

/// The size of one unit of the last of `decimals` decimals.
pub(crate) fn last_place(decimals: u8) -> f64 {
    10f64.powi(-i32::from(decimals))
}

/// How many decimals the number written as `text` has, with a point or a comma.
#[must_use]
pub fn decimals_in(text: &str) -> usize {
    text.find(['.', ',']).map_or(0, |dot| text.len() - dot - 1)
}
