//! Numbers that fill an interval evenly: the sequence of Halton (Numerische Mathematik 2, 1960).

/// Radical inverse of `index` in base `prime`: its digits mirrored at the point, in [0, 1); 0 for index 0.
pub fn radical_inverse(mut index: usize, prime: usize) -> f64 {
    let (mut value, mut place) = (0.0, 1.0);
    while index > 0 {
        place /= prime as f64;
        value += place * (index % prime) as f64;
        index /= prime;
    }
    value
}
