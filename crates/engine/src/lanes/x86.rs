//! Vector registers of x86-64: AVX2 (four lanes) and AVX-512 (eight).
//!
//! # Safety
//! The types of this file may only be used on a processor that has their instructions. `statics::Batch`, `machine::SideBySide` and
//! tests, all that name them, ask [`Level::is_available`](super::Level::is_available) first; the `unsafe` blocks rely on it.

use std::{
    arch::x86_64::*,
    ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign},
};

use super::Real;

/// Four numbers in an AVX register.
#[derive(Debug, Clone, Copy)]
#[repr(transparent)]
pub(crate) struct F64x4(__m256d);

/// Eight numbers in an AVX-512 register.
#[derive(Debug, Clone, Copy)]
#[repr(transparent)]
pub(crate) struct F64x8(__m512d);

macro_rules! operators {
    ($type:ident, $lanes:literal, $features:literal, $($operator:ident $method:ident $intrinsic:ident),+) => {
        $(
            impl $operator for $type {
                type Output = Self;
                #[inline(always)]
                fn $method(self, other: Self) -> Self {
                    // SAFETY: the processor has the instruction, see the top of this file.
                    Self(unsafe { $intrinsic(self.0, other.0) })
                }
            }
        )+

        impl AddAssign for $type {
            #[inline(always)]
            fn add_assign(&mut self, other: Self) {
                *self = *self + other;
            }
        }

        impl SubAssign for $type {
            #[inline(always)]
            fn sub_assign(&mut self, other: Self) {
                *self = *self - other;
            }
        }

        impl Neg for $type {
            type Output = Self;
            #[inline(always)]
            fn neg(self) -> Self {
                Self::splat(-0.0) - self
            }
        }

        impl $type {
            #[inline(always)]
            fn as_array(&self) -> &[f64; $lanes] {
                // SAFETY: the register is that many numbers side by side, and more strictly aligned than they are.
                unsafe { &*std::ptr::from_ref(self).cast() }
            }

            #[inline(always)]
            fn as_array_mut(&mut self) -> &mut [f64; $lanes] {
                // SAFETY: as in `as_array`.
                unsafe { &mut *std::ptr::from_mut(self).cast() }
            }

            #[inline]
            #[target_feature(enable = $features)]
            fn run<T>(work: impl FnOnce() -> T) -> T {
                work()
            }
        }
    };
}

operators!(F64x4, 4, "avx2", Add add _mm256_add_pd, Sub sub _mm256_sub_pd, Mul mul _mm256_mul_pd, Div div _mm256_div_pd);
operators!(F64x8, 8, "avx512f", Add add _mm512_add_pd, Sub sub _mm512_sub_pd, Mul mul _mm512_mul_pd, Div div _mm512_div_pd);

macro_rules! real {
    ($type:ident, $lanes:literal, $mask:ty, $($function:tt)+) => {
        impl Real for $type {
            const LANES: usize = $lanes;
            type Mask = $mask;

            #[inline(always)]
            fn lane(self, lane: usize) -> f64 {
                self.as_array()[lane]
            }

            #[inline(always)]
            fn set_lane(&mut self, lane: usize, value: f64) {
                self.as_array_mut()[lane] = value;
            }

            #[inline(always)]
            fn vectorized<T>(work: impl FnOnce() -> T) -> T {
                // SAFETY: the processor has the instructions, see the top of this file.
                unsafe { Self::run(work) }
            }

            $($function)+
        }
    };
}

// SAFETY of all blocks: the processor has the instruction, see the top of this file.
real! { F64x4, 4, __m256d,
    #[inline(always)]
    fn splat(value: f64) -> Self {
        Self(unsafe { _mm256_set1_pd(value) })
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(unsafe { _mm256_sqrt_pd(self.0) })
    }

    #[inline(always)]
    fn abs(self) -> Self {
        Self(unsafe { _mm256_andnot_pd(_mm256_set1_pd(-0.0), self.0) })
    }

    #[inline(always)]
    fn greater(self, other: Self) -> __m256d {
        unsafe { _mm256_cmp_pd::<_CMP_GT_OQ>(self.0, other.0) }
    }

    #[inline(always)]
    fn is_nan(self) -> __m256d {
        unsafe { _mm256_cmp_pd::<_CMP_UNORD_Q>(self.0, self.0) }
    }

    #[inline(always)]
    fn is_zero(self) -> bool {
        Self::bits(unsafe { _mm256_cmp_pd::<_CMP_NEQ_UQ>(self.0, _mm256_setzero_pd()) }) == 0
    }

    #[inline(always)]
    fn select(mask: __m256d, yes: Self, no: Self) -> Self {
        Self(unsafe { _mm256_blendv_pd(no.0, yes.0, mask) })
    }

    #[inline(always)]
    fn bits(mask: __m256d) -> u8 {
        unsafe { _mm256_movemask_pd(mask) as u8 }
    }

    #[inline(always)]
    fn mask(bits: u8) -> __m256d {
        let lane = |bit: u8| if bits & bit != 0 { -1 } else { 0 };
        unsafe { _mm256_castsi256_pd(_mm256_set_epi64x(lane(8), lane(4), lane(2), lane(1))) }
    }
}

real! { F64x8, 8, __mmask8,
    #[inline(always)]
    fn splat(value: f64) -> Self {
        Self(unsafe { _mm512_set1_pd(value) })
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(unsafe { _mm512_sqrt_pd(self.0) })
    }

    #[inline(always)]
    fn abs(self) -> Self {
        Self(unsafe { _mm512_abs_pd(self.0) })
    }

    #[inline(always)]
    fn greater(self, other: Self) -> __mmask8 {
        unsafe { _mm512_cmp_pd_mask::<_CMP_GT_OQ>(self.0, other.0) }
    }

    #[inline(always)]
    fn is_nan(self) -> __mmask8 {
        unsafe { _mm512_cmp_pd_mask::<_CMP_UNORD_Q>(self.0, self.0) }
    }

    #[inline(always)]
    fn is_zero(self) -> bool {
        unsafe { _mm512_cmp_pd_mask::<_CMP_NEQ_UQ>(self.0, _mm512_setzero_pd()) == 0 }
    }

    #[inline(always)]
    fn select(mask: __mmask8, yes: Self, no: Self) -> Self {
        Self(unsafe { _mm512_mask_blend_pd(mask, no.0, yes.0) })
    }

    #[inline(always)]
    fn bits(mask: __mmask8) -> u8 {
        mask
    }

    #[inline(always)]
    fn mask(bits: u8) -> __mmask8 {
        bits
    }
}
