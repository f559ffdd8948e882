//! Half widths of 95 % intervals in standard deviations.

/// Of Student's distribution with 1, 2 and 3 degrees of freedom.
const FEW: [f64; 3] = [12.706_204_74, 4.302_652_73, 3.182_446_31];
/// Of the normal distribution.
const NORMAL: f64 = 1.959_963_985;

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

#[cfg(test)]
mod tests {
    use super::half_width;

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
