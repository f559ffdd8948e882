//! Half widths of 95 % intervals in standard deviations, and how much scatter more than the noise chance explains.

/// Of Student's distribution with 1, 2 and 3 degrees of freedom.
const FEW: [f64; 3] = [12.706_204_74, 4.302_652_73, 3.182_446_31];
/// Of the normal distribution.
const NORMAL: f64 = 1.959_963_985;
/// Of the normal distribution, exceeded once in a hundred times.
const ONCE_IN_A_HUNDRED: f64 = 2.326_347_874;

/// Of an estimate whose standard deviation was told by `free` readings more than there are unknowns; of a known one (`None`).
pub fn half_width(free: Option<usize>) -> f64 {
    match free {
        None => NORMAL,
        Some(0) => f64::INFINITY,
        Some(few @ 1..=3) => FEW[few - 1],
        Some(free) => {
            // Cornish and Fisher's expansion.
            let (z, n) = (NORMAL, free as f64);
            let [z3, z5, z7, z9] = [3, 5, 7, 9].map(|power| z.powi(power));
            let terms = [
                (z3 + z) / 4.0,
                (5.0 * z5 + 16.0 * z3 + 3.0 * z) / 96.0,
                (3.0 * z7 + 19.0 * z5 + 17.0 * z3 - 15.0 * z) / 384.0,
                (79.0 * z9 + 776.0 * z7 + 1482.0 * z5 - 1920.0 * z3 - 945.0 * z) / 92160.0,
            ];
            terms.iter().enumerate().fold(z, |sum, (k, term)| sum + term / n.powi(k as i32 + 1))
        }
    }
}

/// What the mean square of residuals over their noise exceeds once in a hundred times, with `free` readings more than there are unknowns:
/// quantile of the F distribution with `free` and infinitely many degrees of freedom.
pub fn most_by_chance(free: usize) -> f64 {
    match free {
        0 => f64::INFINITY,
        1 => 6.634_896_60,
        2 => 4.605_170_19,
        free => {
            // Wilson and Hilferty's cube root.
            let spread = 2.0 / (9.0 * free as f64);
            (1.0 - spread + ONCE_IN_A_HUNDRED * spread.sqrt()).powi(3)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{half_width, most_by_chance};

    #[test]
    fn what_chance_explains_is_that_of_tables() {
        let table =
            [(1, 6.635), (2, 9.210), (3, 11.345), (4, 13.277), (5, 15.086), (10, 23.209), (30, 50.892), (100, 135.807)];
        for (free, expected) in table {
            let found = most_by_chance(free) * free as f64;
            assert!((found / expected - 1.0).abs() < 3e-3, "{free}: {found}");
        }
        assert_eq!(most_by_chance(0), f64::INFINITY);
    }

    #[test]
    fn quantiles_are_those_of_tables() {
        for (free, expected) in [(1, 12.706), (2, 4.303), (3, 3.182), (4, 2.776), (5, 2.571), (10, 2.228), (30, 2.042)]
        {
            assert!((half_width(Some(free)) - expected).abs() < 2e-3, "{free}: {}", half_width(Some(free)));
        }
        assert!((half_width(None) - 1.96).abs() < 1e-4);
        assert_eq!(half_width(Some(0)), f64::INFINITY);
    }
}
