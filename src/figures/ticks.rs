//! Which numbers an axis or a colour bar shows, and how they are written.

/// Marked numbers of an axis.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Ticks {
    pub values: Vec<f64>,
    pub labels: Vec<String>,
    /// Unlabelled subdivisions.
    pub minor: Vec<f64>,
    /// The labels are the values divided by 10 to this power.
    pub exponent: i32,
}

/// More decimals than this move a power of ten into the axis label.
const MOST_DECIMALS: i32 = 4;
/// Numbers from here on move a power of ten into the axis label.
const LARGE: f64 = 1e5;

/// `low..high`, widened by 10 % of its magnitude (or by 1 around zero) if it is too narrow to carry a scale.
pub(super) fn widened(low: f64, high: f64) -> (f64, f64) {
    let magnitude = low.abs().max(high.abs());
    if high - low > 1e-9 * magnitude && high - low > 1e-100 {
        return (low, high);
    }
    let half = if magnitude > 1e-100 { 0.1 * magnitude } else { 1.0 };
    (low - half, high + half)
}

/// At most about `target` ticks at steps of 1, 2 or 5 times a power of ten within `low..high` (`low < high`).
pub(super) fn linear(low: f64, high: f64, target: usize) -> Ticks {
    stepped(low, high, nice_step((high - low) / target.max(1) as f64))
}

/// As [`linear`] for angles in degrees: over more than an eighth of a turn at steps that divide a right angle, or at right
/// angles and their multiples.
pub(super) fn degrees(low: f64, high: f64, target: usize) -> Ticks {
    let raw = (high - low) / target.max(1) as f64;
    match [10.0, 15.0, 30.0, 45.0, 90.0, 180.0, 360.0].into_iter().find(|step| *step >= raw) {
        Some(step) if high - low > 45.0 => stepped(low, high, step),
        _ => linear(low, high, target),
    }
}

/// Ticks at the multiples of `step`.
fn stepped(low: f64, high: f64, step: f64) -> Ticks {
    let first = (low / step - 1e-9).ceil() as i64;
    let last = (high / step + 1e-9).floor() as i64;
    let values: Vec<f64> = (first..=last).map(|k| k as f64 * step).collect();
    let largest = values.iter().fold(0.0_f64, |a, v| a.max(v.abs()));
    let decimals = -(step.log10() + 1e-9).floor() as i32;
    let exponent = if largest > 0.0 && (decimals > MOST_DECIMALS || largest >= LARGE) {
        3 * (largest.log10() / 3.0).floor() as i32
    } else {
        0
    };
    let decimals = (decimals + exponent).max(0) as usize;
    let labels = values.iter().map(|v| number(v / 10_f64.powi(exponent), decimals)).collect();
    Ticks { values, labels, minor: Vec::new(), exponent }
}

/// The smallest 1, 2 or 5 times a power of ten that is not below `raw`.
fn nice_step(raw: f64) -> f64 {
    let power = 10_f64.powi(raw.log10().floor() as i32);
    let factor = [1.0, 2.0, 5.0].into_iter().find(|f| f * power >= raw * (1.0 - 1e-9)).unwrap_or(10.0);
    factor * power
}

/// At most about `target` ticks at powers of ten within `low..high` (both positive); below two decades at 1, 2 and 5
/// times a power of ten, and below that at even steps.
pub(super) fn logarithmic(low: f64, high: f64, target: usize) -> Ticks {
    let first = (low.log10() - 1e-9).ceil() as i32;
    let last = (high.log10() + 1e-9).floor() as i32;
    let between = multiples(low, high, &[2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0]);
    if last - first >= 1 {
        let stride = ((last - first) as usize / target.max(1) + 1) as i32;
        let (powers, others): (Vec<i32>, Vec<i32>) = (first..=last).partition(|k| k.rem_euclid(stride) == 0);
        let decades = |powers: &[i32]| powers.iter().map(|k| 10_f64.powi(*k)).collect();
        let minor = if stride == 1 { between } else { decades(&others) };
        let labels = powers.iter().map(|k| power_of_ten(*k)).collect();
        return Ticks { values: decades(&powers), labels, minor, exponent: 0 };
    }
    let values = multiples(low, high, &[1.0, 2.0, 5.0]);
    if values.len() < 2 {
        return linear(low, high, target);
    }
    let labels = values.iter().map(|v| number(*v, (-v.log10().floor()).max(0.0) as usize)).collect();
    Ticks { values, labels, minor: between, exponent: 0 }
}

