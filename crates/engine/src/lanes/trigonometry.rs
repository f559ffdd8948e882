//! Sine and cosine that are the same on every processor and in every lane.

use super::Real;

/// Coefficients of `sin x = x + x³ (S₀ + S₁ x² + …)` on |x| ≤ π/4; Sun Microsystems' fdlibm, error below 2⁻⁵⁸.
#[allow(clippy::excessive_precision)]
const SINE: [f64; 6] = [
    -1.66666666666666324348e-01,
    8.33333333332248946124e-03,
    -1.98412698298579493134e-04,
    2.75573137070700676789e-06,
    -2.50507602534068634195e-08,
    1.58969099521155010221e-10,
];

/// Coefficients of `cos x = 1 − x²/2 + x⁴ (C₀ + C₁ x² + …)` on |x| ≤ π/4, from the same source.
#[allow(clippy::excessive_precision)]
const COSINE: [f64; 6] = [
    4.16666666666666019037e-02,
    -1.38888888888741095749e-03,
    2.48015872894767294178e-05,
    -2.75573143513906633035e-07,
    2.08757232129817482790e-09,
    -1.13596475577881948265e-11,
];

/// First 33 bits of π/2.
const HALF_PI_HIGH: f64 = f64::from_bits(0x3FF9_21FB_5440_0000);
/// Rest of π/2 behind those bits.
const HALF_PI_LOW: f64 = f64::from_bits(0x3DD0_B461_1A62_6331);
/// Adding and subtracting this rounds to an integer.
const ROUNDER: f64 = 1.5 * (1u64 << 52) as f64;
/// Largest angle of which a multiple of π/2 in two parts is exact, rad.
const LARGEST: f64 = 1e5;

/// Polynomial in `x` by Horner's rule, the constant coefficient first.
#[inline(always)]
fn polynomial<R: Real>(coefficients: &[f64], x: R) -> R {
    let mut sum = R::zero();
    for (index, &coefficient) in coefficients.iter().rev().enumerate() {
        sum = if index == 0 { R::splat(coefficient) } else { sum * x + R::splat(coefficient) };
    }
    sum
}

/// Sine and cosine of `x` in rad, each within 2e-16.
#[inline(always)]
pub fn sin_cos<R: Real>(x: R) -> (R, R) {
    let size = x.abs();
    if size.lanes_greater(std::f64::consts::FRAC_PI_4) == 0 {
        return (sine(x), cosine(x));
    }
    if size.lanes_greater(LARGEST) != 0 {
        return sin_cos_by_library(x);
    }
    // x = quarter · π/2 + rest, quarter taken to −2 … 2.
    let count = (x * R::splat(std::f64::consts::FRAC_2_PI) + R::splat(ROUNDER)) - R::splat(ROUNDER);
    let rest = (x - count * R::splat(HALF_PI_HIGH)) - count * R::splat(HALF_PI_LOW);
    let turns = (count * R::splat(0.25) + R::splat(ROUNDER)) - R::splat(ROUNDER);
    let quarter = count - turns * R::splat(4.0);
    let (sin, cos) = (sine(rest), cosine(rest));
    let half = R::splat(0.5);
    let odd = half.greater((quarter.abs() - R::splat(1.0)).abs());
    let (along, across) = (R::select(odd, cos, sin), R::select(odd, sin, cos));
    // The sine is negative in quarters −1 and ±2, the cosine in 1 and ±2.
    let opposite = quarter.abs().greater(R::splat(1.5));
    let sin_sign =
        R::select(opposite, R::splat(-1.0), R::select((-half).greater(quarter), R::splat(-1.0), R::splat(1.0)));
    let cos_sign = R::select(opposite, R::splat(-1.0), R::select(quarter.greater(half), R::splat(-1.0), R::splat(1.0)));
    (along * sin_sign, across * cos_sign)
}

/// Sine and cosine, lane by lane, of angles too large for a joint: by `libm`.
#[cold]
fn sin_cos_by_library<R: Real>(x: R) -> (R, R) {
    let (mut sin, mut cos) = (x, x);
    for lane in 0..R::LANES {
        // A lane within range gets what it gets among neighbours within range.
        let angle = x.lane(lane);
        let (lane_sin, lane_cos) = if R::LANES == 1 { libm::sincos(angle) } else { sin_cos(angle) };
        sin.set_lane(lane, lane_sin);
        cos.set_lane(lane, lane_cos);
    }
    (sin, cos)
}

/// Sine of |x| ≤ π/4 rad.
#[inline(always)]
fn sine<R: Real>(x: R) -> R {
    let square = x * x;
    x + x * square * polynomial(&SINE, square)
}

/// Cosine of |x| ≤ π/4 rad.
#[inline(always)]
fn cosine<R: Real>(x: R) -> R {
    let square = x * x;
    let half = square * R::splat(0.5);
    let one = R::splat(1.0);
    let leading = one - half;
    leading + (((one - leading) - half) + square * square * polynomial(&COSINE, square))
}

/// Quotients `sin x / x` and `(1 − cos x) / x²` from `square` = x², |x| ≤ π/4.
#[inline(always)]
pub(super) fn rotation_weights<R: Real>(square: R) -> (R, R) {
    (R::splat(1.0) + square * polynomial(&SINE, square), R::splat(0.5) - square * polynomial(&COSINE, square))
}

/// Coefficients of `asin s / s` in s², on s² ≤ [`SMALL_SINE_SQUARED`]; the next one is below 2⁻⁵⁵ there.
const ARC_SINE: [f64; 9] = [
    1.0,
    1.0 / 6.0,
    3.0 / 40.0,
    5.0 / 112.0,
    35.0 / 1152.0,
    63.0 / 2816.0,
    231.0 / 13312.0,
    143.0 / 10240.0,
    6435.0 / 557_056.0,
];
/// Largest s² up to which [`arc_sine_weight`] is exact to rounding.
pub(super) const SMALL_SINE_SQUARED: f64 = 0.01;

/// Quotient `asin s / s` from `square` = s² ≤ [`SMALL_SINE_SQUARED`].
#[inline(always)]
pub(super) fn arc_sine_weight<R: Real>(square: R) -> R {
    polynomial(&ARC_SINE, square)
}
