//! Numbers in a page: 16 bits each, so that 50 000 points of a map stay small. Tables keep all digits.

use base64::{Engine, engine::general_purpose::STANDARD};
use serde::Serialize;

/// Steps of the range; the code above them is a missing value.
const STEPS: f64 = 65534.0;
const MISSING: u16 = u16::MAX;

/// A column of numbers: `low + code / 65534 · (high − low)`, codes as base64 of 16-bit little-endian integers, 65535 where
/// there is no number.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Packed {
    pub low: f64,
    pub high: f64,
    pub codes: String,
}

impl Packed {
    /// `None` if there is no number at all.
    pub fn new(values: &[f64]) -> Option<Self> {
        let known = || values.iter().copied().filter(|value| value.is_finite());
        let low = known().reduce(f64::min)?;
        let high = known().reduce(f64::max)?;
        let code = |value: &f64| match value.is_finite() {
            true if high > low => ((value - low) / (high - low) * STEPS).round() as u16,
            true => 0,
            false => MISSING,
        };
        let bytes: Vec<u8> = values.iter().flat_map(|value| code(value).to_le_bytes()).collect();
        Some(Self { low, high, codes: STANDARD.encode(bytes) })
    }
}

/// A `data:` address of `bytes`.
pub(super) fn data_address(media_type: &str, bytes: &[u8]) -> String {
    format!("data:{media_type};base64,{}", STANDARD.encode(bytes))
}

/// JSON that may stand in a `script` element: no `<` can end it.
pub(super) fn script_json(value: &impl Serialize) -> String {
    // A struct of strings and finite numbers always serialises.
    let text = serde_json::to_string(value).unwrap_or_default();
    text.replace('<', "\\u003c").replace('\u{2028}', "\\u2028").replace('\u{2029}', "\\u2029")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_are_within_half_a_step_of_the_numbers() {
        let values: Vec<f64> = (0..1000).map(|k| (f64::from(k) * 0.37).sin() * 1.7).chain([f64::NAN]).collect();
        let packed = Packed::new(&values).unwrap();
        let bytes = STANDARD.decode(&packed.codes).unwrap();
        for (value, pair) in values.iter().zip(bytes.chunks(2)) {
            let code = u16::from_le_bytes([pair[0], pair[1]]);
            assert_eq!(code == MISSING, value.is_nan());
            let back = packed.low + f64::from(code) / STEPS * (packed.high - packed.low);
            assert!(value.is_nan() || (back - value).abs() <= 0.51 * (packed.high - packed.low) / STEPS);
        }
        assert_eq!(Packed::new(&[f64::NAN]), None);
        assert_eq!(Packed::new(&[2.0, 2.0]).unwrap().codes, "AAAAAA==");
    }

    #[test]
    fn json_cannot_end_its_script() {
        let json = script_json(&"</script><!--");
        assert_eq!(json, "\"\\u003c/script>\\u003c!--\"");
    }
}
