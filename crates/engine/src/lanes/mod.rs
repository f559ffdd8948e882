//! Numbers, one or several at a time.
//!
//! Solving a machine takes the same operations at every point, so a vector register can hold the same number of 4 or 8
//! points: its *lanes*. What is written once over [`Real`] is compiled for `f64` and for each kind of register; which of
//! them runs is decided when the program runs, by what the processor has ([`Level`]).
//!
//! Only operations that IEEE 754 rounds one way are used (no fused multiply-add, no approximations, sine and cosine of
//! our own), so a lane computes the same bits as `f64` does, on any processor.

#[cfg(test)]
mod counted;
mod linear;
mod operators;
mod tape;
mod traced;
mod trigonometry;
mod vector;
#[cfg(target_arch = "x86_64")]
mod x86;

use std::{
    fmt::Debug,
    ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign},
};

#[cfg(test)]
pub(crate) use counted::{Counted, take_counts};
pub(crate) use linear::{clear, copy, dot, pairs, solve, subtract};
pub use tape::{Operation, Place, Program};
pub use traced::{Traced, TracedMask, record};
pub(crate) use trigonometry::sin_cos;
pub(crate) use vector::{Frame, Screw, Vec3, rotation_exp, rotation_log};
#[cfg(target_arch = "x86_64")]
pub(crate) use x86::{F64x4, F64x8};

/// Most lanes of any type; masks have one bit per lane.
pub const MAX_LANES: usize = 8;

/// A number, or one number per lane.
///
/// All operations act lane by lane. Functions over this trait that are worth vector instructions are marked
/// `#[inline(always)]` and called from within [`Real::vectorized`], so that they are compiled with them.
pub trait Real:
    Copy
    + Debug
    + 'static
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
{
    /// Number of lanes.
    const LANES: usize;
    /// Bits of all lanes.
    const ALL: u8 = u8::MAX >> (MAX_LANES - Self::LANES);
    /// Truth, lane by lane.
    type Mask: Copy;

    /// The same number in all lanes.
    fn splat(value: f64) -> Self;
    /// Number in `lane`.
    fn lane(self, lane: usize) -> f64;
    /// Replaces the number in `lane`.
    fn set_lane(&mut self, lane: usize, value: f64);
    /// Square root.
    fn sqrt(self) -> Self;
    /// Size without sign.
    fn abs(self) -> Self;
    /// Whether `self > other`; false where either is NaN.
    fn greater(self, other: Self) -> Self::Mask;
    /// Whether it is NaN.
    fn is_nan(self) -> Self::Mask;
    /// Where `mask` holds `yes`, elsewhere `no`.
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self;
    /// A bit per lane, lane 0 lowest.
    fn bits(mask: Self::Mask) -> u8;
    /// From a bit per lane.
    fn mask(bits: u8) -> Self::Mask;
    /// Whether all lanes hold zero.
    fn is_zero(self) -> bool;

    /// Runs `work` compiled with the instructions of this type.
    #[inline(always)]
    fn vectorized<T>(work: impl FnOnce() -> T) -> T {
        work()
    }

    /// Zero.
    #[inline(always)]
    fn zero() -> Self {
        Self::splat(0.0)
    }

    /// Lanes in which `self > other`.
    #[inline(always)]
    fn lanes_greater(self, other: f64) -> u8 {
        Self::bits(self.greater(Self::splat(other)))
    }

    /// The larger of two sizes; NaN where either is, see [`crate::spatial::larger`].
    #[inline(always)]
    fn larger(self, other: Self) -> Self {
        Self::select(self.is_nan(), self, Self::select(self.greater(other), self, other))
    }
}

impl Real for f64 {
    const LANES: usize = 1;
    type Mask = bool;

    #[inline(always)]
    fn splat(value: f64) -> Self {
        value
    }

    #[inline(always)]
    fn lane(self, _lane: usize) -> f64 {
        self
    }

    #[inline(always)]
    fn set_lane(&mut self, _lane: usize, value: f64) {
        *self = value;
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        f64::sqrt(self)
    }

    #[inline(always)]
    fn abs(self) -> Self {
        f64::abs(self)
    }

    #[inline(always)]
    fn greater(self, other: Self) -> bool {
        self > other
    }

    #[inline(always)]
    fn is_nan(self) -> bool {
        f64::is_nan(self)
    }