fn multiples(low: f64, high: f64, factors: &[f64]) -> Vec<f64> {
    let decades = low.log10().floor() as i32..=high.log10().floor() as i32;
    let all = decades.flat_map(|k| factors.iter().map(move |f| f * 10_f64.powi(k)));
    all.filter(|v| (low * (1.0 - 1e-9)..=high * (1.0 + 1e-9)).contains(v)).collect()
}

/// A number with a true minus sign and never a negative zero.
fn number(value: f64, decimals: usize) -> String {
    let digits = format!("{:.decimals$}", value.abs());
    let zero = digits.bytes().all(|b| b == b'0' || b == b'.');
    if value < 0.0 && !zero { format!("\u{2212}{digits}") } else { digits }
}

/// "10⁻³" and the like.
pub(super) fn power_of_ten(exponent: i32) -> String {
    let raise = |character: char| match character {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        digit => char::from_u32('⁰' as u32 + digit.to_digit(10).unwrap_or(0)).unwrap_or(digit),
    };
    format!("10{}", exponent.to_string().chars().map(raise).collect::<String>())
}

/// The axis label with the power of ten put before the unit: `error [mm]` becomes `error [10⁻³ mm]`.
pub(super) fn label_with_power(label: &str, exponent: i32) -> String {
    if exponent == 0 {
        return label.to_owned();
    }
    let power = power_of_ten(exponent);
    match label.rsplit_once('[') {
        Some((name, unit)) => format!("{name}[{power} {unit}"),
        None => format!("{label} [{power}]"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_numbers_inside_the_range() {
        let ticks = linear(-73.65, 126.35, 5);
        assert_eq!(ticks.labels, ["\u{2212}50", "0", "50", "100"]);
        assert_eq!(linear(0.0, 1.0, 5).labels, ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
    }

    #[test]
    fn angles_over_a_turn_are_marked_at_right_angles_or_their_halves() {
        assert_eq!(degrees(-14.4, 374.4, 7).labels, ["0", "90", "180", "270", "360"]);
        assert_eq!(degrees(0.0, 360.0, 8).values.len(), 9);
    }

    #[test]
    fn small_and_large_numbers_move_their_power_of_ten_to_the_label() {
        let ticks = linear(0.0, 1.2e-5, 4);
        assert_eq!(ticks.exponent, -6);
        assert_eq!(ticks.labels, ["0", "5", "10"]);
        assert_eq!(label_with_power("error [mm]", -6), "error [10⁻⁶ mm]");
        assert_eq!(linear(0.0, 3e6, 3).labels, ["0", "1", "2", "3"]);
    }

    #[test]
    fn logarithmic_ticks_are_decades_thinned_to_the_target() {
        assert_eq!(logarithmic(0.05, 2000.0, 10).labels, ["10⁻¹", "10⁰", "10¹", "10²", "10³"]);
        assert!(logarithmic(1e-30, 1e30, 6).labels.len() <= 8);
        assert_eq!(logarithmic(1.5, 7.0, 6).labels, ["2", "5"]);
    }

    #[test]
    fn a_constant_is_widened_and_still_has_ticks() {
        for value in [0.0, 1.0, -1e-60, 1e90, 1e6 + 0.1] {
            let (low, high) = widened(value, value);
            assert!(low < value && value < high);
            assert!(linear(low, high, 5).values.len() >= 2, "{value}");
        }
    }
}
