//! Numbers in a page: 32 bits each, or 16 where a map has so many that the page would grow large. Tables keep all digits.

use base64::{Engine, engine::general_purpose::STANDARD};
use serde::Serialize;

use crate::files::visible::shown_json;

/// Steps of the range; the code above them is a missing value.
const STEPS: f64 = 65534.0;
const MISSING: u16 = u16::MAX;
/// Most numbers of a page in single precision: 5 MB of text.
const MOST_SINGLE: usize = 900_000;

/// How many digits a page keeps of a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Precision {
    /// Single precision, 32 bits: seven digits of each number, however small.
    Single,
    /// A 65 534th of the column's range, 16 bits: for maps with very many numbers.
    Steps,
}

impl Precision {
    /// Single precision as long as the page stays small.
    pub(crate) fn for_numbers(count: usize) -> Self {
        if count <= MOST_SINGLE { Self::Single } else { Self::Steps }
    }

    /// What a reader must know of it.
    pub fn words(self) -> &'static str {
        match self {
            Self::Single => "Values here have seven digits",
            Self::Steps => "Values here are rounded to 1/65534 of their range",
        }
    }
}

/// A column of numbers as base64 of little-endian values: 32-bit floating point, NaN where there is no number, or 16-bit
/// codes for `low + code / 65534 · (high − low)`, 65535 where there is none.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Packed {
    pub low: f64,
    pub high: f64,
    pub bits: u8,
    pub codes: String,
}

impl Packed {
    /// `None` if there is no number at all.
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

/// A `data:` address of `bytes`.
pub(super) fn data_address(media_type: &str, bytes: &[u8]) -> String {
    format!("data:{media_type};base64,{}", STANDARD.encode(bytes))
}

/// JSON that may stand in a `script` element: no `<` can end it, and its strings are shown as they are written.
pub(super) fn script_json(value: &impl Serialize) -> String {
    // A struct of strings and finite numbers always serialises.
    let text = serde_json::to_string(value).unwrap_or_default();
    shown_json(&text.replace('<', "\\u003c")).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_are_within_half_a_step_of_the_numbers() {
        let values: Vec<f64> = (0..1000).map(|k| (f64::from(k) * 0.37).sin() * 1.7).chain([f64::NAN]).collect();
        let packed = Packed::new(&values, Precision::Steps).unwrap();
        let bytes = STANDARD.decode(&packed.codes).unwrap();
        for (value, pair) in values.iter().zip(bytes.chunks(2)) {
            let code = u16::from_le_bytes([pair[0], pair[1]]);
            assert_eq!(code == MISSING, value.is_nan());
            let back = packed.low + f64::from(code) / STEPS * (packed.high - packed.low);
            assert!(value.is_nan() || (back - value).abs() <= 0.51 * (packed.high - packed.low) / STEPS);
        }
        assert_eq!(Packed::new(&[f64::NAN], Precision::Steps), None);
        assert_eq!(Packed::new(&[2.0, 2.0], Precision::Steps).unwrap().codes, "AAAAAA==");
    }

    #[test]
    fn single_precision_keeps_small_numbers_beside_large_ones() {
        let values = [1.76, 9.8e-10, 4.9e-14, f64::NAN];
        let packed = Packed::new(&values, Precision::for_numbers(values.len())).unwrap();
        assert_eq!((packed.bits, packed.low, packed.high), (32, 4.9e-14, 1.76));
        let bytes = STANDARD.decode(&packed.codes).unwrap();
        for (value, four) in values.iter().zip(bytes.chunks(4)) {
            let back = f64::from(f32::from_le_bytes([four[0], four[1], four[2], four[3]]));
            assert!((back.is_nan() && value.is_nan()) || (back / value - 1.0).abs() < 1e-7, "{value}: {back}");
        }
        assert_eq!(Precision::for_numbers(MOST_SINGLE + 1), Precision::Steps);
    }

    #[test]
    fn json_cannot_end_its_script() {
        let json = script_json(&"</script><!--");
        assert_eq!(json, "\"\\u003c/script>\\u003c!--\"");
    }
}
