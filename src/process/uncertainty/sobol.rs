//! Randomised Sobol points: evenly spread draws, in scrambles that are independent of one another.
//!
//! Direction numbers are those of Joe and Kuo (SIAM J. Sci. Comput. 30, 2008; new-joe-kuo-6.21201, its first 256 dimensions). Each scramble is a
//! random linear map of the binary digits and a random shift (Matoušek, J. Complexity 14, 1998), so that each of its points is uniform and the
//! spread of what scrambles estimate is the error of the estimate.

use rand::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

/// Dimension, degree and coefficients of its polynomial, and first direction numbers: a line for each dimension from the second.
const DIRECTION_NUMBERS: &str = include_str!("joe_kuo_6.txt");
/// Most dimensions.
pub const MAX_DIMENSIONS: usize = 256;
/// Binary digits of a coordinate: one fewer than a number in [0.5, 1) has, so that the middle between two is a number as well.
const DIGITS: usize = 52;
/// Most points of a scramble: 2 to this power.
const MAX_BITS: usize = 16;

/// Direction numbers of the dimensions 0 to `dimensions - 1`, of [`DIGITS`] digits, the first digit the most significant.
fn direction_numbers(dimensions: usize) -> Vec<[u64; MAX_BITS]> {
    let digit = |number: u64, k: usize| number << (DIGITS - 1 - k);
    let mut all = vec![std::array::from_fn(|k| digit(1, k))];
    for line in DIRECTION_NUMBERS.lines().filter(|line| !line.starts_with('#')) {
        let mut numbers = line.split_whitespace().filter_map(|word| word.parse::<u64>().ok()).skip(1);
        let (Some(degree), Some(polynomial)) = (numbers.next(), numbers.next()) else { continue };
        let (degree, first): (usize, Vec<u64>) = (degree as usize, numbers.collect());
        let mut own = [0; MAX_BITS];
        for k in 0..MAX_BITS {
            own[k] = match first.get(k) {
                Some(number) => digit(*number, k),
                None => {
                    let before = own[k - degree];
                    let inner = (1..degree).filter(|i| polynomial >> (degree - 1 - i) & 1 == 1);
                    inner.fold(before ^ (before >> degree), |number, i| number ^ own[k - i])
                }
            };
        }
        all.push(own);
    }
    all.truncate(dimensions);
    all
}

/// The number `index` of the sequence in the dimension with these `directions`, as [`DIGITS`] digits.
fn digits(directions: &[u64; MAX_BITS], index: usize) -> u64 {
    let chosen = directions.iter().enumerate().filter(|(k, _)| index >> k & 1 == 1);
    chosen.fold(0, |digits, (_, number)| digits ^ number)
}

/// Random lower triangular matrix of digits times `directions`: each digit becomes itself plus a random choice of those before it.
fn scrambled(directions: &[u64; MAX_BITS], random: &mut Xoshiro256PlusPlus) -> [u64; MAX_BITS] {
    let mut rows = [0; DIGITS];
    for (row, mask) in rows.iter_mut().enumerate() {
        let own = 1 << (DIGITS - 1 - row);
        let before = (1 << DIGITS) - 2 * own;
        *mask = own | (random.next_u64() & before);
    }
    directions.map(|number| {
        let digit = |(row, mask): (usize, &u64)| u64::from((number & mask).count_ones() % 2) << (DIGITS - 1 - row);
        rows.iter().enumerate().map(digit).sum()
    })
}

/// Points of `scrambles` independent scrambles with `points` each, in (0, 1): for each dimension all points, scramble after scramble.
///
/// The same `seed` gives the same points, and dimensions before the last do not depend on how many there are.
///
/// # Panics
/// More than [`MAX_DIMENSIONS`] dimensions, or more than 65,536 points.
pub fn points(dimensions: usize, scrambles: usize, points: usize, seed: u64) -> Vec<Vec<f64>> {
    assert!(dimensions <= MAX_DIMENSIONS && points <= 1 << MAX_BITS, "{dimensions} dimensions, {points} points");
    let in_dimension = |(dimension, directions): (usize, [u64; MAX_BITS])| -> Vec<f64> {
        let of_scramble = |scramble: usize| {
            // Each dimension of each scramble has random numbers of its own.
            let own = seed.wrapping_add((dimension as u64) << 32).wrapping_add((scramble as u64) << 48);
            let mut random = Xoshiro256PlusPlus::seed_from_u64(own);
            let directions = scrambled(&directions, &mut random);
            let shift = random.next_u64() >> (64 - DIGITS);
            let in_unit = |index| ((digits(&directions, index) ^ shift) as f64 + 0.5) / (1u64 << DIGITS) as f64;
            (0..points).map(in_unit).collect::<Vec<f64>>()
        };
        (0..scrambles).flat_map(of_scramble).collect()
    };
    direction_numbers(dimensions).into_iter().enumerate().map(in_dimension).collect()
}