    #[inline(always)]
    fn select(mask: bool, yes: Self, no: Self) -> Self {
        if mask { yes } else { no }
    }

    #[inline(always)]
    fn is_zero(self) -> bool {
        self == 0.0
    }

    #[inline(always)]
    fn bits(mask: bool) -> u8 {
        u8::from(mask)
    }

    #[inline(always)]
    fn mask(bits: u8) -> bool {
        bits & 1 == 1
    }
}

/// How many points are computed at a time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Level {
    /// One, on any processor.
    One,
    /// Four, with AVX2.
    Four,
    /// Eight, with AVX-512.
    Eight,
}

impl Level {
    /// Levels of this processor, ascending.
    pub fn available() -> Vec<Level> {
        [Level::One, Level::Four, Level::Eight].into_iter().filter(|level| level.is_available()).collect()
    }

    /// The highest level of this processor.
    pub fn best() -> Level {
        [Level::Eight, Level::Four].into_iter().find(|level| level.is_available()).unwrap_or(Level::One)
    }

    /// Whether this processor has it.
    pub fn is_available(self) -> bool {
        match self {
            Level::One => true,
            #[cfg(target_arch = "x86_64")]
            Level::Four => is_x86_feature_detected!("avx2"),
            #[cfg(target_arch = "x86_64")]
            Level::Eight => is_x86_feature_detected!("avx512f"),
            #[cfg(not(target_arch = "x86_64"))]
            Level::Four | Level::Eight => false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Angles from tiny to beyond what a joint can have.
    fn angles() -> impl Strategy<Value = [f64; MAX_LANES]> {
        prop::array::uniform8(prop_oneof![-1e-9..1e-9f64, -0.7..0.7f64, -4.0..4.0f64, -1e6..1e6f64])
    }

    fn packed<R: Real>(values: &[f64]) -> R {
        let mut number = R::zero();
        for (lane, &value) in values.iter().enumerate().take(R::LANES) {
            number.set_lane(lane, value);
        }
        number
    }

    /// A turn of size `angle` about an oblique axis.
    fn turn<R: Real>(angle: R) -> Vec3<R> {
        Vec3([angle * R::splat(0.6), angle * R::splat(-0.48), angle * R::splat(0.64)])
    }

    /// Whatever the neighbouring lanes hold, a lane gets the bits of `f64`.
    fn check<R: Real>(values: &[f64; MAX_LANES]) {
        R::vectorized(|| {
            let x: R = packed(values);
            let (sin, cos) = sin_cos(x);
            let rotation = rotation_exp(turn(x));
            let log = rotation_log(rotation);
            for (lane, &value) in values.iter().enumerate().take(R::LANES) {
                assert_eq!((sin.lane(lane), cos.lane(lane)), sin_cos(value));
                let alone = rotation_exp(turn(value));
                for (column, alone) in rotation.iter().zip(&alone) {
                    assert_eq!(column.0.map(|entry| entry.lane(lane)), alone.0);
                }
                assert_eq!(log.0.map(|entry| entry.lane(lane)), rotation_log(alone).0);
                assert_eq!(R::bits(x.sqrt().is_nan()) >> lane & 1 == 1, value < 0.0);
            }
        });
    }

    proptest! {
        #![proptest_config(crate::cases::cases(128))]

        #[test]
        fn lanes_have_the_bits_of_a_single_number(values in angles()) {
            for level in Level::available() {
                match level {
                    Level::One => check::<f64>(&values),
                    #[cfg(target_arch = "x86_64")]
                    Level::Four => check::<F64x4>(&values),
                    #[cfg(target_arch = "x86_64")]
                    Level::Eight => check::<F64x8>(&values),
                    #[cfg(not(target_arch = "x86_64"))]
                    _ => {}
                }
            }
        }

        #[test]
        fn rotations_are_those_of_poses(angle in -3.0..3.0f64, small in -0.1..0.1f64) {
            for angle in [angle, small, 0.0] {
                let vector = nalgebra::Vector3::from(turn(angle).0);
                let expected = crate::spatial::rotation_exp(vector);
                let columns = rotation_exp(turn(angle));
                for (column, expected) in columns.iter().zip(expected.column_iter()) {
                    prop_assert!((nalgebra::Vector3::from(column.0) - expected).norm() < 1e-15);
                }
                let log = nalgebra::Vector3::from(rotation_log(columns).0);
                prop_assert!((log - vector).norm() < 1e-14);
            }
        }
    }
}
