//! Arithmetic for one case, or four or eight at once (SIMD): written once, with the same bits.
//!
//! Solving a machine takes the same operations at every point, so a vector register can hold one number for each of 4 or 8
//! points: its *lanes*. What is written once over [`Real`] is compiled for `f64` and for each kind of register; which of
//! them runs is decided when the program runs, by what the processor has ([`Level`]).
//!
//! Only operations that IEEE 754 rounds one way are used (no fused multiply-add, no approximations, sine and cosine of
//! our own), so a lane computes the same bits as `f64` does, on any processor.

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

pub use linear::solve;
pub(crate) use linear::{clear, copy, dot, pairs, subtract};
pub use tape::{Computation, Operation, OperationIndex};
pub use traced::{Traced, TracedMask, record};
pub use trigonometry::sin_cos;
pub(crate) use vector::{Frame, Screw};
pub use vector::{Vec3, rotation_exp, rotation_log};
#[cfg(target_arch = "x86_64")]
pub(crate) use x86::{F64x4, F64x8};

/// Largest number of lanes of any type; masks have one bit per lane.
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
    /// Result of a comparison, lane by lane.
    type Mask: Copy;

    /// The same number in all lanes.
    fn splat(value: f64) -> Self;
    /// Returns the number in `lane`.
    fn lane(self, lane: usize) -> f64;
    /// Replaces the number in `lane`.
    fn set_lane(&mut self, lane: usize, value: f64);
    /// Square root.
    fn sqrt(self) -> Self;
    /// Absolute value.
    fn abs(self) -> Self;
    /// Mask of the lanes where `self > other`; not those where either is NaN.
    fn greater(self, other: Self) -> Self::Mask;
    /// Mask of the lanes that are NaN.
    fn is_nan(self) -> Self::Mask;
    /// Takes `yes` where `mask` holds, `no` elsewhere.
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self;
    /// The mask as bits, lane 0 lowest.
    fn mask_to_bits(mask: Self::Mask) -> u8;
    /// The mask of the lanes whose bits are set, lane 0 lowest.
    fn mask_from_bits(bits: u8) -> Self::Mask;
    /// Whether all lanes hold zero.
    fn all_zero(self) -> bool;

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

    /// Bits of the lanes where `self > other`.
    #[inline(always)]
    fn lanes_greater(self, other: f64) -> u8 {
        Self::mask_to_bits(self.greater(Self::splat(other)))
    }

    /// The larger of two sizes (numbers without sign); NaN where either is, see [`crate::spatial::larger`].
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
    fn all_zero(self) -> bool {
        self == 0.0
    }

    #[inline(always)]
    fn mask_to_bits(mask: bool) -> u8 {
        u8::from(mask)
    }

    #[inline(always)]
    fn mask_from_bits(bits: u8) -> bool {
        bits & 1 == 1
    }
}

/// A computation written over [`Real`], to be run with the numbers of a [`Level`].
pub trait Lanewise {
    /// Result of the computation.
    type Output;

    /// Runs the computation with numbers of type `R`.
    fn run_with<R: Real>(self) -> Self::Output;
}

/// Number of points computed at a time.
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
    /// Levels that this processor has, ascending.
    pub fn available() -> Vec<Level> {
        [Level::One, Level::Four, Level::Eight].into_iter().filter(|level| level.is_available()).collect()
    }

    /// The highest level that this processor has.
    pub fn best() -> Level {
        [Level::Eight, Level::Four].into_iter().find(|level| level.is_available()).unwrap_or(Level::One)
    }

    /// Runs `work` with numbers of as many lanes as this level has, or of one lane where the processor lacks the level.
    pub fn run<W: Lanewise>(self, work: W) -> W::Output {
        match self {
            #[cfg(target_arch = "x86_64")]
            Level::Eight if self.is_available() => work.run_with::<F64x8>(),
            #[cfg(target_arch = "x86_64")]
            Level::Four if self.is_available() => work.run_with::<F64x4>(),
            _ => work.run_with::<f64>(),
        }
    }

    /// Whether this processor has the level.
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
