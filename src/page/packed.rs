//! Numbers stored compactly in a page: 32 bits each, or 16 where there are very many. Tables keep all digits.

use base64::{Engine, engine::general_purpose::STANDARD};
use serde::Serialize;

use crate::files::visible::display_json;

/// Steps of the range in 16 bits; the code above them is a missing value.
const STEPS: f64 = 65534.0;
const MISSING: u16 = u16::MAX;
/// Most numbers of a page in single precision: 5 MB of text.
const MAX_SINGLE: usize = 900_000;

/// Precision of the numbers in a page.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Precision {
    /// Single precision, 32 bits: seven digits of each number, however small.
    Single,
    /// A 65 534th of the column's range, 16 bits: for maps with very many numbers.
    Steps,
}

impl Precision {
    /// Returns single precision for a count that keeps the page small, and steps for more.
    pub fn for_numbers(count: usize) -> Self {
        if count <= MAX_SINGLE { Self::Single } else { Self::Steps }
    }

    /// Returns the words that tell a reader about the precision.
    pub fn text(self) -> &'static str {
        match self {
            Self::Single => "Values in this view have seven digits",
            Self::Steps => "Values in this view are rounded to 1/65534 of the difference of largest and smallest",
        }
    }
}

/// A column of numbers as base64 of little-endian values: 32-bit floating point, NaN where there is no number, or 16-bit
/// codes for `low + code / 65534 · (high − low)`, 65535 where there is none.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Packed {
    /// Smallest number.
    pub low: f64,
    /// Largest number.
    pub high: f64,
    /// Bits of each value: 32 or 16.
    pub bits: u8,
    /// Encoded values.
    pub codes: String,
}

impl Packed {
    /// Packs `values`; `None` if none of them is a finite number.
    pub fn new(values: &[f64], precision: Precision) -> Option<Self> {
        let known = || values.iter().copied().filter(|value| value.is_finite());
        let low = known().reduce(f64::min)?;
        let high = known().reduce(f64::max)?;
        let code = |value: &f64| match value.is_finite() {
            true if high > low => ((value - low) / (high - low) * STEPS).round() as u16,
            true => 0,
            false => MISSING,
        };
        let (bits, bytes): (u8, Vec<u8>) = match precision {
            Precision::Single => (32, values.iter().flat_map(|value| (*value as f32).to_le_bytes()).collect()),
            Precision::Steps => (16, values.iter().flat_map(|value| code(value).to_le_bytes()).collect()),
        };
        Some(Self { low, high, bits, codes: STANDARD.encode(bytes) })
    }
}

/// Returns `bytes` as a `data:` URL.
pub(super) fn data_url(media_type: &str, bytes: &[u8]) -> String {
    format!("data:{media_type};base64,{}", STANDARD.encode(bytes))
}

/// Returns JSON for a `script` element: no `<` can end the element, and characters that would act in texts are written out.
pub(super) fn script_json(value: &impl Serialize) -> String {
    // A struct of strings and finite numbers always serialises.
    let text = serde_json::to_string(value).unwrap_or_default();
    display_json(&text.replace('<', "\\u003c")).into_owned()
}
